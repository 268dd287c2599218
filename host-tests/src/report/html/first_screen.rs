//! First screen of a page: the verdict in a sentence, what flew and why, attitude at the end.

use super::{Told, attitude, escape::escape, fixed, in_s, sentence};
use crate::report::{
    motion, plain_words,
    toolface::{has_north, is_vertical, toolface_rad},
};

/// First screen of a flight's page.
pub(super) fn of_a_flight(told: &Told) -> String {
    let verdict = plain_words::verdict(told.trace, told.config, told.flight, told.diagnosed);
    let verdict = verdict.unless_worse(told.diagnosed, told.reference);
    let mut reasons = vec![plain_words::gyro(told.config, told.flight)];
    if told.config.effects {
        reasons.extend(plain_words::effects(told.diagnosed));
    }
    reasons.extend(plain_words::gain(told.diagnosed, told.reference));
    reasons.extend(plain_words::remainder(told.diagnosed));
    head(told, "Flight", &verdict, &reasons)
}

/// First screen of a diagnosis' page.
pub(super) fn of_a_diagnosis(told: &Told) -> String {
    let diagnosed = told.diagnosed;
    let verdict = plain_words::diagnosis(diagnosed).unless_worse(diagnosed, told.reference);
    let mut reasons = plain_words::effects(diagnosed);
    reasons.extend(plain_words::gain(diagnosed, told.reference));
    reasons.extend(plain_words::remainder(diagnosed));
    reasons.push(plain_words::gyro(told.config, told.flight));
    head(told, "Diagnosis", &verdict, &reasons)
}

fn head(told: &Told, kind: &str, verdict: &plain_words::VerdictWords, reasons: &[String]) -> String {
    let trace = told.trace;
    let mut out = format!("<header>\n<h1>{kind} of {}</h1>\n", escape(&told.file_name()));
    let class = if verdict.is_sound { "good" } else { "caution" };
    out += &format!(
        "<div class=\"verdict {class}\">\n<p class=\"sentence\">{}</p>\n",
        escape(&sentence(&verdict.sentence))
    );
    // Before the reasons, so that a phone's first screen has it.
    out += &tiles(
        told,
        "Attitude at the end of the recording, ± one standard deviation. The small curves are all of the recording, with bands of one and two.",
    );
    let items: String = reasons.iter().map(|reason| format!("<li>{}</li>\n", escape(&sentence(reason)))).collect();
    if !items.is_empty() {
        out += &format!("<ul>\n{items}</ul>\n");
    }
    out += "</div>\n</header>\n";
    let frozen = told.flight.frozen_at_us.map_or_else(String::new, |freeze_us| {
        format!(" Parameters and effects are frozen from {:.1} s; scores are over what follows.", in_s(freeze_us))
    });
    let about = format!(
        "{} samples over {:.1} s, flown, which is to say played through the probe's program, {}. {}{frozen}",
        trace.samples.len(),
        trace.duration_s(),
        told.place,
        motion::sentence(trace, told.config)
    );
    out + &format!("<p class=\"trace\">{}</p>\n", escape(&about))
}

/// The last attitude, with its deviations; `about` says when that is.
pub(super) fn tiles(told: &Told, about: &str) -> String {
    let last = told.flight.outputs.iter().rev().find_map(|output| Some((output.t_us, output.attitude?)));
    let Some((t_us, at_end)) = last else { return String::new() };
    let north = match (has_north(&at_end), told.config.earth.declination_rad) {
        (false, _) => "no field: north was never seen",
        (true, Some(_)) => "from true north",
        (true, None) => "from magnetic north",
    };
    let kind = if is_vertical(&at_end) { "magnetic, near the vertical" } else { "gravity, from the highside" };
    let axis = match told.trace.keys.body_frame {
        testbed::trace::BodyFrame::Tool => "of the tool's axis",
        testbed::trace::BodyFrame::Sensor => "of the sensor's z axis",
    };
    let angles = [
        ("Inclination", at_end.inclination_rad, at_end.sigma_inclination_rad, axis),
        ("Azimuth", at_end.azimuth_rad, at_end.sigma_azimuth_rad, north),
        ("Toolface", toolface_rad(&at_end), at_end.sigma_toolface_rad, kind),
    ];
    let tile = |((name, x, sigma, what), strip): ((&str, f32, f32, &str), String)| {
        let (x, sigma) = (x.to_degrees(), sigma.to_degrees());
        let is_known = name != "Azimuth" || has_north(&at_end);
        let value = if is_known { format!("{}° ± {sigma:.2}°", fixed(x, 2)) } else { "unknown".to_owned() };
        format!(
            "<div><dt>{name} at {:.0} s</dt><dd>{value} <small>{what}</small></dd><dd>{strip}</dd></div>\n",
            in_s(t_us)
        )
    };
    let tiles: String = angles.into_iter().zip(attitude::strips(told)).map(tile).collect();
    format!("<dl class=\"tiles attitude\">\n{tiles}</dl>\n<p class=\"about\">{about}</p>\n")
}
