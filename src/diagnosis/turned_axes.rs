use super::report::MAX_CANDIDATES;
use crate::compensation::{Effect, Moment, Parameter, Sensor, effects::SoftIron};
use nalgebra::Vector3;

/// Axes of the magnetometer that have turned: tried beside a library that has no such effect. P takes them where nothing else does, and
/// gravity then shows a bent P like an error of the accelerometer.
struct TurnedAxes;

/// Where soft iron has them.
const FIRST: usize = 5;

impl Effect for TurnedAxes {
    fn name(&self) -> &'static str {
        "turned_axes"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Magnetometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        SoftIron.parameters().get(FIRST..).unwrap_or_default()
    }

    fn term(&self, k: usize, moment: &Moment) -> Vector3<f32> {
        SoftIron.term(FIRST + k, moment)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &[]
    }
}

/// The library, and what turns the magnetometer's axes if it has nothing of the kind.
#[inline(never)]
pub(crate) fn candidates(library: &[&'static dyn Effect]) -> heapless::Vec<&'static dyn Effect, MAX_CANDIDATES> {
    let mut candidates = heapless::Vec::new();
    for &effect in library {
        // What there is no room for is not tried.
        let _ = candidates.push(effect);
    }
    let turns_axes = |effect: &&dyn Effect| effect.parameters().iter().any(|parameter| parameter.turns_axes);
    if !library.iter().any(turns_axes) {
        let _ = candidates.push(&TurnedAxes);
    }
    candidates
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::effects::LIBRARY;
    extern crate std;
    use std::vec::Vec;

    #[test]
    fn it_is_those_parts_of_soft_iron_that_turn_axes_and_is_tried_only_where_nothing_else_has_them() {
        let turning =
            SoftIron.parameters().iter().filter(|parameter| parameter.turns_axes).map(|parameter| parameter.name);
        assert!(turning.eq(TurnedAxes.parameters().iter().map(|parameter| parameter.name)));
        assert_eq!(TurnedAxes.parameters().len(), 3);
        assert_eq!(candidates(&LIBRARY).len(), LIBRARY.len());
        let without: Vec<_> = LIBRARY.into_iter().filter(|effect| effect.name() != "soft_iron").collect();
        let tried = candidates(&without);
        assert_eq!(tried.len(), without.len() + 1);
        assert_eq!(tried.last().map(|effect| effect.name()), Some("turned_axes"));
    }
}
