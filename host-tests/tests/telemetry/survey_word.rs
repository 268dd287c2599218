//! Ten bytes of survey: exact to half a step, honest at the ends, and not to be had from damage.

use meerkat_mwd::{
    survey::{Grade, Survey, SurveyKind, ToolfaceKind, Uncertain},
    telemetry::survey_word::{
        AZIMUTH, DIP, DecodedQuantity, FIELD_UT, GRAVITY_M_S2, INCLINATION, Quantity, SURVEY_WORD_BYTES, SurveyWord,
        SurveyWordError, TEMPERATURE_C, TOOLFACE,
    },
};
use proptest::prelude::*;

fn survey(values: [Option<f32>; 7]) -> Survey {
    let [inclination, azimuth, toolface, gravity, field, dip, temperature_c] = values;
    let uncertain = |value: Option<f32>| value.map(|value| Uncertain { value, sigma: 0.1 });
    Survey {
        kind: SurveyKind::Stationary,
        t_start_us: 0,
        t_end_us: 1,
        inclination_rad: Uncertain { value: inclination.unwrap_or(f32::NAN), sigma: 0.1 },
        magnetic_azimuth_rad: uncertain(azimuth),
        true_azimuth_rad: None,
        grid_azimuth_rad: None,
        gravity_toolface_rad: uncertain(toolface),
        magnetic_toolface_rad: None,
        toolface_kind: ToolfaceKind::Gravity,
        gravity_m_s2: uncertain(gravity),
        field_ut: uncertain(field),
        dip_rad: uncertain(dip),
        temperature_c,
        rotating: false,
    }
}

const QUANTITIES: [Quantity; 7] = [INCLINATION, AZIMUTH, TOOLFACE, GRAVITY_M_S2, FIELD_UT, DIP, TEMPERATURE_C];

fn told(values: [Option<f32>; 7]) -> [DecodedQuantity; 7] {
    let word = SurveyWord::pack(&survey(values), None);
    let unpacked = SurveyWord::unpack(&word).unwrap();
    assert_eq!(
        (unpacked.kind, unpacked.toolface_kind, unpacked.grade),
        (SurveyKind::Stationary, ToolfaceKind::Gravity, None)
    );
    [
        unpacked.inclination_rad,
        unpacked.azimuth_rad,
        unpacked.toolface_rad,
        unpacked.gravity_m_s2,
        unpacked.field_ut,
        unpacked.dip_rad,
        unpacked.temperature_c,
    ]
}

/// Half a step and the last digits of an f32 of this size, in double precision.
fn is_near(quantity: &Quantity, value: f32, told: f32, cyclic: bool) -> bool {
    let [least, greatest] = quantity.range().map(f64::from);
    let mut apart = f64::from(value) - f64::from(told);
    if cyclic {
        apart = libm::remainder(apart, std::f64::consts::TAU);
    }
    let rounding = 3.0 * f64::from(f32::EPSILON) * least.abs().max(greatest);
    apart.abs() <= f64::from(quantity.step()) / 2.0 + rounding
}

#[test]
fn it_takes_80_bits() {
    let quantities: u32 = QUANTITIES.iter().map(Quantity::bits).sum();
    // Kind, grade, toolface's kind, check.
    assert_eq!(quantities as usize + 2 + 2 + 1 + 7, 8 * SURVEY_WORD_BYTES);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn every_value_in_range_comes_back_within_half_a_step(parts in prop::array::uniform7(0.0_f32..=1.0)) {
        let mut values = [None; 7];
        for ((value, part), quantity) in values.iter_mut().zip(parts).zip(&QUANTITIES) {
            let [least, greatest] = quantity.range();
            let inside = least + part * (greatest - least);
            *value = Some(if inside > greatest { greatest } else { inside });
        }
        for (index, (reading, quantity)) in told(values).into_iter().zip(&QUANTITIES).enumerate() {
            let value = values[index].unwrap();
            let DecodedQuantity::Value(told) = reading else { panic!("{value} is {reading:?}") };
            prop_assert!(is_near(quantity, value, told, index == 1 || index == 2), "{value} is told as {told}");
        }
    }

    #[test]
    fn what_is_beyond_is_said_to_be(by in 1e-3_f32..1e6, missing in 0_usize..7) {
        for linear in [0, 3, 4, 5, 6] {
            let [least, greatest] = QUANTITIES[linear].range();
            let mut values = [Some(1.0); 7];
            values[linear] = Some(greatest + by);
            prop_assert_eq!(told(values)[linear], DecodedQuantity::Above);
            values[linear] = Some(least - by);
            prop_assert_eq!(told(values)[linear], DecodedQuantity::Below);
        }
        let mut values = [Some(1.0); 7];
        values[missing] = None;
        let readings = told(values);
        for (index, reading) in readings.into_iter().enumerate() {
            prop_assert_eq!(reading == DecodedQuantity::Missing, index == missing);
        }
        values[missing] = Some(f32::NAN);
        prop_assert_eq!(told(values)[missing], DecodedQuantity::Missing);
    }

    #[test]
    fn an_angle_is_the_same_after_any_number_of_turns(angle in 0.0..std::f32::consts::TAU, turns in -3_i32..3) {
        for cyclic in [1, 2] {
            let mut values = [Some(1.0); 7];
            values[cyclic] = Some(angle + turns as f32 * std::f32::consts::TAU);
            let DecodedQuantity::Value(told) = told(values)[cyclic] else { panic!() };
            let apart = libm::remainder(f64::from(angle) - f64::from(told), std::f64::consts::TAU);
            prop_assert!(apart.abs() <= f64::from(QUANTITIES[cyclic].step()) / 2.0 + 1e-5);
        }
    }
}

#[test]
fn the_ends_of_a_range_are_inside_and_every_code_is_one_reading() {
    for quantity in QUANTITIES {
        let [least, greatest] = quantity.range();
        let codes = 1_u32 << quantity.bits();
        for code in (0..codes).map(|code| code as u16) {
            if let DecodedQuantity::Value(value) = quantity.decode(code) {
                assert_eq!(quantity.code(Some(value)), code);
            }
        }
        let is_value = |x| matches!(quantity.decode(quantity.code(Some(x))), DecodedQuantity::Value(_));
        assert!(is_value(least) && is_value(greatest));
    }
}

#[test]
fn grade_kind_and_toolface_survive() {
    for kind in [SurveyKind::Continuous, SurveyKind::Stationary, SurveyKind::Rotating] {
        for grade in [None, Some(Grade::Good), Some(Grade::Doubtful), Some(Grade::Bad)] {
            for toolface_kind in [ToolfaceKind::Gravity, ToolfaceKind::Magnetic] {
                let survey = Survey { kind, toolface_kind, ..survey([Some(1.0); 7]) };
                let word = SurveyWord::unpack(&SurveyWord::pack(&survey, grade)).unwrap();
                assert_eq!((word.kind, word.grade, word.toolface_kind), (kind, grade, toolface_kind));
            }
        }
    }
}

#[test]
fn one_and_two_wrong_bits_and_bursts_of_seven_are_found() {
    let flip = |word: &mut [u8; SURVEY_WORD_BYTES], bit: usize| word[bit / 8] ^= 0x80 >> (bit % 8);
    for value in [0.0, 0.3, 1.1, 9.8, 50.0] {
        let right = SurveyWord::pack(&survey([Some(value); 7]), Some(Grade::Good));
        for first in 0..80 {
            for second in first..80 {
                let mut word = right;
                flip(&mut word, first);
                if second > first {
                    flip(&mut word, second);
                }
                assert_eq!(SurveyWord::unpack(&word), Err(SurveyWordError::Damaged), "{first} {second}");
            }
            for pattern in 1..128_u8 {
                let mut word = right;
                for bit in (0..7).filter(|bit| pattern >> bit & 1 == 1 && first + bit < 80) {
                    flip(&mut word, first + bit);
                }
                assert_eq!(SurveyWord::unpack(&word).is_ok(), word == right, "{first} {pattern:#b}");
            }
        }
    }
}

#[test]
fn a_line_that_is_stuck_says_no_survey() {
    for byte in [0, 255] {
        assert!(SurveyWord::unpack(&[byte; SURVEY_WORD_BYTES]).is_err());
    }
}
