//! Sizes that are found, against those that were drawn: how often the truth lies within the stated deviations.

use meerkat_mwd::compensation::GyroModel;
use nalgebra::Vector3;

use super::{Trial, cases::Case};
use testbed::simulate::Scenario;
use testbed::study::{Cell, Table, median, rms};

/// Share of a normal distribution within one and within two deviations, percent.
const NORMAL_PERCENT: [u32; 2] = [68, 95];

/// The sizes that a scenario has of a case's own effect, in the library's order and units of display; `None` where
/// their order or units are others (soft iron), or several.
///
/// The simulator adds the gyro's effects to its reading, the library takes them out of the compensated rate: between
/// the two stands P. A factor k u^3 of each axis has k / P_ii^2 there, but for P's other elements.
pub(super) fn drawn(case: &Case, scenario: &Scenario, gyro: &GyroModel) -> Option<Vec<f64>> {
    let effects = &scenario.effects;
    let own = case.own_name().filter(|_| case.is_alone())?;
    let p = gyro.p_matrix().cast::<f64>();
    let compensated = |v: [f64; 3]| (p * Vector3::from(v)).iter().copied().collect::<Vec<f64>>();
    Some(match own {
        "mag_lag" => vec![effects.mag_lag_ms],
        "gyro_lag" => vec![effects.gyro_lag_ms],
        "accel_lag" => vec![effects.accel_lag_ms],
        "eddy_lag" => vec![effects.eddy_lag_ms],
        "hard_iron" => effects.hard_iron_ut.to_vec(),
        "axial_interference" => vec![effects.hard_iron_ut[2]],
        "accel_bias" => effects.accel_bias_m_s2.to_vec(),
        "lever_arm" => effects.lever_arm_mm.to_vec(),
        // Row by row.
        "g_sensitivity" => {
            let [x, y, z] = effects.g_sensitivity_deg_s_g;
            let columns = [0, 1, 2].map(|k| compensated([x[k], y[k], z[k]]));
            (0..3).flat_map(|row| columns.iter().filter_map(move |column| column.get(row))).copied().collect()
        }
        "gyro_bias_temperature" => compensated(effects.gyro_bias_temperature_deg_s_c),
        "gyro_scale_temperature" => effects.gyro_scale_temperature_percent_c.to_vec(),
        "gyro_bias_step" => compensated(effects.bias_step_deg_s),
        "vibration_rectification" => compensated(effects.vibration_rectification_deg_s_g2),
        "gyro_scale_nonlinearity" => {
            let scales = p.diagonal();
            let cubes = effects.gyro_scale_nonlinearity_s2_rad2.iter().zip(scales.iter());
            cubes.map(|(k, scale)| k / (scale * scale)).collect()
        }
        "gyro_scale_asymmetry" => effects.gyro_scale_asymmetry.map(|share| 100.0 * share).to_vec(),
        _ => return None,
    })
}

pub(super) fn table(hole: &str) -> Table {
    let [one, two] = NORMAL_PERCENT;
    Table::new(
        format!(
            "Sizes of the same runs, where the effect is named by its own name, drilling at {hole}: parameters whose truth is within one and \
             within two stated deviations of what is found, % (a normal distribution: {one} and {two}); rms of error over deviation; and the \
             vector's error over its length, median"
        ),
        &["effect", "runs", "parameters", "within one", "within two", "rms of error over deviation", "error / size"],
    )
}

/// A case's row; `None` where its sizes cannot be compared, or where it is never named.
pub(super) fn row(case: &Case, trials: &[Trial]) -> Option<Vec<Cell>> {
    let own = case.own_name()?;
    let compared: Vec<(&[f64], &[[f64; 2]])> =
        trials.iter().filter_map(|trial| Some((trial.drawn.as_deref()?, trial.outcome.sizes_of(own)?))).collect();
    if compared.is_empty() {
        return None;
    }
    let scaled: Vec<f64> = compared
        .iter()
        .flat_map(|(drawn, found)| drawn.iter().zip(*found).map(|(truth, [size, sigma])| (size - truth) / sigma))
        .collect();
    let relative: Vec<f64> = compared
        .iter()
        .map(|(drawn, found)| {
            let off: Vec<f64> = drawn.iter().zip(*found).map(|(truth, [size, _])| size - truth).collect();
            rms(&off) / rms(drawn)
        })
        .collect();
    let within = |deviations: f64| {
        Cell::percent(scaled.iter().filter(|off| off.abs() <= deviations).count() as f64 / scaled.len() as f64, 0)
    };
    Some(vec![
        case.name.into(),
        Cell::number(compared.len() as f64, 0),
        Cell::number(scaled.len() as f64, 0),
        within(1.0),
        within(2.0),
        Cell::number(rms(&scaled), 2),
        Cell::number(median(&relative), 3),
    ])
}
