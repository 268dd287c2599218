//! Effects in words: what a driller reads where the results have a name.

use meerkat_mwd::compensation::{Effect, Parameter};

use crate::number::fixed;

/// Words for an effect: what it is called, and what it is.
pub struct EffectWords {
    /// Name in results.
    pub name: &'static str,
    /// Short title.
    pub title: &'static str,
    /// Explanation of the effect, in a sentence.
    pub what: &'static str,
}

/// Every effect of the library, in its order.
pub const EFFECT_WORDS: [EffectWords; 20] = [
    words("mag_lag", "Late magnetometer", "The magnetometer's readings come later than the gyro's."),
    words("accel_lag", "Late accelerometer", "The accelerometer's readings come later than the gyro's."),
    words("gyro_lag", "Late gyro", "The gyro's readings come later than they are stamped."),
    words(
        "eddy_lag",
        "Eddy currents in the collar",
        "Currents in the turning collar drag the field across the axis behind the rotation.",
    ),
    words(
        "axial_interference",
        "Magnetised drill string",
        "The drill string adds a constant field along the tool's axis.",
    ),
    words("hard_iron", "Magnetised parts near the magnetometer", "Magnetised parts add a constant field in tool axes."),
    words(
        "soft_iron",
        "Soft iron",
        "Iron near the magnetometer bends the field; its axes may be turned against the gyro's as well.",
    ),
    words(
        "mag_misalignment",
        "Turned axes of the magnetometer",
        "The magnetometer's axes are turned against those of the gyro and the accelerometer.",
    ),
    words("accel_bias", "Offset of the accelerometer", "The accelerometer reads a constant too much."),
    words(
        "accel_scale",
        "Scale or axes of the accelerometer",
        "The accelerometer's scale factors are off, or its axes are turned.",
    ),
    words(
        "lever_arm",
        "Accelerometer off the axis of rotation",
        "The accelerometer stands away from the centre of rotation and feels the rotation itself.",
    ),
    words("gyro_bias_temperature", "Gyro bias that goes with temperature", "The gyro's bias moves with temperature."),
    words(
        "gyro_scale_temperature",
        "Gyro scale that goes with temperature",
        "The gyro's scale moves with temperature.",
    ),
    words(
        "accel_temperature",
        "Accelerometer offset that goes with temperature",
        "The accelerometer's offset moves with temperature.",
    ),
    words(
        "mag_temperature",
        "Magnetometer offset that goes with temperature",
        "The magnetometer's offset moves with temperature.",
    ),
    words("g_sensitivity", "Gyro that feels acceleration", "The gyro reads a rate where there is only acceleration."),
    words(
        "vibration_rectification",
        "Gyro bias from vibration",
        "Vibration shifts the gyro's bias, by the vibration's mean square.",
    ),
    words("gyro_scale_nonlinearity", "Gyro scale that goes with the rate", "The gyro's scale changes at high rates."),
    words(
        "gyro_scale_asymmetry",
        "Gyro scale that differs by direction",
        "The gyro's scale differs between the two directions of rotation.",
    ),
    words("gyro_bias_step", "Step of the gyro's bias", "The gyro's bias jumped, as after a shock, and stayed."),
];

const fn words(name: &'static str, title: &'static str, what: &'static str) -> EffectWords {
    EffectWords { name, title, what }
}

/// Words of an effect; its bare name for one from outside the library.
#[must_use]
pub fn effect_words(effect: &dyn Effect) -> EffectWords {
    let known = EFFECT_WORDS.iter().find(|words| words.name == effect.name());
    known.map_or_else(|| words(effect.name(), effect.name(), ""), |known| words(known.name, known.title, known.what))
}

/// Units at the end of a parameter's name, the longer one first, and how they are written.
const UNITS: [(&str, &str); 16] = [
    ("deg_s_g2", "deg/s/g²"),
    ("deg_s_g", "deg/s/g"),
    ("deg_s_k", "deg/s/K"),
    ("percent_k", "%/K"),
    ("m_s2_k", "m/s²/K"),
    ("s2_rad2", "s²/rad²"),
    ("ut_k", "µT/K"),
    ("deg_s", "deg/s"),
    ("m_s2", "m/s²"),
    ("percent", "%"),
    ("deg", "deg"),
    ("ms", "ms"),
    ("mm", "mm"),
    ("ut", "µT"),
    ("g", "g"),
    ("s", "s"),
];

/// A parameter's name in words, and its unit.
#[must_use]
pub fn name_and_unit(parameter: &Parameter) -> (String, &'static str) {
    let of_unit = |(suffix, text): &(&str, &'static str)| {
        let name = parameter.name.strip_suffix(suffix)?.strip_suffix('_')?;
        Some((name.replace('_', " "), *text))
    };
    UNITS.iter().find_map(of_unit).unwrap_or_else(|| (parameter.name.replace('_', " "), ""))
}

/// A parameter's value and deviation with name and unit, from its SI figures.
#[must_use]
pub fn parameter_text(parameter: &Parameter, value: f32, sigma: f32) -> String {
    let (name, unit) = name_and_unit(parameter);
    let [value, sigma] = [value, sigma].map(|x| f64::from(x * parameter.in_unit));
    // Two digits of the deviation, and as many of the value.
    let decimals = if sigma > 0.0 { (1.0 - sigma.log10().floor()).clamp(0.0, 6.0) as usize } else { 3 };
    let value = fixed(value, decimals);
    format!("{name} {value} ± {sigma:.decimals$} {unit}").trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use meerkat_mwd::compensation::effects::LIBRARY;

    #[test]
    fn every_effect_of_the_library_has_words_and_every_parameter_a_unit() {
        assert!(LIBRARY.iter().map(|effect| effect.name()).eq(EFFECT_WORDS.iter().map(|words| words.name)));
        for parameter in LIBRARY.iter().flat_map(|effect| effect.parameters()) {
            let text = parameter_text(parameter, 1.0 / parameter.in_unit, 0.1 / parameter.in_unit);
            assert!(text.contains(" 1.00 ± 0.10 ") && !text.contains('_'), "{}: {text}", parameter.name);
        }
    }
}
