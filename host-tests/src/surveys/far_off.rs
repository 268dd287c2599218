//! Readings that are far off the reference at most stations: a unit, a sign or an axis of the file, or a
//! place, is then not what it was taken for, and no correction mends that.

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

#[cfg(test)]
mod tests {
    use super::*;

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
