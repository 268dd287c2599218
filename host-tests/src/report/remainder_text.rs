//! Words for a residual that no effect explains.

use meerkat_mwd::diagnosis::RemainderReport;

/// Correlates of the remainder in words, and whether it resembles itself some time later.
#[must_use]
pub fn remainder_text(remainder: &RemainderReport) -> String {
    if remainder.is_white() {
        return "what is left goes with nothing that is looked at, and is white: noise that was thought smaller"
            .to_owned();
    }
    let named: Vec<String> = remainder
        .named()
        .map(|found| {
            let name = found.correlate.name().replace('_', " ");
            format!("{name} ({:.0} % of its variance, {})", 100.0 * found.share, chance(found.p_value))
        })
        .collect();
    let mut parts = Vec::new();
    if !named.is_empty() {
        parts.push(format!("what is left goes with: {}", named.join(", ")));
    }
    if remainder.has_memory {
        let memory = &remainder.memory;
        let like = if memory.correlation > 0.0 { "like itself" } else { "the opposite of itself" };
        parts.push(format!(
            "what is left is {like} after {:.1} s (correlation {:.2}, {}), so it is no noise",
            memory.apart_s,
            memory.correlation,
            chance(memory.p_value)
        ));
    }
    parts.join("; ")
}

fn chance(p_value: f32) -> String {
    if p_value < 1e-4 { "chance under 0.0001".to_owned() } else { format!("chance {p_value:.4}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meerkat_mwd::diagnosis::{Correlate, GoesWith, Memory};

    #[test]
    fn each_outcome_has_its_words() {
        let mut remainder = RemainderReport::default();
        assert!(remainder_text(&remainder).contains("white"));
        remainder.memory = Memory { correlation: -0.62, apart_s: 3.5, p_value: 1e-4 };
        remainder.has_memory = true;
        assert!(remainder_text(&remainder).contains("the opposite of itself after 3.5 s (correlation -0.62"));
        remainder.goes_with[0] = GoesWith { correlate: Correlate::VibrationPower, share: 0.613, p_value: 2e-4 };
        remainder.count = 1;
        let text = remainder_text(&remainder);
        assert!(text.starts_with("what is left goes with: vibration power (61 % of its variance, chance 0.0002); "));
    }
}
