//! Best possible result: the best linear estimate, for an oracle that knows which samples were hit.
//!
//! A Kalman filter linearised about the truth, on the same readings: hit vectors are left out, and over hit
//! gyro readings the attitude is lost. No method without the oracle can do better, on average over windows.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{
    comparison::{KIND_HEADS, success_percent},
    drilled::{Drilled, SHARES, WINDOW, in_parallel},
    prior::Prior,
    readings::{Readings, Theta, rate},
};
use testbed::{
    simulate::{Contamination, sensors::SensorNoise, vibration::HighPassed},
    study::{
        Table,
        cramer_rao::{
            MEAN_S,
            error_state::{ErrorState, VectorSensor},
        },
    },
};

/// Deviations beyond which an accelerometer reading counts as a shock.
const SHOCK: f64 = 5.0;

/// Success of the estimate.
pub(super) fn table(which: &str, runs: &[Drilled]) -> Table {
    let kinds: Vec<Option<Contamination>> = std::iter::once(None).chain(Contamination::ALL.map(Some)).collect();
    let ratios = in_parallel(runs.len() * kinds.len(), |index| {
        let (run, kind) = (&runs[index / kinds.len()], kinds[index % kinds.len()]);
        (kind, run.share_index(), run.ratio(&estimate(run, &run.readings(kind, run.share()))))
    });
    let mut columns = vec!["", "all"];
    columns.extend(KIND_HEADS);
    let shares = SHARES.map(|share| format!("{:.0} %", 100.0 * share));
    columns.extend(shares.iter().map(String::as_str));
    columns.push("not hit");
    let title = format!(
        "What could be had of {which}: a Kalman filter about the truth that knows which samples were hit, error under twice that of the clean fit, %"
    );
    let mut table = Table::new(title, &columns);
    let of = |wanted: &dyn Fn(Option<Contamination>, usize) -> bool| {
        success_percent(ratios.iter().filter(|(kind, share, _)| wanted(*kind, *share)).map(|(.., ratio)| *ratio))
    };
    let mut cells = vec!["hits known".to_owned(), of(&|kind, _| kind.is_some())];
    cells.extend(Contamination::ALL.map(|wanted| of(&|kind, _| kind == Some(wanted))));
    cells.extend((0..SHARES.len()).map(|wanted| of(&|kind, share| kind.is_some() && share == wanted)));
    cells.push(of(&|kind, _| kind.is_none()));
    table.row(cells);
    table
}

fn estimate(run: &Drilled, readings: &Readings) -> Theta {
    let scenario = &run.scenario;
    let noise = SensorNoise::of(scenario);
    let white_m_s2 = HighPassed::of(scenario).white_m_s2((MEAN_S / readings.period_s) as u32);
    let accel_m_s2 = white_m_s2.map(|white| libm::hypot(white, noise.accel_m_s2));
    let (sine, cosine) = scenario.earth.dip_deg.to_radians().sin_cos();
    let gravity_m_s2 = Vector3::new(0.0, 0.0, scenario.earth.gravity_m_s2);
    let field_ut = Vector3::new(cosine, 0.0, sine) * scenario.earth.magnetic_field_ut;
    let p = run.truth.p_matrix().map(f64::from);
    let c = p * Vector3::from(run.truth.b_rad_s.map(f64::from));
    let truth = Theta::from_fn(|i, _| if i < 9 { p[(i / 3, i % 3)] } else { c[i - 9] });

    let prior = Prior::data_sheet();
    let mut filter = ErrorState::new(&prior.sigma.into());
    filter.set_theta_estimate(&(prior.mean - truth));
    let turned = p * p.transpose() * (noise.gyro_rad_s * readings.period_s).powi(2);
    for (index, reading) in readings.samples.iter().enumerate() {
        let known = (run.rates_rad_s.get(WINDOW.start + index), run.trace.reference.get(WINDOW.start + index));
        let (Some(true_rate), Some(Some([w, x, y, z]))) = known else { continue };
        let (true_rate, to_earth) =
            (Vector3::from(*true_rate), UnitQuaternion::from_quaternion(Quaternion::new(*w, *x, *y, *z)));
        let [gyro_hit, accel_hit, mag_hit] = reading.hit;
        if gyro_hit {
            filter.lose_attitude();
        } else if index > 0 {
            filter.turn(&true_rate, &reading.raw, &(rate(&truth, &reading.raw) - true_rate), readings.period_s);
            filter.add_noise(0, &turned);
        }
        let [gravity, field] = [gravity_m_s2, field_ut].map(|vector| to_earth.inverse_transform_vector(&vector));
        let surprise = reading.vectors[0] - gravity;
        let is_shock = surprise.component_div(&accel_m_s2).amax() > SHOCK;
        if !accel_hit && !is_shock {
            filter.observe_vector(
                (VectorSensor::Accelerometer, &true_rate),
                &gravity,
                &surprise,
                &Vector3::zeros(),
                &accel_m_s2,
            );
        }
        if !mag_hit {
            let surprise = reading.vectors[1] - field;
            filter.observe_vector(
                (VectorSensor::Magnetometer, &true_rate),
                &field,
                &surprise,
                &Vector3::zeros(),
                &Vector3::repeat(noise.mag_ut),
            );
        }
    }
    truth + filter.theta_estimate()
}
