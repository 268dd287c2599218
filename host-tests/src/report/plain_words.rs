//! A flight in plain sentences: what was wrong with the gyro, what was done about it, what it gained.

use meerkat_mwd::{
    Config,
    diagnosis::Verdict,
    identification::{Decision, Refusal},
    magnet::{FieldUse, HardIronInterval},
};

use super::{
    effect_words::{EFFECT_WORDS, EffectWords, effect_words, parameter_text},
    field_unused::field_unused_percent,
    json::parameters::Parameters,
    refusal_text::refusal_text,
    remainder_text::remainder_text,
    window_note::why_no_window,
};
use crate::diagnosis::{BeforeAfter, Diagnosed, Found};
use testbed::{
    flight::{Flight, Flying},
    score::{PerModel, Reference},
    trace::Trace,
};

/// Deviations from which an error of the gyro is called one.
const SHOWN_SIGMAS: f32 = 2.0;

/// A verdict in a sentence.
pub struct VerdictWords {
    /// True if nothing stands against what flew.
    pub is_sound: bool,
    /// The sentence, without its point.
    pub sentence: String,
}

impl VerdictWords {
    /// The verdict, and that nothing was gained, where what flew is further off than the bias alone, to the digits
    /// that [`gain`] tells.
    #[must_use]
    pub fn unless_worse(self, diagnosed: &Diagnosed, reference: Option<&Reference>) -> Self {
        let in_digits = |x: f64| (100.0 * x).round();
        match gained(diagnosed, reference) {
            Some(Gained { bias, flown, .. }) if in_digits(flown) > in_digits(bias) => Self {
                is_sound: false,
                sentence: format!(
                    "{} The corrections gained nothing on this recording: what flew is off by {flown:.2} deg, the bias alone by {bias:.2}.",
                    self.sentence
                ),
            },
            _ => self,
        }
    }
}

/// The verdict on a flight.
#[must_use]
pub fn verdict(trace: &Trace, config: &Config, flight: &Flight, diagnosed: &Diagnosed) -> VerdictWords {
    let caution = |sentence: String| VerdictWords { is_sound: false, sentence };
    let unjudged = unjudged(config, flight);
    if let Some(why) = why_no_window(trace, config, flight) {
        // Updates between windows leave no reason; without a field they are refused however long the recording is.
        let field = field_unused_percent(trace, config, flight).map_or_else(String::new, |percent| {
            format!("; in {percent:.0} % of the motion the field was not used: calibrate the magnetometer")
        });
        return caution(match unjudged {
            Some(flies) => {
                format!("{flies}, which no window has judged: {}{field}.", why.trim_start_matches("no window: "))
            }
            None => format!("Nothing was identified: {why}{field}."),
        });
    }
    if flight.standing().is_none() {
        let flies = unjudged.filter(|_| flight.last_model().is_some_and(|model| model.p != config.gyro.p));
        let flies = match flies {
            Some(flies) => format!("{flies}, which no window has accepted"),
            None => "The gyro's scale and axes are not corrected, only its bias".to_owned(),
        };
        return caution(match flight.reports.last().map(|report| report.decision) {
            Some(Decision::Refused(refusal)) => format!("{flies}: {}.", refusal_text(&refusal)),
            _ => format!("{flies}."),
        });
    }
    let since = flight.reports.iter().find(|report| report.decision == Decision::Accepted);
    let since_s = since.and_then(|report| report.t_effect_us).map_or(0.0, |t_us| t_us as f64 * 1e-6);
    let flies = format!("The gyro's errors were identified, and have been corrected since {since_s:.0} s");
    // Only the last window counts: one that was refused early has been overtaken.
    if let Some(Decision::Refused(refusal)) = flight.reports.last().map(|report| report.decision) {
        let why = refused_in_short(&refusal);
        return caution(format!("{flies}; the last window was refused, because {why}."));
    }
    if config.effects && diagnosed.remainder().is_some() {
        return caution(format!("{flies}, but more is left than noise accounts for."));
    }
    if let Some(left) = left_in(diagnosed) {
        return caution(format!("{flies}, but {left}."));
    }
    VerdictWords { is_sound: true, sentence: format!("{flies}.") }
}

/// Model that flies at the end, and where it comes from, where no window has made it; `None`: the factory's flies.
fn unjudged(config: &Config, flight: &Flight) -> Option<String> {
    let (first, last) = (flight.models.first()?, flight.models.last()?);
    let is_stored = first.gyro != config.gyro;
    let since = |flying: &&Flying| flying.gyro.p != first.gyro.p;
    let updated = flight.models.iter().find(since).filter(|_| last.gyro.p != first.gyro.p);
    let in_s = |flying: &Flying| flying.from_us as f64 * 1e-6;
    let by = match (is_stored, updated) {
        (false, None) => None,
        (true, None) => Some("The gyro's errors are corrected by the stored model".to_owned()),
        (false, Some(updated)) => {
            Some(format!("The gyro's errors have been corrected since {:.0} s by updates", in_s(updated)))
        }
        (true, Some(updated)) => Some(format!(
            "The gyro's errors are corrected by the stored model, and since {:.0} s by updates of it",
            in_s(updated)
        )),
    };
    if by.is_some() {
        return by;
    }
    let of_bias = flight.models.iter().find(|flying| flying.gyro != config.gyro);
    let of_bias = of_bias.filter(|_| last.gyro != config.gyro)?;
    Some(format!("Only the gyro's bias has been corrected since {:.0} s, by updates", in_s(of_bias)))
}

/// Errors that were found and stay in the readings, in words; `None` without any.
fn left_in(diagnosed: &Diagnosed) -> Option<String> {
    let mut left = diagnosed.left_in();
    left.dedup();
    (!left.is_empty()).then(|| format!("an error that was found is left in: {}", left.join(", ")))
}

/// The verdict of a diagnosis.
#[must_use]
pub fn diagnosis(diagnosed: &Diagnosed) -> VerdictWords {
    if let Some(left) = left_in(diagnosed).filter(|_| diagnosed.verdict == Verdict::EffectsFound) {
        let sentence =
            format!("Errors of the sensors beyond the gyro's bias, scale and axes were found, see below; {left}.");
        return VerdictWords { is_sound: false, sentence };
    }
    let (is_sound, meaning) = match diagnosed.verdict {
        Verdict::ModelSufficient => (true, "No effect shows, and what is left is noise."),
        Verdict::EffectsFound => (
            true,
            "Errors of the sensors beyond the gyro's bias, scale and axes were found, see below; what is left is small.",
        ),
        Verdict::NotEnoughExcitation => {
            (false, "Nothing can be told: the tool moved too little, or too little could be read.")
        }
        _ => (false, "More is left than noise, and no effect that is known explains it."),
    };
    VerdictWords { is_sound, sentence: meaning.to_owned() }
}

fn refused_in_short(refusal: &Refusal) -> String {
    let text = refusal_text(refusal);
    text.split(':').next().unwrap_or_default().to_owned()
}

/// Errors of the gyro in words, as far as the data tell: bias, scale, axes.
#[must_use]
pub fn gyro(config: &Config, flight: &Flight) -> String {
    let last = Parameters::at_the_end(config, flight);
    let bias = last.b_rad_s.map(f32::to_degrees);
    let size = bias.map(f64::from).iter().map(|b| b * b).sum::<f64>().sqrt();
    if last.is_prior && last.p != config.gyro.p.as_flattened() {
        let (k, off) = (0..9)
            .map(|k| (k, last.p[k] - if k % 4 == 0 { 1.0 } else { 0.0 }))
            .fold((0, 0.0_f32), |most, next| if next.1.abs() > most.1.abs() { next } else { most });
        let what = if k % 4 == 0 { "scale" } else { "axes" };
        return format!(
            "The gyro's bias of {size:.2} deg/s is taken out, and its scale and axes are corrected, by {:.2} % in its {what} at the most; no window has accepted this.",
            100.0 * off.abs()
        );
    }
    if last.is_prior {
        return format!(
            "The gyro reads a bias of {size:.2} deg/s, which is taken out; of its scale and axes nothing is known."
        );
    }
    let element = |k: usize| (last.p[k] - if k.is_multiple_of(4) { 1.0 } else { 0.0 }, last.sigma[k]);
    let largest = |of: &dyn Fn(usize) -> bool| {
        let those = (0..9).filter(|k| of(*k)).map(|k| (k, element(k)));
        those.max_by(|(_, (a, _)), (_, (b, _))| a.abs().total_cmp(&b.abs()))
    };
    let axes = ["x", "y", "z"];
    let mut faults = vec![format!("a bias of {size:.2} deg/s")];
    if let Some((k, (error, sigma))) =
        largest(&|k| k.is_multiple_of(4)).filter(|(_, (e, s))| e.abs() > SHOWN_SIGMAS * s)
    {
        // rate = P raw: a P above one means that too little is read.
        let what = if error > 0.0 { "little" } else { "much" };
        let (percent, sigma) = (100.0 * error.abs(), 100.0 * sigma);
        faults.push(format!("axis {} reads {percent:.2} ± {sigma:.2} % too {what}", axes[k / 4]));
    }
    if let Some((k, (error, sigma))) =
        largest(&|k| !k.is_multiple_of(4)).filter(|(_, (e, s))| e.abs() > SHOWN_SIGMAS * s)
    {
        let (percent, sigma) = (100.0 * error.abs(), 100.0 * sigma);
        faults.push(format!(
            "{percent:.2} ± {sigma:.2} % of axis {}'s rate shows on axis {}",
            axes[k % 3],
            axes[k / 3]
        ));
    }
    if faults.len() == 1 {
        return format!(
            "The gyro has a bias of {size:.2} deg/s, which is taken out; its scale and axes are right as far as can be told."
        );
    }
    format!("The gyro has {}; this is taken out.", faults.join("; "))
}

/// Correction of the gyro in words: what flies, since when, and which effects are taken out.
#[must_use]
pub fn done(trace: &Trace, config: &Config, flight: &Flight, diagnosed: &Diagnosed) -> String {
    let flies = verdict(trace, config, flight, diagnosed).sentence;
    let taken_out = diagnosed.effects.iter().filter(|found| found.report.is_taken_out());
    let named: Vec<String> = taken_out.map(|found| in_a_sentence(&effect_words(found.effect))).collect();
    if named.is_empty() { flies } else { format!("{flies} Also taken out: {}.", named.join("; ")) }
}

/// An effect's title within a sentence, with its name.
#[must_use]
pub fn in_a_sentence(words: &EffectWords) -> String {
    let (first, rest) = words.title.split_at(1);
    format!("{}{rest} ({})", first.to_lowercase(), words.name)
}

/// Use of the field while a magnet was on the probe, in words.
#[must_use]
pub const fn use_of_field(magnet: &HardIronInterval) -> &'static str {
    match magnet.field_use {
        FieldUse::Corrected => "its field is taken out",
        FieldUse::ToldAfterwards => "it came before the probe had turned, and was told when it left",
        _ => "the field is not used while it lasts",
    }
}

/// Effects and magnets, one sentence each.
#[must_use]
pub fn effects(diagnosed: &Diagnosed) -> Vec<String> {
    let magnets = diagnosed.magnets.iter().map(|magnet| {
        let [x, y, z] = magnet.offset_ut.map(f64::from);
        let size = (x * x + y * y + z * z).sqrt();
        let until = magnet.to_us.map_or_else(|| "the end".to_owned(), |to_us| format!("{:.0} s", to_us as f64 * 1e-6));
        let done = use_of_field(magnet);
        let from_s = magnet.from_us as f64 * 1e-6;
        format!("A magnet of {size:.0} µT is on the probe from {from_s:.0} s to {until}; {done}.")
    });
    diagnosed.effects.iter().map(effect).chain(magnets).collect()
}

fn effect(found: &Found) -> String {
    let words = effect_words(found.effect);
    // The clearest of many parameters speaks for the effect.
    let both = found.report.found.parameters.iter().zip(&found.report.found.sigma);
    let parameters = found.effect.parameters().iter().zip(both);
    let in_sigmas = |x: f32, sigma: f32| if sigma > 0.0 { (x / sigma).abs() } else { 0.0 };
    let clearest = parameters.max_by(|(_, (a, s)), (_, (b, t))| in_sigmas(**a, **s).total_cmp(&in_sigmas(**b, **t)));
    let size = clearest.map_or_else(String::new, |(parameter, (x, sigma))| {
        format!(" ({}: {})", found.effect.name(), parameter_text(parameter, *x, *sigma))
    });
    let at = if found.effect.is_bias_step() {
        format!(" at {:.0} s", found.report.step_us as f64 * 1e-6)
    } else {
        String::new()
    };
    let done = if found.report.is_taken_out() {
        format!("taken out since {:.0} s", found.report.taken_out_us as f64 * 1e-6)
    } else {
        format!("not taken out{}", found.why_left_in())
    };
    let aliases: Vec<String> = found.aliases().into_iter().map(alias_in_words).collect();
    let doubt = if aliases.is_empty() { String::new() } else { format!(" It could also be: {}.", aliases.join("; ")) };
    format!("{}{at}{size}, {done}.{doubt}", words.title)
}

/// An alias by its title, with its name: what follows the name says when it is one.
fn alias_in_words(alias: &str) -> String {
    let name = alias.split(' ').next().unwrap_or(alias);
    let Some(words) = EFFECT_WORDS.iter().find(|words| words.name == name) else { return alias.to_owned() };
    let (first, rest) = words.title.split_at(1);
    format!("{}{rest} ({alias})", first.to_lowercase())
}

/// Errors of the gyro, degrees: against the reference, or else in what it predicts of the field.
struct Gained {
    /// As read; only a reference tells.
    raw: Option<f64>,
    /// With its bias alone taken out.
    bias: f64,
    /// As flown.
    flown: f64,
}

fn gained(diagnosed: &Diagnosed, reference: Option<&Reference>) -> Option<Gained> {
    if let Some(reference) = reference {
        let aligned = &reference.orientation_2s_rms_time_aligned_deg;
        let scores = if *aligned == PerModel::default() { &reference.orientation_2s_rms_deg } else { aligned };
        if let PerModel { uncompensated: Some(raw), bias_only: Some(bias), with_effects: Some(flown), .. } = *scores
            // Before a window there is no bias alone.
            && bias != raw
        {
            return Some(Gained { raw: Some(raw), bias, flown });
        }
    }
    match diagnosed.residual.magnetic_deg {
        BeforeAfter { before: Some(bias), after: Some(flown) } => Some(Gained { raw: None, bias, flown }),
        _ => None,
    }
}

/// Gain of the correction in words, in degrees; `None` if nothing tells.
#[must_use]
pub fn gain(diagnosed: &Diagnosed, reference: Option<&Reference>) -> Option<String> {
    gained(diagnosed, reference).map(|Gained { raw, bias, flown }| raw.map_or_else(
        || format!("The gyro now predicts the field over a second to {flown:.2} deg; to {bias:.2} deg with its bias alone taken out."),
        |raw| format!("Against the reference, two seconds of rotation are wrong by {flown:.2} deg; by {raw:.2} deg with the raw gyro, by {bias:.2} deg with its bias alone taken out."),
    ))
}

/// Remainder that is left unexplained, in a sentence.
#[must_use]
pub fn remainder(diagnosed: &Diagnosed) -> Option<String> {
    let remainder = diagnosed.remainder()?;
    let largest = remainder.named().max_by(|a, b| a.share.total_cmp(&b.share));
    Some(match largest {
        Some(found) => format!(
            "What is left is no noise: {:.0} % of it goes with {}, and no effect that is known explains that.",
            100.0 * found.share,
            found.correlate.name().replace('_', " ")
        ),
        None => format!("{}.", remainder_text(remainder)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::diagnosed;

    #[test]
    fn what_is_worse_than_the_bias_alone_is_not_called_sound() {
        let mut found = diagnosed(&Trace::default(), &Config::default(), &Flight::default());
        let mut told = |after: f64| {
            found.residual.magnetic_deg = BeforeAfter { before: Some(0.39), after: Some(after) };
            VerdictWords { is_sound: true, sentence: "All is well.".to_owned() }.unless_worse(&found, None)
        };
        let worse = told(0.4);
        assert!(!worse.is_sound && worse.sentence.ends_with("what flew is off by 0.40 deg, the bias alone by 0.39."));
        // Not by a digit that is not told.
        assert!(told(0.392).is_sound && told(0.2).is_sound);
    }
}
