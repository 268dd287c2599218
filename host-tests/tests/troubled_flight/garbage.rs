//! Streams that no one would send: whatever comes, the pipeline stays finite, counts everything and never
//! panics.

use std::sync::LazyLock;

use meerkat_mwd::{
    Config, Probe, Sample, SampleFlags,
    config::{FullScale, OptimizerKind},
};
use proptest::{collection::vec, option, prelude::*};

use crate::rig::run::{Run, run, sound_output, sound_report};

static BASE: LazyLock<Run> = LazyLock::new(|| run(80.0, 3));

/// Trouble that some samples in a row have.
#[derive(Clone, Debug)]
enum Trouble {
    /// A field of the first nine, or the temperature, has this value.
    Value(usize, f32),
    /// All readings times this.
    Scaled(f32),
    /// All readings are those of this sample.
    Frozen(usize),
    Flags(u16),
    Lost,
    /// Time moves by so much for this and all later samples.
    Jump(u64),
    /// Time is off by so much for these samples only.
    Off(i64),
    /// At this very time.
    At(u64),
    NotPolled,
}

fn any_trouble() -> impl Strategy<Value = Trouble> {
    let extreme = prop_oneof![Just(0), Just(u64::MAX), Just(u64::MAX - 10_000_000), any::<u64>()];
    prop_oneof![
        (0_usize..10, any::<f32>()).prop_map(|(field, value)| Trouble::Value(field, value)),
        (0_usize..10, -100.0..100.0_f32).prop_map(|(field, value)| Trouble::Value(field, value)),
        (-40.0..40.0_f32).prop_map(Trouble::Scaled),
        (0_usize..8_000).prop_map(Trouble::Frozen),
        any::<u16>().prop_map(Trouble::Flags),
        Just(Trouble::Lost),
        prop_oneof![0_u64..100_000, 0_u64..20_000_000, 0_u64..100_000_000_000].prop_map(Trouble::Jump),
        (-1_000_000_i64..1_000_000).prop_map(Trouble::Off),
        extreme.prop_map(Trouble::At),
        Just(Trouble::NotPolled),
    ]
}

fn any_config() -> impl Strategy<Value = Config> {
    let full_scale = (option::of(0.01..50.0_f32), option::of(1.0..200.0_f32), option::of(1.0..200.0_f32));
    let optimizer = prop_oneof![
        Just(OptimizerKind::Imoa),
        Just(OptimizerKind::ImoaLiteral),
        Just(OptimizerKind::Moa),
        Just(OptimizerKind::Pso),
        Just(OptimizerKind::De),
        Just(OptimizerKind::Random),
        Just(OptimizerKind::Lm),
        Just(OptimizerKind::Ls),
    ];
    let earth =
        (option::of(20.0..70.0_f32), option::of(-1.5..1.5_f32), option::of(-3.0..3.0_f32), option::of(-1.5..1.5_f32));
    let period = prop_oneof![12 => Just(10_000), 1 => 100_u32..=20_000];
    (full_scale, optimizer, earth, period, any::<u64>()).prop_map(|(full_scale, optimizer, earth, period, seed)| {
        let mut config = BASE.config;
        let (gyro_rad_s, accel_m_s2, mag_ut) = full_scale;
        config.full_scale = FullScale { gyro_rad_s, accel_m_s2, mag_ut };
        (
            config.earth.magnetic_field_ut,
            config.earth.dip_rad,
            config.earth.declination_rad,
            config.earth.latitude_rad,
        ) = earth;
        config.identification.optimizer = optimizer;
        config.identification.max_evaluations = 60;
        (config.sample_period_us, config.seed) = (period, seed);
        config
    })
}

/// When nothing new takes effect any more, and with which sample the probe is told.
fn any_freeze() -> impl Strategy<Value = Option<(u64, usize)>> {
    option::weighted(0.3, (0_u64..100_000_000, prop_oneof![Just(0), 0_usize..8_000]))
}

/// Troubles over the base run: where each begins and for how many samples it lasts.
type Troubles = Vec<(usize, usize, Trouble)>;

fn any_troubles() -> impl Strategy<Value = Troubles> {
    let length = prop_oneof![Just(1_usize), 1_usize..200, 1_usize..3_000];
    // Few at a time most of the time, so that windows get through to the gate.
    let trouble = (0_usize..8_000, length, any_trouble()).boxed();
    prop_oneof![3 => vec(trouble.clone(), 0..6), 1 => vec(trouble, 0..40)]
}

/// The sample, and whether it is followed by a poll; `None` when it is lost.
fn troubled(index: usize, troubles: &Troubles, shift_us: &mut u64) -> Option<(Sample, bool)> {
    let mut sample = BASE.trace.samples[index];
    let mut polled = true;
    let mut time = None;
    for (from, length, trouble) in troubles.iter().filter(|(from, length, _)| (*from..from + length).contains(&index)) {
        match trouble {
            Trouble::Value(field @ 0..3, value) => sample.gyro_rad_s[*field] = *value,
            Trouble::Value(field @ 3..6, value) => sample.accel_m_s2[field - 3] = *value,
            Trouble::Value(field @ 6..9, value) => sample.mag_ut[field - 6] = *value,
            Trouble::Value(_, value) => sample.temperature_c = *value,
            Trouble::Scaled(factor) => {
                for readings in [&mut sample.gyro_rad_s, &mut sample.accel_m_s2, &mut sample.mag_ut] {
                    *readings = readings.map(|x| x * factor);
                }
            }
            Trouble::Frozen(other) => sample = Sample { t_us: sample.t_us, ..BASE.trace.samples[*other] },
            Trouble::Flags(bits) => sample.flags |= SampleFlags::from_bits_retain(*bits),
            Trouble::Lost => return None,
            Trouble::Jump(by_us) if index == *from && *length > 0 => *shift_us = shift_us.saturating_add(*by_us),
            Trouble::Jump(_) => {}
            Trouble::Off(by_us) => time = Some(sample.t_us.saturating_add(*shift_us).saturating_add_signed(*by_us)),
            Trouble::At(t_us) => time = (index == *from).then_some(*t_us).or(time),
            Trouble::NotPolled => polled = false,
        }
    }
    sample.t_us = time.unwrap_or(sample.t_us.saturating_add(*shift_us));
    Some((sample, polled))
}

fn survives(config: &Config, freeze: Option<(u64, usize)>, troubles: &Troubles, budget: u32) {
    let mut probe = Box::new(Probe::new());
    probe.configure(config).unwrap();
    let (mut pushed, mut shift_us, mut last_us, mut last_output_us) = (0_u64, 0, None, None);
    let mut doubted_us = None;
    for index in 0..BASE.trace.samples.len() {
        if let Some((at_us, _)) = freeze.filter(|(_, told)| *told == index) {
            probe.freeze(at_us);
        }
        let Some((sample, polled)) = troubled(index, troubles, &mut shift_us) else { continue };
        pushed += 1;
        let output = probe.push(&sample);
        let is_taken = match last_us {
            None => true,
            Some(last) => {
                let confirms =
                    |doubted: u64| 0 < doubted && doubted < sample.t_us && sample.t_us - doubted <= 10_000_000;
                let is_far = sample.t_us.abs_diff(last) > 10_000_000;
                let is_believed = if is_far { doubted_us.is_some_and(confirms) } else { sample.t_us > last };
                doubted_us = (is_far && !is_believed).then_some(sample.t_us);
                is_believed
            }
        };
        assert_eq!(output.is_some(), is_taken);
        if let Some(output) = output {
            // A delay of the gyro that is found, of 0.1 s at most, makes it valid earlier.
            assert!((sample.t_us.saturating_sub(110_000)..=sample.t_us).contains(&output.t_us));
            let began_afresh = probe.began_afresh();
            assert!(began_afresh || last_output_us.is_none_or(|last| output.t_us > last), "times of validity increase");
            last_output_us = Some(output.t_us);
            sound_output(&output);
            last_us = Some(sample.t_us);
        }
        if let Some(report) = polled.then(|| probe.poll(budget)).flatten() {
            sound_report(&report);
        }
        assert!(probe.gyro_model().is_valid());
        let counters = probe.counters();
        assert_eq!(counters.samples + u64::from(counters.out_of_order), pushed);
        assert!(u64::from(counters.gaps) < counters.samples && u64::from(counters.clipped) <= counters.samples);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn troubles_of_every_kind_over_a_real_run(
        config in any_config(), freeze in any_freeze(), troubles in any_troubles(), budget in 0_u32..2_000,
    ) {
        survives(&config, freeze, &troubles, budget);
    }

    #[test]
    fn samples_of_nothing_but_random_bits(
        bits in vec((any::<[u32; 10]>(), any::<u64>(), any::<u16>(), 0_u8..8), 1..3_000),
        config in any_config(),
    ) {
        let mut probe = Box::new(Probe::new());
        probe.configure(&config).unwrap();
        let mut t_us = 0_u64;
        for (pushed, (words, time, flags, kind)) in (1_u64..).zip(&bits) {
            let word = |k: usize| f32::from_bits(words[k]);
            t_us = match kind {
                0 => *time,
                1 => t_us.wrapping_sub(time % 100_000),
                2 => t_us.saturating_add(time % 10_000_000),
                _ => t_us.saturating_add(10_000),
            };
            let sample = Sample {
                t_us,
                gyro_rad_s: [word(0), word(1), word(2)],
                accel_m_s2: [word(3), word(4), word(5)],
                mag_ut: [word(6), word(7), word(8)],
                temperature_c: word(9),
                flags: if kind % 2 == 0 { SampleFlags::from_bits_retain(*flags) } else { SampleFlags::empty() },
            };
            if let Some(output) = probe.push(&sample) {
                sound_output(&output);
            }
            if let Some(report) = probe.poll(words[0] % 1_000) {
                sound_report(&report);
            }
            let counters = probe.counters();
            prop_assert_eq!(counters.samples + u64::from(counters.out_of_order), pushed);
        }
    }
}
