//! A firmware's main loop in 40 lines: an interrupt puts samples into a queue; the loop drains it, sends what there is
//! to say, and spends the rest of its time on identification. No executor, no operating system.
//!
//! `cargo run --example super_loop --features telemetry`

use heapless::spsc::{Consumer, Queue};
use meerkat_mwd::{
    Probe, Sample,
    config::ConfigError,
    telemetry::{
        AttitudeFrame, EncodeError, Identification, MAX_FRAME, MAX_PAYLOAD, Payload, encode_frame, encode_payload,
    },
};

pub(crate) mod motion;

/// A frame of a payload to the line.
fn send<P: Payload>(payload: &P, sequence: &mut u16, line: &mut impl FnMut(&[u8])) -> Result<(), EncodeError> {
    let (mut room, mut frame) = ([0; MAX_PAYLOAD], [0; MAX_FRAME]);
    line(encode_frame(P::KIND, *sequence, encode_payload(payload, &mut room)?, &mut frame)?);
    *sequence = sequence.wrapping_add(1);
    Ok(())
}

/// Runs once for each wake-up, as after `wfi`: drains the queue, then does as much work as its samples have brought.
fn turn(
    probe: &mut Probe,
    samples: &mut Consumer<'_, Sample>,
    sequence: &mut u16,
    line: &mut impl FnMut(&[u8]),
) -> Result<(), EncodeError> {
    // A queue holds 15 samples, so this product is small.
    let mut budget = 0;
    while let Some(sample) = samples.dequeue() {
        budget += probe.poll_budget();
        if let Some(output) = probe.push(&sample) {
            send(&AttitudeFrame::of(&output), sequence, line)?;
        }
    }
    if let Some(report) = probe.poll(budget) {
        send(&Identification { report, temperature_c: None }, sequence, line)?;
    }
    Ok(())
}

/// Plays 90 s; returns the bytes that went over the line, and how far P is from the gyro's.
pub(crate) fn fly() -> Result<(usize, f32), ConfigError> {
    let (mut probe, mut sequence, mut sent) = (Box::new(Probe::new()), 0, 0);
    probe.configure(&motion::config())?;
    // On a chip a static, split between the interrupt and the loop.
    let mut queue = Queue::<Sample, 16>::new();
    let (mut interrupt, mut samples) = queue.split();
    for sample in motion::samples(90.0, |_| nalgebra::Vector3::zeros()) {
        // A full queue is a loop that is too slow: count it.
        let _ = interrupt.enqueue(sample);
        let _ = turn(&mut probe, &mut samples, &mut sequence, &mut |bytes| sent += bytes.len());
    }
    let apart =
        probe.gyro_model().p.as_flattened().iter().zip(motion::TRUE.p.as_flattened()).map(|(a, b)| (a - b).abs());
    Ok((sent, apart.fold(0.0, |most, x| if x > most { x } else { most })))
}

pub(crate) fn main() -> Result<(), ConfigError> {
    let (bytes, apart) = fly()?;
    println!("{bytes} bytes sent; P within {apart:.4} of the gyro's");
    Ok(())
}
