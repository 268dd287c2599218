//! Readings that are off the reference. Far off at most stations: a unit, a sign or an axis of the file, or a place, is
//! then not what it was taken for, and no correction mends that. Off at one of them: that survey is doubtful.

use meerkat_mwd::config::SurveyLimits;

/// Differences of gravity, m/s^2, field, microtesla, and dip, degrees, that are ten times those within which
/// surveys are usually accepted: 3 mg, 300 nT and 0.25 deg (the latter two: ISCWSA, Introduction to wellbore
/// positioning, 22.1).
const FAR: [f64; 3] = [0.3, 3.0, 2.5];
/// Name of each difference, its unit, and its remedy.
const WORDS: [[&str; 3]; 3] = [
    ["gravity", "m/s^2", "check the unit of the gravity columns"],
    ["the field", "microtesla", "check the unit of the field columns, the place, and for magnets"],
    ["the dip", "deg", "check signs (gx_g .. point down, ax_m_s2 .. up), the order of axes, and the place"],
];

/// A sentence for each of the three that is far off at more than half of the stations.
pub fn far_off(off_reference: &[[f64; 3]]) -> Vec<String> {
    let of = |k: usize| {
        let mut off: Vec<f64> = off_reference.iter().filter_map(|off| off.get(k)).copied().collect();
        off.sort_by(f64::total_cmp);
        off.get(off.len() / 2).copied()
    };
    let each = FAR.iter().zip(WORDS).enumerate();
    each.filter_map(|(k, (far, [what, unit, mend]))| {
        let off = of(k).filter(|off| off.abs() > *far)?;
        Some(format!("{what} is {off:+.2} {unit} off the reference (median of the stations): {mend}"))
    })
    .collect()
}

/// Depths that a warning names.
const NAMED: usize = 10;

/// Limits of |G| m/s^2, |B| microtesla and dip degrees, as the probe has them for its surveys.
pub fn limits() -> [f64; 3] {
    let SurveyLimits { gravity_m_s2, field_ut, dip_rad, .. } = SurveyLimits::default();
    [gravity_m_s2, field_ut, dip_rad.to_degrees()].map(f64::from)
}

/// Returns true if gravity, field or dip is further off the reference than a good survey's may be.
pub fn is_off(off: &[f64; 3]) -> bool {
    // A value that is no number is off, too.
    !off.iter().zip(limits()).all(|(off, limit)| off.abs() <= limit)
}

/// A sentence for the stations, by their depths, that are off by more than surveys are accepted with; `None` if none
/// is.
pub fn off_at(stations: &[(f64, [f64; 3])]) -> Option<String> {
    let depths: Vec<String> =
        stations.iter().filter(|(_, off)| is_off(off)).map(|(md_m, _)| format!("{md_m:.1}")).collect();
    (!depths.is_empty()).then(|| {
        format!(
            "{} of {} stations read gravity, field or dip off the reference by more than surveys are accepted with (2.5 mg, 300 \
             nT, 0.25 deg): {}",
            depths.len(),
            stations.len(),
            at(&depths)
        )
    })
}

/// Depths as a warning names them: the first ones, and how many more there are.
pub(super) fn at(depths: &[String]) -> String {
    let named = depths.get(..NAMED).unwrap_or(depths).join(", ");
    match depths.len().saturating_sub(NAMED) {
        0 => format!("at {named} m"),
        more => format!("at {named} m and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn each_station_that_is_off_is_told_by_its_depth() {
        let good = [0.02, -0.29, 0.24];
        assert_eq!(off_at(&[(1.0, good), (2.0, good)]), None);
        let told = off_at(&[(1.0, good), (2.0, [0.0, 0.31, 0.0]), (3.5, [0.0, 0.0, f64::NAN])]).unwrap();
        assert!(told.starts_with("2 of 3 stations") && told.ends_with("at 2.0, 3.5 m"), "{told}");
        let all: Vec<(f64, [f64; 3])> = (0..12).map(|k| (f64::from(k), [0.1, 0.0, 0.0])).collect();
        assert!(off_at(&all).unwrap().ends_with("8.0, 9.0 m and 2 more"));
    }

    #[test]
    fn what_is_off_at_most_stations_is_told_and_what_is_off_at_some_is_not() {
        assert!(far_off(&[]).is_empty() && far_off(&[[0.1, 1.0, -1.0]; 5]).is_empty());
        let reversed = [[0.0, 0.1, -144.0], [0.0, 0.1, -144.2], [0.0, 0.1, -144.1]];
        let told = far_off(&reversed);
        assert!(told.len() == 1 && told.iter().all(|t| t.contains("the dip is -144.10 deg") && t.contains("signs")));
        assert!(far_off(&[[0.0, 9.0, 0.0], [0.0; 3], [0.0; 3]]).is_empty());
        assert_eq!(far_off(&[[-9.7, -49.9, 0.0]; 4]).len(), 2);
    }
}
