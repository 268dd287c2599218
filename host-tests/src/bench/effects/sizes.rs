//! Sizes that are found, against those that were drawn: how often the truth lies within the stated deviations.

use meerkat_mwd::compensation::{
    Effect, GyroModel,
    effects::{
        AccelBias, AccelLag, AxialInterference, EddyLag, GSensitivity, GyroBiasStep, GyroBiasTemperature, GyroLag,
        GyroScaleAsymmetry, GyroScaleNonlinearity, GyroScaleTemperature, HardIron, LeverArm, MagLag,
        VibrationRectification,
    },
};
use nalgebra::{Matrix3, Vector3};

use super::{Trial, cases::Case};
use testbed::simulate::{Effects, Scenario};
use testbed::study::{Cell, Table, median, rms};

/// Share of a normal distribution within one and within two deviations, percent.
const NORMAL_PERCENT: [u32; 2] = [68, 95];

/// The sizes that a scenario has of a case's own effect, in the library's order and units of display; `None` where
/// their order or units are others (soft iron), or several.
///
/// The simulator adds the gyro's effects to its reading, the library takes them out of the compensated rate: between
/// the two stands P. A factor k u^3 of each axis has k / P_ii^2 there, but for P's other elements.
pub(super) fn drawn(case: &Case, scenario: &Scenario, gyro: &GyroModel) -> Option<Vec<f64>> {
    let own = case.own_name().filter(|_| case.is_alone())?;
    let (_, sizes) = SIZES.iter().find(|(effect, _)| effect.name() == own)?;
    Some(sizes(&scenario.effects, &gyro.p_matrix().cast::<f64>()))
}

/// Sizes of an effect among those that were drawn, by the gyro's P.
type Sizes = fn(&Effects, &Matrix3<f64>) -> Vec<f64>;

const SIZES: [(&dyn Effect, Sizes); 15] = [
    (&MagLag, |drawn, _| vec![drawn.mag_lag_ms]),
    (&GyroLag, |drawn, _| vec![drawn.gyro_lag_ms]),
    (&AccelLag, |drawn, _| vec![drawn.accel_lag_ms]),
    (&EddyLag, |drawn, _| vec![drawn.eddy_lag_ms]),
    (&HardIron, |drawn, _| drawn.hard_iron_ut.to_vec()),
    (&AxialInterference, |drawn, _| vec![drawn.hard_iron_ut[2]]),
    (&AccelBias, |drawn, _| drawn.accel_bias_m_s2.to_vec()),
    (&LeverArm, |drawn, _| drawn.lever_arm_mm.to_vec()),
    // Row by row.
    (&GSensitivity, |drawn, p| {
        let [x, y, z] = drawn.g_sensitivity_deg_s_g;
        let columns = [0, 1, 2].map(|k| compensated(p, [x[k], y[k], z[k]]));
        (0..3).flat_map(|row| columns.iter().filter_map(move |column| column.get(row))).copied().collect()
    }),
    (&GyroBiasTemperature, |drawn, p| compensated(p, drawn.gyro_bias_temperature_deg_s_c)),
    (&GyroScaleTemperature, |drawn, _| drawn.gyro_scale_temperature_percent_c.to_vec()),
    (&GyroBiasStep, |drawn, p| compensated(p, drawn.bias_step_deg_s)),
    (&VibrationRectification, |drawn, p| compensated(p, drawn.vibration_rectification_deg_s_g2)),
    (&GyroScaleNonlinearity, |drawn, p| {
        let scales = p.diagonal();
        let cubes = drawn.gyro_scale_nonlinearity_s2_rad2.iter().zip(scales.iter());
        cubes.map(|(k, scale)| k / (scale * scale)).collect()
    }),
    (&GyroScaleAsymmetry, |drawn, _| drawn.gyro_scale_asymmetry.map(|share| 100.0 * share).to_vec()),
];

/// An effect of the gyro's reading as one of the compensated rate.
fn compensated(p: &Matrix3<f64>, reading: [f64; 3]) -> Vec<f64> {
    (p * Vector3::from(reading)).iter().copied().collect()
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
