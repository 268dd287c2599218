//! Notes on a flight's trace that a user should know beside its results, each with the likely fix.

use meerkat_mwd::Config;

use super::field_unused::field_unused_percent;
use testbed::{flight::Flight, trace::Trace};

/// Adds the notes of a flight to its trace.
pub fn add_flight_notes(trace: &mut Trace, config: &Config, flight: &Flight) {
    flight.note_refused(trace);
    let unused = field_unused_percent(trace, config, flight).map(|percent| {
        format!(
            "in {percent:.0} % of the motion the field was not used, because its size or its dip changes as the tool turns; \
             likely fix: calibrate the magnetometer by `mwd calibrate`, or keep magnets away"
        )
    });
    trace.notes.extend(unused);
    trace.notes.extend(large_biases(config, flight));
}

/// Axes whose bias, as it flew last, is larger than a data sheet allows.
fn large_biases(config: &Config, flight: &Flight) -> Vec<String> {
    let Some(model) = flight.last_model() else { return Vec::new() };
    let most = config.identification.max_bias_rad_s;
    let large = ["x", "y", "z"].into_iter().zip(model.b_rad_s).filter(|(_, bias)| bias.abs() > most);
    let told = large.map(|(axis, bias)| {
        format!(
            "the gyro reads {:.1} deg/s about {axis} where nothing turns, and its zero-rate level is {:.1} deg/s at most; \
             likely fix: look into the gyro and its unit, or set identification.max_bias_rad_s by its data sheet",
            bias.to_degrees(),
            most.to_degrees()
        )
    });
    told.collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use meerkat_mwd::compensation::effects::LIBRARY;

    use super::*;
    use testbed::{
        flight::{configuration::of_trace, fly_with},
        simulate::{Gyro, Scenario, simulate},
    };

    #[test]
    fn a_bias_above_the_data_sheets_is_measured_at_rest_and_told_with_its_number() {
        for (y_deg_s, is_told) in [(-14.0, true), (9.0, false)] {
            let gyro = Gyro { bias_deg_s: Some([1.0, y_deg_s, -2.0]), ..Gyro::default() };
            let scenario = Scenario { duration_s: 30.0, rest_s: 20.0, gyro, ..Scenario::default() };
            let (mut trace, _) = simulate(&scenario, 3);
            let config = of_trace(&trace);
            let flight = fly_with(&LIBRARY, &config, None, &trace.samples).unwrap();
            let bias = flight.last_model().unwrap().b_rad_s.map(|b| f64::from(b).to_degrees());
            assert!((bias[1] - y_deg_s).abs() < 0.1, "{bias:?}");
            add_flight_notes(&mut trace, &config, &flight);
            let told: Vec<_> = trace.notes.iter().filter(|note| note.contains("where nothing turns")).collect();
            assert_eq!(told.len(), usize::from(is_told), "{:?}", trace.notes);
            assert!(told.iter().all(|note| note.contains("-14.0 deg/s about y")), "{told:?}");
        }
    }
}
