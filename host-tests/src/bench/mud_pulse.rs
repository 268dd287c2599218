//! Surveys that reach the surface: survey words over a channel with bursts, by their check alone and by the
//! receiver.

use std::f64::consts::TAU;

use meerkat_mwd::{
    config::{Earth, SurveyLimits},
    survey::{Grade, Survey, SurveyKind, ToolfaceKind, Uncertain},
    telemetry::survey_word::{
        DecodedQuantity, Expected, Received, SURVEY_WORD_BITS, SURVEY_WORD_BYTES, SurveyReceiver, SurveyWord, soft,
    },
};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use testbed::study::{Cell, Effort, Table, seeds::each_seed};

/// Surveys of one seed: stations of a hole.
const STATIONS: u64 = 2_000;
/// Times that a word is sent at most, until the receiver has a survey.
const SENT: usize = 4;
/// Turn of the hole from station to station, at most, radians: 30 m at 8 deg over 30 m.
const TURN_RAD: f64 = 8.0 * std::f64::consts::PI / 180.0;

/// Channel of Gilbert and Elliott: bits are wrong now and then, and in bursts each by even odds.
#[derive(Clone, Copy, Debug)]
pub struct Channel {
    /// Probability that a bit outside a burst is wrong.
    pub wrong: f64,
    /// Probability that a burst begins at a bit.
    pub burst: f64,
    /// Mean length of a burst, bits.
    pub length: f64,
    /// Probability that a station is disturbed: its field is off by 3 microtesla, its dip by 1.5 deg.
    pub disturbed: f64,
}

/// Counts over stations.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Words sent once.
    pub words: u64,
    /// Number of these words that were damaged.
    pub damaged: u64,
    /// Number of these words that the check passed though they were damaged.
    pub undetected: u64,
    /// Stations.
    pub stations: u64,
    /// Stations that the receiver had after so many words.
    pub after: [u64; SENT],
    /// Surveys that the receiver gave but that were not the ones sent.
    pub false_surveys: u64,
    /// Stations at which a word was doubted first.
    pub doubted: u64,
}

fn unit(random: &mut Xoshiro256PlusPlus) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

fn between(random: &mut Xoshiro256PlusPlus, low: f64, high: f64) -> f64 {
    low + (high - low) * unit(random)
}

/// Sends a word through the channel, which stays in a burst from word to word.
fn received(
    word: [u8; SURVEY_WORD_BYTES],
    channel: &Channel,
    in_burst: &mut bool,
    random: &mut Xoshiro256PlusPlus,
) -> [u8; SURVEY_WORD_BYTES] {
    let mut word = word;
    for k in 0..SURVEY_WORD_BITS {
        let changes = if *in_burst { 1.0 / channel.length } else { channel.burst };
        *in_burst ^= unit(random) < changes;
        if unit(random) < if *in_burst { 0.5 } else { channel.wrong } {
            word[k / 8] ^= 0x80 >> (k % 8);
        }
    }
    word
}

fn survey(inclination: f64, azimuth: f64, earth: &Earth, disturbed: bool, random: &mut Xoshiro256PlusPlus) -> Survey {
    let mut normal = || (0..12).map(|_| unit(random)).sum::<f64>() - 6.0;
    let uncertain = |value: f64| Uncertain { value: value as f32, sigma: 0.01 };
    let off = f64::from(u8::from(disturbed));
    let gravity = f64::from(earth.gravity_m_s2) + 0.005 * normal();
    let field = f64::from(earth.magnetic_field_ut.unwrap_or(50.0)) + 0.12 * normal() + 3.0 * off;
    let dip = f64::from(earth.dip_rad.unwrap_or(1.2)) + (0.1 * normal() + 1.5 * off).to_radians();
    Survey {
        kind: SurveyKind::Stationary,
        t_start_us: 0,
        t_end_us: 1,
        inclination_rad: uncertain(inclination),
        magnetic_azimuth_rad: Some(uncertain(azimuth)),
        true_azimuth_rad: None,
        grid_azimuth_rad: None,
        gravity_toolface_rad: Some(uncertain(between(random, 0.0, TAU))),
        magnetic_toolface_rad: None,
        toolface_kind: ToolfaceKind::Gravity,
        gravity_m_s2: Some(uncertain(gravity)),
        field_ut: Some(uncertain(field)),
        dip_rad: Some(uncertain(dip)),
        temperature_c: Some(90.0),
        rotating: false,
    }
}

/// Reference field of the place: 50 microtesla and 72 deg of dip.
const fn earth() -> Earth {
    Earth {
        gravity_m_s2: 9.81,
        magnetic_field_ut: Some(50.0),
        dip_rad: Some(1.256_637),
        declination_rad: None,
        latitude_rad: None,
    }
}

/// Sends a hole's stations; `twice`: every survey has to come twice.
#[must_use]
pub fn sent(channel: &Channel, twice: bool, seed: u64) -> Counts {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let earth = earth();
    let expected = Expected { earth, limits: SurveyLimits::default(), turn_rad: TURN_RAD as f32, twice };
    let mut receiver = SurveyReceiver::new(expected);
    let mut counts = Counts { stations: STATIONS, ..Counts::default() };
    let (mut inclination, mut azimuth) = (0.8, between(&mut random, 0.0, TAU));
    let mut in_burst = false;
    for _ in 0..STATIONS {
        inclination = (inclination + between(&mut random, -0.4, 0.4) * TURN_RAD).clamp(0.02, 1.6);
        azimuth += between(&mut random, -0.4, 0.4) * TURN_RAD;
        let disturbed = unit(&mut random) < channel.disturbed;
        let word = SurveyWord::pack(&survey(inclination, azimuth, &earth, disturbed, &mut random), Some(Grade::Good));
        let truth = SurveyWord::unpack(&word).ok();
        receiver.begin();
        let mut doubted = false;
        for after in 0..SENT {
            let got = received(word, channel, &mut in_burst, &mut random);
            counts.words += 1;
            counts.damaged += u64::from(got != word);
            counts.undetected += u64::from(got != word && SurveyWord::unpack(&got).is_ok());
            match receiver.push(&soft(&got)) {
                Ok(Received::Survey(survey)) => {
                    counts.false_surveys += u64::from(Some(survey) != truth);
                    counts.after[after] += 1;
                    break;
                }
                Ok(Received::Doubted(_)) => doubted = true,
                Err(_) => {}
            }
        }
        counts.doubted += u64::from(doubted);
    }
    counts
}

/// Random words: shares that the check takes for a survey, and that the receiver goes by.
#[must_use]
pub fn noise(seed: u64) -> [u64; 3] {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let turn_rad = TURN_RAD as f32;
    let expected = Expected { earth: earth(), limits: SurveyLimits::default(), turn_rad, twice: false };
    let mut receiver = SurveyReceiver::new(expected);
    let station = survey(0.8, 2.0, &earth(), false, &mut random);
    let _ = receiver.push(&soft(&SurveyWord::pack(&station, None)));
    let (mut passed, mut believed) = (0, 0);
    let words = 20 * STATIONS;
    for _ in 0..words {
        let mut word = [0; SURVEY_WORD_BYTES];
        word.iter_mut().for_each(|byte| *byte = random.next_u32() as u8);
        receiver.begin();
        let believes =
            |got| matches!(got, Ok(Received::Survey(SurveyWord { inclination_rad: DecodedQuantity::Value(_), .. })));
        passed += u64::from(SurveyWord::unpack(&word).is_ok());
        believed += u64::from(believes(receiver.push(&soft(&word))));
    }
    [words, passed, believed]
}

/// Channels that the table has.
#[must_use]
pub fn channels() -> [(&'static str, Channel); 6] {
    let bits = |wrong| Channel { wrong, burst: 0.0, length: 1.0, disturbed: 0.0 };
    let bursts = |burst, length| Channel { wrong: 0.001, burst, length, disturbed: 0.0 };
    [
        ("one bit in a thousand wrong", bits(0.001)),
        ("one bit in a hundred wrong", bits(0.01)),
        ("a burst of 5 bits in 250", bursts(0.004, 5.0)),
        ("a burst of 20 bits in 250", bursts(0.004, 20.0)),
        ("a burst of 40 bits in 100", bursts(0.01, 40.0)),
        ("a burst of 20 bits in 250, a tenth of the stations disturbed", {
            Channel { disturbed: 0.1, ..bursts(0.004, 20.0) }
        }),
    ]
}

/// The tables.
pub fn run(effort: Effort) -> anyhow::Result<Vec<Table>> {
    let count = effort.repetitions(500);
    let mut table = Table::new(
        format!(
            "Survey words over a channel with bursts, {} stations each. By the check alone: of words, and of those that pass. By the receiver: each word sent until it has a survey, at most {SENT} times",
            count * STATIONS
        ),
        &[
            "channel",
            "words damaged, %",
            "of damaged words pass the check, %",
            "false among those that pass, per million",
            "receiver has a survey after one word, %",
            "two",
            "three",
            "four",
            "false among its surveys, per million",
            "stations doubted first, %",
            "every survey twice: after four words, %",
            "false, per million",
        ],
    );
    for (name, channel) in channels() {
        let all = each_seed(0..count, |seed| Ok(sent(&channel, false, seed)))?;
        let twice = each_seed(0..count, |seed| Ok(sent(&channel, true, seed)))?;
        let sum = |of: &dyn Fn(&Counts) -> u64| all.iter().map(of).sum::<u64>();
        let share = |part: u64, whole: u64| part as f64 / whole.max(1) as f64;
        let (words, damaged, undetected) = (sum(&|c| c.words), sum(&|c| c.damaged), sum(&|c| c.undetected));
        let stations = sum(&|c| c.stations);
        let after = |most: usize| sum(&|c| c.after[..most].iter().sum());
        let mut row = vec![
            name.into(),
            Cell::percent(share(damaged, words), 1),
            Cell::percent(share(undetected, damaged), 2),
            Cell::number(1e6 * share(undetected, words - damaged + undetected), 1),
        ];
        row.extend((1..=SENT).map(|most| Cell::percent(share(after(most), stations), 1)));
        row.push(Cell::number(1e6 * share(sum(&|c| c.false_surveys), after(SENT)), 1));
        row.push(Cell::percent(share(sum(&|c| c.doubted), stations), 2));
        let given = twice.iter().flat_map(|counts| counts.after).sum::<u64>();
        row.push(Cell::percent(share(given, stations), 1));
        row.push(Cell::number(1e6 * share(twice.iter().map(|counts| counts.false_surveys).sum(), given), 1));
        table.row(row);
    }
    let all = each_seed(0..count, |seed| Ok(noise(seed)))?;
    let [words, passed, believed] = [0, 1, 2].map(|k| all.iter().map(|counts| counts[k]).sum::<u64>());
    let mut noise = Table::new(
        format!("{words} random words, as a decoder may read without a signal, after a station"),
        &["pass the check, %", "believed by the receiver, per million"],
    );
    noise.row(vec![
        Cell::percent(passed as f64 / words as f64, 3),
        Cell::number(1e6 * believed as f64 / words as f64, 2),
    ]);
    Ok(vec![table, noise])
}
