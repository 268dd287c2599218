//! A run's stations corrected together, as a probe can do it between two stops: what the `Surveyor` averages at each
//! stop goes into a `MultiStation`, which finds the field of the drill string.
//!
//! `cargo run --example survey_run`

use meerkat_mwd::{
    config::{ConfigError, Earth, SurveyConfig},
    survey::{
        SurveyInput, SurveyNews, Surveyor,
        multi_station::{MultiStation, MultiStationSettings, Station, StationReference},
    },
};
use nalgebra::{Rotation3, Vector3};

/// Field of the drill string along the tool axis, microtesla.
const STRING_UT: f32 = -0.9;
const REFERENCE: StationReference = StationReference { gravity_m_s2: 9.81, field_ut: 50.0, dip_rad: 1.25 };

/// Largest errors of the azimuth before and after, radians, over the last ten of 30 stations.
pub(crate) fn run() -> Result<[f32; 2], ConfigError> {
    let (earth, config) = (Earth { gravity_m_s2: REFERENCE.gravity_m_s2, ..Earth::default() }, SurveyConfig::default());
    let (mut surveyor, mut stations) = (Surveyor::new(), MultiStation::new());
    surveyor.configure(&earth, &config)?;
    let (mut t_us, mut worst) = (0, [0.0_f32; 2]);
    for k in 0..30_u8 {
        let depth = f32::from(k);
        let (inclination, azimuth, toolface) = (0.1 + 0.04 * depth, 0.9 + 0.005 * depth, 2.4 * depth);
        let tool = (Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), inclination)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), toolface))
        .inverse();
        let down = tool * Vector3::new(0.0, 0.0, REFERENCE.gravity_m_s2);
        let north =
            Vector3::new(libm::cosf(REFERENCE.dip_rad), 0.0, libm::sinf(REFERENCE.dip_rad)) * REFERENCE.field_ut;
        let field = tool * north + Vector3::new(0.0, 0.0, STRING_UT);
        // Two seconds of motion, and a stop of 28 s.
        for step in 0..3_000_u32 {
            t_us += 10_000;
            let input = SurveyInput {
                t_us,
                rate_rad_s: Some(if step < 200 { [0.0, 0.0, 1.0] } else { [0.0; 3] }),
                force_m_s2: Some((-down).into()),
                field_ut: Some(field.into()),
                ..SurveyInput::default()
            };
            // From a probe: `probe.survey_input(&sample, &output)`.
            if !surveyor.push(&input).contains(SurveyNews::STATIONARY) {
                continue;
            }
            let Some(averages) = surveyor.stationary().map(|report| report.averages) else { continue };
            // A probe does not know its depth; any number that grows as the hole does will do.
            let station = Station {
                depth_m: 30.0 * depth,
                force_m_s2: averages.force_m_s2,
                field_ut: averages.field_ut.unwrap_or_default(),
                reference: REFERENCE,
            };
            // A station that is full or unusable is handed back.
            let _ = stations.push(station);
            let settings = MultiStationSettings::default();
            let Some(report) = stations.analyse(&config.errors, &settings) else { continue };
            let Some(angles) = report.corrected(&station) else { continue };
            let before = angles.measured_azimuth_rad.value - azimuth;
            let after = angles.magnetic_azimuth_rad.value - azimuth;
            println!(
                "station {k:2}: azimuth off by {:5.2} deg, corrected by {:5.2} +- {:.2} deg ({:?})",
                before.to_degrees(),
                after.to_degrees(),
                angles.magnetic_azimuth_rad.sigma.to_degrees(),
                report.azimuth
            );
            for (worst, off) in worst.iter_mut().zip([before.abs(), after.abs()]) {
                if k >= 20 && off > *worst {
                    *worst = off;
                }
            }
        }
    }
    Ok(worst)
}

pub(crate) fn main() -> Result<(), ConfigError> {
    run().map(|_| ())
}
