//! The configuration of a flight: the trace's header, a file on top of it, the command line on top of that.

use std::path::Path;

use meerkat_mwd::{
    Config,
    config::{Earth, IdentificationConfig, Latency},
    probe::GAP_PERIODS,
};

use crate::{failure::Failure, trace::Trace};

/// Share by which a stated period may exceed the trace's median step: lost samples make steps longer, never
/// shorter.
const PERIOD_TOLERANCE: f64 = 0.2;

/// The configuration of a flight over `trace`: the header, the file's values if there is a file, and `on_top`
/// last.
///
/// # Errors
/// A configuration file that cannot be read or used, or a field out of its range.
pub fn configuration(trace: &Trace, file: Option<&Path>, on_top: impl FnOnce(&mut Config)) -> Result<Config, Failure> {
    let mut config = file.map_or_else(|| Ok(of_trace(trace)), |path| overlaid(trace, path))?;
    on_top(&mut config);
    checked(config, trace)
}

/// The configuration of a trace with a file's values on top, without a command line.
///
/// # Errors
/// A configuration file that cannot be read or used, or a field out of its range.
pub fn of_file(trace: &Trace, path: Option<&Path>) -> Result<Config, Failure> {
    configuration(trace, path, |_| {})
}

fn checked(config: Config, trace: &Trace) -> Result<Config, Failure> {
    config.validate().map_err(|error| {
        // An error that is there without the user's file is the trace's.
        if of_trace(trace).validate() != Err(error) {
            return Failure::Config(error);
        }
        let path = trace.path.display();
        Failure::BadInput(match error.field {
            // Nobody wrote this field: it is the trace's median step, so the message names the step.
            "sample_period_us" => {
                let step_s = median_step_s(trace);
                let unit = likely_unit(step_s)
                    .map_or_else(String::new, |unit| format!("; t_s looks like {unit}: t_s is in seconds"));
                format!("{path}: {error}, and the median step of the trace is {step_s} s{unit}")
            }
            _ => format!("{path}: {error}"),
        })
    })?;
    Ok(config)
}

/// Median step of a trace, seconds, of any length.
fn median_step_s(trace: &Trace) -> f64 {
    let times: Vec<u64> = trace.samples().map(|sample| sample.t_us).collect();
    let mut steps: Vec<u64> = times.iter().zip(times.iter().skip(1)).map(|(a, b)| b.saturating_sub(*a)).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable(middle).1 as f64 / 1e6 }
}

/// Unit in which steps that are none in seconds would be those of 20 Hz to 10 kHz.
fn likely_unit(step_s: f64) -> Option<&'static str> {
    let units = [("milliseconds", 1e-3), ("microseconds", 1e-6), ("nanoseconds", 1e-9)];
    units.into_iter().find(|(_, in_s)| (1e-4..=0.05).contains(&(step_s * in_s))).map(|(unit, _)| unit)
}

/// Configuration that the trace's header states: full scales, the gyro's delay, the kind of motion, the earth; the
/// median step is the nominal period.
#[must_use]
pub fn of_trace(trace: &Trace) -> Config {
    let keys = &trace.keys;
    let default = Config::default();
    let radians = |degrees: Option<f64>| degrees.map(|x| x.to_radians() as f32);
    Config {
        sample_period_us: match trace.nominal_period_us() {
            0 => default.sample_period_us,
            median => median,
        },
        full_scale: keys.full_scale(),
        earth: Earth {
            gravity_m_s2: keys.gravity_m_s2.map_or(default.earth.gravity_m_s2, |x| x as f32),
            magnetic_field_ut: keys.magnetic_field_ut.map(|x| x as f32),
            dip_rad: radians(keys.dip_deg),
            declination_rad: radians(keys.magnetic_declination_deg),
            latitude_rad: radians(keys.latitude_deg),
        },
        identification: IdentificationConfig { motion: keys.motion(), ..default.identification },
        latency: Latency { gyro_s: keys.gyro_delay_s.map(|x| x as f32), ..default.latency },
        ..default
    }
}

/// Time from which the last `fraction` of the trace is held out, microseconds.
#[must_use]
pub fn freeze_at_us(trace: &Trace, fraction: f64) -> u64 {
    trace.first_us() + ((1.0 - fraction) * trace.duration_us() as f64).round() as u64
}

/// Field of a configuration's file that is the host's alone: the instant of a freeze, microseconds.
const FREEZE: &str = "freeze_at_us";

/// Instant from which a flight over `trace` learns nothing new, microseconds: that of the hold-out, else the file's.
/// Where units, signs or axes cannot be, nothing is learnt at all: a model of such readings would be of their units.
///
/// # Errors
/// The file cannot be read, or its instant is none.
pub fn frozen_from_us(trace: &Trace, hold_out: Option<f64>, file: Option<&Path>) -> Result<Option<u64>, Failure> {
    if !trace.wrong.is_empty() {
        return Ok(Some(0));
    }
    match (hold_out, file) {
        (Some(fraction), _) => Ok(Some(freeze_at_us(trace, fraction))),
        (None, None) => Ok(None),
        (None, Some(path)) => {
            let at_us = table(path)?.remove(FREEZE).map(|at| at.as_integer().and_then(|at| u64::try_from(at).ok()));
            let bad = || Failure::BadInput(format!("{}: {FREEZE} must be whole microseconds", path.display()));
            at_us.map(|at_us| at_us.ok_or_else(bad)).transpose()
        }
    }
}

/// Reads a configuration's file.
fn table(path: &Path) -> Result<toml::Table, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::unread(path, &error))?;
    text.parse().map_err(|error: toml::de::Error| Failure::BadInput(format!("{}: {error}", path.display())))
}

/// The header's configuration with the file's values on top, table by table: a key that the file does not
/// name keeps its value.
fn overlaid(trace: &Trace, path: &Path) -> Result<Config, Failure> {
    let bad = |what: String| Failure::BadInput(format!("{}: {what}", path.display()));
    let mut file = table(path)?;
    file.remove(FREEZE);
    let mut merged = toml::Table::try_from(of_trace(trace)).map_err(|e| bad(e.to_string()))?;
    overlay(&mut merged, file);
    let config: Config =
        merged.try_into().map_err(|e: toml::de::Error| bad(e.to_string().trim_end().replace('\n', " ")))?;
    // If the file is silent the period is the median step itself; a trace of one sample has no step.
    let (stated, median) = (config.sample_period_us, trace.nominal_period_us());
    let all_are_gaps = u64::from(median) > u64::from(GAP_PERIODS) * u64::from(stated);
    if median > 0 && (all_are_gaps || f64::from(stated) > (1.0 + PERIOD_TOLERANCE) * f64::from(median)) {
        return Err(bad(format!("sample_period_us is {stated}, but the median step of the trace is {median}")));
    }
    Ok(config)
}

fn overlay(base: &mut toml::Table, on_top: toml::Table) {
    for (key, value) in on_top {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(above)) => overlay(below, above),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use meerkat_mwd::{Sample, config::Motion};

    use super::*;
    use crate::trace::Keys;

    fn trace() -> Trace {
        let samples = (0..11).map(|i| Sample { t_us: 2_000_000 + 3_500 * i, ..Sample::default() }).collect();
        let keys =
            Keys { gravity_m_s2: Some(9.81), dip_deg: Some(70.0), gyro_full_scale_rad_s: Some(8.7), ..Keys::default() };
        Trace { samples, keys, ..Trace::default() }
    }

    fn overlay_with(text: &str) -> Result<Config, Failure> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        overlaid(&trace(), file.path())
    }

    #[test]
    fn a_file_that_names_nothing_changes_nothing_to_the_last_bit() {
        assert_eq!(overlay_with(""), Ok(of_trace(&trace())));
    }

    #[test]
    fn the_file_wins_where_it_speaks_and_the_trace_where_it_does_not() {
        let config =
            overlay_with("[earth]\ngravity_m_s2 = 9.79\n[identification]\nwindow_s = 40\noptimizer = 'lm'").unwrap();
        assert_eq!(config.earth.gravity_m_s2, 9.79);
        assert_eq!(config.earth.dip_rad, Some(70.0_f32.to_radians()));
        assert_eq!(config.full_scale.gyro_rad_s, Some(8.7));
        assert_eq!(config.identification.window_s, 40.0);
        assert_eq!(config.sample_period_us, 3_500);
    }

    #[test]
    fn the_file_may_say_what_moves_the_probe() {
        assert_eq!(overlay_with("").unwrap().identification.motion, Motion::Hand);
        let config = overlay_with("[identification]\nmotion = 'drill_string'").unwrap();
        assert_eq!(config.identification.motion, Motion::DrillString);
    }

    #[test]
    fn an_unknown_field_is_named() {
        let message = |text| overlay_with(text).unwrap_err().to_string();
        assert!(message("[identification]\nwindow = 40").contains("`window`"));
        assert!(message("speed = 1").contains("`speed`"));
        assert!(message("[gyro]\np = 1").contains('p'));
    }

    #[test]
    fn a_period_that_is_not_the_traces_is_refused_with_both() {
        // Lost samples make the median step longer than intended.
        for stated in [1_167, 2_800, 3_500, 4_200] {
            assert_eq!(overlay_with(&format!("sample_period_us = {stated}")).unwrap().sample_period_us, stated);
        }
        for stated in [0, 1_000, 1_166, 4_201, 7_000] {
            let message = overlay_with(&format!("sample_period_us = {stated}")).unwrap_err().to_string();
            let both = format!("sample_period_us is {stated}, but the median step of the trace is 3500");
            assert!(message.ends_with(&both), "{message}");
        }
    }

    #[test]
    fn a_flight_is_frozen_by_the_hold_out_or_by_the_file_and_from_the_start_where_axes_cannot_be() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "freeze_at_us = 2_020_000\nseed = 7").unwrap();
        let (mut trace, path) = (trace(), Some(file.path()));
        assert_eq!(of_file(&trace, path).unwrap().seed, 7);
        assert_eq!(frozen_from_us(&trace, None, None), Ok(None));
        assert_eq!(frozen_from_us(&trace, None, path), Ok(Some(2_020_000)));
        assert_eq!(frozen_from_us(&trace, Some(0.5), path), Ok(Some(2_017_500)));
        trace.wrong.push(String::new());
        assert_eq!(frozen_from_us(&trace, Some(0.5), path), Ok(Some(0)));
        std::fs::write(file.path(), "freeze_at_us = -1").unwrap();
        trace.wrong.clear();
        assert!(frozen_from_us(&trace, None, path).unwrap_err().to_string().contains("freeze_at_us must be"));
    }

    #[test]
    fn the_hold_out_counts_from_the_first_sample() {
        assert_eq!(freeze_at_us(&trace(), 0.5), 2_017_500);
    }
}
