//! Share of the line that hosts without the key can take, and what the owner's longest request takes.

use meerkat_mwd::{
    application::BURST_SAMPLES,
    compensation::MAX_ACTIVE,
    survey::BurstSample,
    telemetry::{
        Acknowledgement, Boot, BurstPart, CommandRefusal, FieldName, MAX_FRAME, MAX_PAYLOAD, Outcome, Payload,
        encode_frame, encode_payload,
    },
};
use mwd::power_cuts::{doses::dose, drawn::Dice, settings::longest_configuration};

/// Bytes of a message on the line.
fn length<P: Payload>(message: &P) -> f64 {
    let (mut payload, mut frame) = ([0; MAX_PAYLOAD], [0; MAX_FRAME]);
    let payload = encode_payload(message, &mut payload).unwrap();
    encode_frame(P::KIND, u16::MAX, payload, &mut frame).unwrap().len() as f64
}

/// Four answers and half a boot a second, as `ANSWERS` and `REPORTS` of `src/telemetry/command/gate.rs` allow.
#[test]
fn what_hosts_without_the_key_can_take_of_the_line() {
    let field = FieldName::try_from(&*"x".repeat(48)).unwrap();
    let refused = CommandRefusal::OutOfBounds { field };
    let answer = length(&Acknowledgement { sequence: u16::MAX, outcome: Outcome::Refused(refused) });
    let boot = |effects: usize| {
        let flies = Some(Dice::new(1).model(effects, 0, 1 << 40));
        let restored_model = Some(1_000);
        let boot = Boot::new(longest_configuration());
        length(&Boot { watchdog_resets: 100, first_sample: 1 << 28, restored_model, flies, ..boot })
    };
    let boots = [boot(0), boot(MAX_ACTIVE)];
    // `BOOT` of `src/application/line.rs`.
    assert!(boots.iter().all(|boot| *boot < 1_200.0), "{boots:?}");
    let bytes_per_s = boots.map(|boot| 4.0 * answer + 0.5 * boot);
    println!("an answer {answer}, a boot {boots:?} bytes; {bytes_per_s:?} bytes a second");
    assert!((500.0..=550.0).contains(&bytes_per_s[0]) && (800.0..=840.0).contains(&bytes_per_s[1]), "{bytes_per_s:?}");
}

/// A second at 200 Hz, in parts, ten days after the start.
#[test]
fn the_dose_and_the_raw_samples_of_the_worst_second_take_5000_bytes() {
    let sample = |k| BurstSample {
        t_us: 864_000_000_000 + 5_000 * k as u64,
        accel_m_s2: [9.1, -80.3, 0.7],
        axial_rate_rad_s: 12.3,
    };
    let part = |first: usize| BurstPart {
        first: first as u16,
        of: BURST_SAMPLES as u16,
        rms_m_s2: 61.7,
        samples: (first..BURST_SAMPLES.min(first + BurstPart::SAMPLES)).map(sample).collect(),
    };
    let burst: f64 = (0..BURST_SAMPLES).step_by(BurstPart::SAMPLES).map(|first| length(&part(first))).sum();
    let dose = length(&dose(240));
    println!("{burst} and {dose} bytes");
    assert!((4_800.0..=5_000.0).contains(&(burst + dose)), "{burst} {dose}");
}
