//! Decimal seconds to whole microseconds, exactly. A binary float in between would move timestamps: f32 holds
//! 24 bits, and an hour in microseconds needs 32.

use super::error::{Fault, quoted};

/// Decimal seconds to the nearest microsecond, halves up.
pub(super) fn parse_time_us(text: &str) -> Result<u64, Fault> {
    if let Some(t_us) = plain_us(text) {
        return Ok(t_us);
    }
    match text.parse::<f64>() {
        Err(_) => Err(Fault::NotANumber(quoted(text))),
        Ok(seconds) if !seconds.is_finite() => Err(Fault::NotFinite(quoted(text))),
        Ok(_) => exact_us(text).ok_or_else(|| Fault::TimeOutOfRange(quoted(text))),
    }
}

/// The same for what most times are: digits, at most twelve before a point and six behind it.
fn plain_us(text: &str) -> Option<u64> {
    let text = text.as_bytes();
    let point = text.iter().position(|byte| *byte == b'.').unwrap_or(text.len());
    let (seconds, behind) = (text.get(..point)?, text.get(point + 1..).unwrap_or_default());
    let is_short = !seconds.is_empty() && seconds.len() <= 12 && behind.len() <= 6;
    let digit = |byte: u8| byte.is_ascii_digit().then(|| u64::from(byte - b'0'));
    let micros = if is_short {
        seconds.iter().chain(behind).try_fold(0, |sum, byte| Some(10 * sum + digit(*byte)?))
    } else {
        None
    };
    (behind.len()..6).try_fold(micros?, |micros, _| Some(10 * micros))
}

/// The same for a text that is known to be a finite decimal number.
fn exact_us(text: &str) -> Option<u64> {
    let (negative, digits) = match text.as_bytes() {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        all => (false, all),
    };
    // Digits beyond this lie 30 places below the first: they cannot change the rounding of a time that fits
    // in 64 bits.
    const LARGEST: u128 = 10_u128.pow(30);
    let mut mantissa = 0_u128;
    let mut power = 6_i64;
    let mut after_point = false;
    let mut bytes = digits.iter();
    for byte in bytes.by_ref() {
        match byte {
            b'0'..=b'9' if mantissa < LARGEST => {
                mantissa = mantissa * 10 + u128::from(byte - b'0');
                power -= i64::from(after_point);
            }
            b'0'..=b'9' => power += i64::from(!after_point),
            b'.' => after_point = true,
            _ => break,
        }
    }
    power = power.saturating_add(exponent(bytes.as_slice()));
    let scale = u32::try_from(power.unsigned_abs()).ok().and_then(|places| 10_u128.checked_pow(places));
    let micros = match (mantissa, scale) {
        (0, _) => 0,
        (_, Some(scale)) if power >= 0 => mantissa.checked_mul(scale)?,
        (_, Some(scale)) => (mantissa + scale / 2) / scale,
        (_, None) if power >= 0 => return None,
        (_, None) => 0,
    };
    if negative && micros > 0 { None } else { u64::try_from(micros).ok() }
}

/// The decimal exponent after the letter e; 0 when there is none.
fn exponent(text: &[u8]) -> i64 {
    let (sign, digits) = match text {
        [b'-', rest @ ..] => (-1, rest),
        [b'+', rest @ ..] => (1, rest),
        all => (1, all),
    };
    let size = digits
        .iter()
        .fold(0_i64, |sum, digit| sum.saturating_mul(10).saturating_add(i64::from(digit.wrapping_sub(b'0'))));
    sign * size
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::{super::seconds::seconds, *};

    #[test]
    fn decimals_round_to_the_nearest_microsecond() {
        for (text, expected) in [
            ("0", 0),
            ("-0.0", 0),
            ("-0.0000001", 0),
            ("+1", 1_000_000),
            (".5", 500_000),
            ("5.", 5_000_000),
            ("0.0035", 3_500),
            ("197.3364999999999", 197_336_500),
            ("0.0000004999999999999999999999999999999999999999", 0),
            ("0.0000005", 1),
            ("1.5e9", 1_500_000_000_000_000),
            ("1234567E-3", 1_234_567_000),
            ("1e-40", 0),
            ("1e-99999999999999999999", 0),
            ("0e99999999999999999999", 0),
            ("100000000000000000000000000000000000000000e-40", 10_000_000),
            ("18446744073709.551615", u64::MAX),
        ] {
            assert_eq!(parse_time_us(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_is_not_a_time_is_told_apart() {
        assert!(matches!(parse_time_us("1,5"), Err(Fault::NotANumber(_))));
        assert!(matches!(parse_time_us("NaN"), Err(Fault::NotFinite(_))));
        assert!(matches!(parse_time_us("1e999"), Err(Fault::NotFinite(_))));
        assert!(matches!(parse_time_us("-1"), Err(Fault::TimeOutOfRange(_))));
        assert!(matches!(parse_time_us("1e200"), Err(Fault::TimeOutOfRange(_))));
        assert!(matches!(parse_time_us("18446744073709.5516155"), Err(Fault::TimeOutOfRange(_))));
    }

    proptest! {
        #[test]
        fn every_microsecond_survives_writing_and_reading(t_us: u64) {
            prop_assert_eq!(parse_time_us(&seconds(t_us).to_string()), Ok(t_us));
        }

        #[test]
        fn agrees_with_double_arithmetic_where_that_is_exact_enough(value in 0.0_f64..1e6, exponent in -3_i32..3) {
            let text = format!("{value}e{exponent}");
            let expected = value * 10_f64.powi(exponent) * 1e6;
            prop_assert!((parse_time_us(&text).unwrap() as f64 - expected).abs() < 0.501 + expected * 1e-15);
        }
    }
}
