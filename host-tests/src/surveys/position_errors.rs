//! Covariance of positions by the ISCWSA's MWD error model, revision 5: how the terms of a tool code add up along the
//! well. Williamson, SPE 67616 (2000).
//!
//! A term's error turns a station by dI and dA and moves it by dD along the hole. Positions follow by the balanced
//! tangential method, as the model prescribes.

use nalgebra::{Matrix3, Vector3};

use super::{
    path::Direction,
    term_weights::{At, ModelStation, Weights},
    tool_codes::{Propagation, Term},
};

/// Covariances of the stations' positions, north, east and down, m^2, by all terms together. A first station at depth
/// zero has the error of its depth; one further down is the start, and has none.
#[must_use]
pub fn covariances(stations: &[ModelStation], terms: &[Term]) -> Vec<Matrix3<f64>> {
    let mut sums = vec![Matrix3::zeros(); stations.len()];
    for term in terms {
        add(&mut sums, stations, term);
    }
    sums
}

/// Adds a term's covariance: at the station itself the error of the leg before it, further down that of both legs.
pub fn add(sums: &mut [Matrix3<f64>], stations: &[ModelStation], term: &Term) {
    let (mut carried, mut carried_square) = (Vector3::zeros(), Matrix3::zeros());
    let root = stations.first().is_some_and(|first| first.direction.md_m == 0.0);
    for (k, (sum, station)) in sums.iter_mut().zip(stations).enumerate() {
        let before = k.checked_sub(1).and_then(|before| stations.get(before));
        let weights = (term.weigh)(&At::of(before, station));
        let Some(before) = before else {
            if root {
                *sum += outer(&(station.direction.tangent() * (weights.depth * term.sigma)));
            }
            continue;
        };
        // The slot's own attitude is as uncertain as the first survey's: that one counts for the whole first leg
        // (definition of the error model, 4.7.1.1).
        let share = if root && k == 1 { 1.0 } else { 0.5 };
        let moved = |after: Option<&ModelStation>| {
            let after = after.map(|after| after.direction);
            moved(&before.direction, &station.direction, after.as_ref(), share, &weights) * term.sigma
        };
        let (last, through) = (moved(None), moved(stations.get(k + 1)));
        *sum += match term.propagation {
            Propagation::Systematic => outer(&(carried + last)),
            Propagation::Random => carried_square + outer(&last),
        };
        carried += through;
        carried_square += outer(&through);
    }
}

fn outer(v: &Vector3<f64>) -> Matrix3<f64> {
    v * v.transpose()
}

/// Change of a station's position by its own error, or of those further down, where there is one `after` it. `share` of
/// the leg before turns with it, and half of the leg after.
fn moved(
    before: &Direction,
    here: &Direction,
    after: Option<&Direction>,
    share: f64,
    weights: &Weights,
) -> Vector3<f64> {
    let course = here.md_m - before.md_m;
    let (si, ci) = libm::sincos(here.inclination_rad);
    let (sa, ca) = libm::sincos(here.azimuth_rad);
    let turned =
        Vector3::new(ci * ca, ci * sa, -si) * weights.inclination + Vector3::new(-sa, ca, 0.0) * weights.across;
    if weights.own_leg {
        return turned * course;
    }
    let (leg, length) = match after {
        Some(after) => ((before.tangent() - after.tangent()) * 0.5, share * course + 0.5 * (after.md_m - here.md_m)),
        None => ((before.tangent() + here.tangent()) * 0.5, share * course),
    };
    leg * weights.depth + turned * length
}

/// Half axes of the horizontal ellipse of one standard deviation, metres, the larger first, and the azimuth of that
/// one, radians, 0 to pi.
#[must_use]
pub fn horizontal_ellipse(covariance: &Matrix3<f64>) -> ([f64; 2], f64) {
    let (nn, ee, ne) = (covariance.m11, covariance.m22, covariance.m12);
    let (mean, spread) = (0.5 * (nn + ee), libm::hypot(0.5 * (nn - ee), ne));
    let axes = [mean + spread, (mean - spread).max(0.0)].map(libm::sqrt);
    let azimuth = 0.5 * libm::atan2(2.0 * ne, nn - ee);
    (axes, if azimuth < 0.0 { azimuth + std::f64::consts::PI } else { azimuth })
}
