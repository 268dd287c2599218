//! Two or three effects at once, drawn at random.

use meerkat_mwd::compensation::effects::LIBRARY;

use super::{
    cases::{CASES, Case},
    trial::{DATA_S, diagnose, drilled},
};
use testbed::study::{Cell, Effort, Table, seeds::each_seed};

/// Groups to draw from: effects that are named in most runs in which they are alone. At most one of each
/// group, because those of a group cannot be told from each other or from their sum.
const GROUPS: [&[&str]; 7] = [
    &["mag_lag", "gyro_lag", "accel_lag", "eddy_lag"],
    &["hard_iron", "soft_iron", "axial_interference"],
    &["accel_bias"],
    &["lever_arm"],
    &["g_sensitivity, three times as large"],
    &["gyro_bias_temperature"],
    &["gyro_scale_nonlinearity"],
];

/// First seed; no other table of effects uses these seeds.
const FIRST_SEED: u64 = 20_000;

/// One run.
struct Trial {
    drawn: Vec<&'static Case>,
    found: Vec<&'static str>,
}

impl Trial {
    /// Returns true if all are named by their own names, and nothing else is.
    fn exact(&self) -> bool {
        let own = |case: &&Case| case.own_name().is_some_and(|name| self.found.contains(&name));
        self.found.len() == self.drawn.len() && self.drawn.iter().all(own)
    }
    /// Returns true if all are named, by their own names or by ones that cannot be told from them.
    fn all_named(&self) -> bool {
        self.drawn.iter().all(|case| case.is_named_by(&self.found))
    }
    /// Returns true if something is named that is not there.
    fn false_name(&self) -> bool {
        self.found.iter().any(|name| self.drawn.iter().all(|case| !case.allows(name)))
    }
}

pub(super) fn tables(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let runs = effort.repetitions(36);
    let trials = each_seed(FIRST_SEED..FIRST_SEED + runs, trial)?;
    let mut counts = Table::new(
        format!(
            "Two, three or four effects at once, drawn at random from those that show alone, drilling at 45 deg, {DATA_S} s: runs in which \
             exactly these are named, each by its own name; in which all are named and nothing else, by their own names or by such \
             as cannot be told from them (target: 11 of 12); and in which another effect is named"
        ),
        &["effects", "runs", "exactly", "right", "some left out, none false", "a false name"],
    );
    for (name, size) in [("two", Some(2)), ("three", Some(3)), ("four", Some(4)), ("all", None)] {
        let of_size: Vec<&Trial> =
            trials.iter().filter(|trial| size.is_none_or(|size| trial.drawn.len() == size)).collect();
        let count =
            |is: &dyn Fn(&Trial) -> bool| Cell::number(of_size.iter().filter(|trial| is(trial)).count() as f64, 0);
        counts.row([
            name.into(),
            Cell::number(of_size.len() as f64, 0),
            count(&Trial::exact),
            count(&|trial| trial.all_named() && !trial.false_name()),
            count(&|trial| !trial.all_named() && !trial.false_name()),
            count(&Trial::false_name),
        ]);
    }
    let mut others = Table::new("Those of them in which not exactly these are named", &["there", "named"]);
    for trial in trials.iter().filter(|trial| !trial.exact()) {
        let there: Vec<&str> = trial.drawn.iter().map(|case| case.name).collect();
        others.row([there.join("; "), trial.found.join("; ")]);
    }
    Ok(vec![counts, others])
}

/// Two effects, three, four, from seed to seed.
fn trial(seed: u64) -> anyhow::Result<Trial> {
    let mut drawn: Vec<&'static Case> = Vec::new();
    let scenario = drilled(45.0, seed, |scenario, random| {
        let mut groups: Vec<&[&str]> = GROUPS.to_vec();
        for _ in 0..2 + seed % 3 {
            let group = groups.swap_remove(random.index(groups.len()));
            let name = group.get(random.index(group.len()));
            drawn.extend(CASES.iter().find(|case| Some(&case.name) == name));
        }
        for case in &drawn {
            (case.add)(scenario, random);
        }
    })?;
    Ok(Trial { drawn, found: diagnose(&scenario, seed, &LIBRARY)?.names })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A draw would never choose an effect that is missing here.
    #[test]
    fn every_name_that_is_drawn_from_is_a_case() {
        for name in GROUPS.iter().copied().flatten() {
            let case = CASES.iter().find(|case| case.name == *name).unwrap();
            assert!(
                case.effects.len() == 1 && LIBRARY.iter().any(|effect| Some(effect.name()) == case.own_name()),
                "{name}"
            );
        }
    }

    #[test]
    fn an_alias_is_right_and_not_exact_and_what_is_not_there_is_false() {
        let case = |name: &str| CASES.iter().find(|case| case.name == name).unwrap();
        let of = |found: &[&'static str]| {
            let trial = Trial { drawn: vec![case("mag_lag"), case("lever_arm")], found: found.to_vec() };
            (trial.exact(), trial.all_named(), trial.false_name())
        };
        assert_eq!(of(&["lever_arm", "mag_lag"]), (true, true, false));
        assert_eq!(of(&["eddy_lag", "lever_arm"]), (false, true, false));
        assert_eq!(of(&["mag_lag"]), (false, false, false));
        assert_eq!(of(&["mag_lag", "lever_arm", "accel_bias"]), (false, true, true));
    }
}
