//! Receiver of survey words: what it goes by, what it doubts, and what repetitions add up to.

use meerkat_mwd::{
    config::{Earth, SurveyLimits},
    survey::{Survey, SurveyKind, ToolfaceKind, Uncertain},
    telemetry::survey_word::{
        Expected, Received, SURVEY_WORD_BYTES, SurveyReceiver, SurveyWord, SurveyWordError, soft,
    },
};
use mwd::bench::mud_pulse::{channels, noise, sent};

fn receiver() -> SurveyReceiver {
    let earth = Earth {
        gravity_m_s2: 9.81,
        magnetic_field_ut: Some(50.0),
        dip_rad: Some(72_f32.to_radians()),
        ..Earth::default()
    };
    SurveyReceiver::new(Expected { earth, limits: SurveyLimits::default(), turn_rad: 8_f32.to_radians(), twice: false })
}

/// Word of a direction in degrees and a field in microtesla.
fn word(inclination: f32, azimuth: f32, field: f32) -> [u8; SURVEY_WORD_BYTES] {
    let uncertain = |value: f32| Some(Uncertain { value, sigma: 0.1 });
    let survey = Survey {
        kind: SurveyKind::Stationary,
        t_start_us: 0,
        t_end_us: 1,
        inclination_rad: Uncertain { value: inclination.to_radians(), sigma: 0.1 },
        magnetic_azimuth_rad: uncertain(azimuth.to_radians()),
        true_azimuth_rad: None,
        grid_azimuth_rad: None,
        gravity_toolface_rad: uncertain(1.0),
        magnetic_toolface_rad: None,
        toolface_kind: ToolfaceKind::Gravity,
        gravity_m_s2: uncertain(9.81),
        field_ut: uncertain(field),
        dip_rad: uncertain(72_f32.to_radians()),
        temperature_c: Some(80.0),
        rotating: false,
    };
    SurveyWord::pack(&survey, None)
}

fn believed(got: Result<Received, SurveyWordError>) -> bool {
    matches!(got, Ok(Received::Survey(_)))
}

#[test]
fn a_word_that_looks_as_expected_is_gone_by_at_once() {
    let mut receiver = receiver();
    // North is no step; near the vertical azimuths may jump.
    for (inclination, azimuth) in [(2.0, 10.0), (2.0, 200.0), (8.0, 190.0), (14.0, 195.0)] {
        receiver.begin();
        assert!(believed(receiver.push(&soft(&word(inclination, azimuth, 50.2)))), "{inclination} {azimuth}");
    }
    let mut receiver = self::receiver();
    for azimuth in [357.0, 2.0] {
        receiver.begin();
        assert!(believed(receiver.push(&soft(&word(60.0, azimuth, 50.2)))), "{azimuth}");
    }
}

#[test]
fn a_disturbed_field_or_a_turn_that_no_hole_makes_is_doubted_until_the_word_comes_again() {
    for (azimuth, field) in [(105.0, 53.0), (130.0, 50.0)] {
        let mut receiver = receiver();
        assert!(believed(receiver.push(&soft(&word(60.0, 100.0, 50.0)))));
        receiver.begin();
        let doubted = word(60.0, azimuth, field);
        assert!(matches!(receiver.push(&soft(&doubted)), Ok(Received::Doubted(_))));
        // Another survey between is no repetition.
        receiver.begin();
        assert!(matches!(receiver.push(&soft(&doubted)), Ok(Received::Doubted(_))));
        assert!(believed(receiver.push(&soft(&doubted))));
    }
}

#[test]
fn three_damaged_repetitions_add_up_and_a_damaged_one_confirms_nothing() {
    let whole = word(60.0, 100.0, 50.0);
    let damaged = |bits: [usize; 3]| {
        let mut word = whole;
        bits.iter().for_each(|k| word[k / 8] ^= 0x80 >> (k % 8));
        word
    };
    let mut receiver = receiver();
    for bits in [[3, 30, 61], [7, 28, 70]] {
        assert_eq!(SurveyWord::unpack(&damaged(bits)), Err(SurveyWordError::Damaged));
        assert!(receiver.push(&soft(&damaged(bits))).is_err());
    }
    assert!(believed(receiver.push(&soft(&damaged([12, 45, 66])))));
    // Strong evidence outweighs weak: two are enough where the decoder knows how sure it is.
    let mut receiver = self::receiver();
    let weak = soft(&damaged([3, 30, 61]));
    let strong = soft(&whole).map(|bit| 3 * bit);
    let mut half = strong;
    half[0] = -half[0] / 3;
    half[40] = -half[40] / 3;
    assert!(receiver.push(&half).is_err());
    let mut other = weak.map(|bit| 2 * bit);
    for k in [3, 30, 61] {
        other[k] /= 2;
    }
    assert!(believed(receiver.push(&other)));
    // A doubted word and a word that is lost: nothing came twice.
    let mut receiver = self::receiver();
    assert!(matches!(receiver.push(&soft(&word(60.0, 100.0, 60.0))), Ok(Received::Doubted(_))));
    assert!(!believed(receiver.push(&[0; 80])));
    assert!(!believed(receiver.push(&soft(&[0; SURVEY_WORD_BYTES]))));
}

#[test]
fn over_a_channel_with_bursts_few_false_surveys_are_gone_by_and_none_where_all_come_twice() {
    let (_, channel) = channels()[4];
    let all: Vec<_> = (0..10).map(|seed| sent(&channel, false, seed)).collect();
    let sum = |of: fn(&mwd::bench::mud_pulse::Counts) -> u64| all.iter().map(of).sum::<u64>();
    let (undetected, wrong) = (sum(|counts| counts.undetected), sum(|counts| counts.false_surveys));
    println!("{undetected} damaged words pass the check, {wrong} become surveys");
    assert!(undetected > 100 && 5 * wrong <= undetected);
    let twice: Vec<_> = (0..10).map(|seed| sent(&channel, true, seed)).collect();
    assert_eq!(twice.iter().map(|counts| counts.false_surveys).sum::<u64>(), 0);
    assert!(twice.iter().map(|counts| counts.after.iter().sum::<u64>()).sum::<u64>() > 5_000);
    let [words, passed, believed] = noise(3);
    assert!(passed > words / 300 && believed <= words / 10_000, "{words} {passed} {believed}");
}
