//! Plan of what goes wrong, and when: drawn from the seed.

use super::proportions::Proportions;
use meerkat_mwd::{
    application::Stage,
    emulation::{BusFault, PartFault},
};
use mock_flash::{CUTS, Cut};
use testbed::simulate::Random;

/// Something that happens to the probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    /// The power fails at once.
    PowerCut,
    /// The power fails in the middle of a change of the flash, so many words and sectors from now.
    CutInFlash(u64, Cut),
    /// After a cut in the flash, a bit of the word that was being programmed reads as it likes.
    MarginalBit,
    /// After a cut in the flash, the word that was being programmed cannot be read: error correction gives up on it.
    UnreadableTorn,
    /// A word of what the flash holds cannot be read any more after a time without power.
    UnreadableRotten,
    /// One bit of what the flash holds changes while the power is off.
    BitRot,
    /// The latest copy of the counter of commands changes by one bit, or cannot be read any more, while the power
    /// is off.
    CounterRotten,
    /// The wire to gyro and accelerometer, or that to the magnetometer, fails for so many microseconds.
    Wire(bool, BusFault, u64),
    /// Gyro and accelerometer, or the magnetometer, fail for so many microseconds.
    Part(bool, PartFault, u64),
    /// Gyro and accelerometer fall silent shortly before the tool moves, and an owner asks for a change.
    SilentStart,
    /// Bits of the line change, in both directions, one in so many bytes, for so many microseconds.
    LineNoise(u32, u64),
    /// The line takes nothing for so many microseconds.
    LineStall(u64),
    /// So many commands without the key, as fast as the line goes.
    Flood(u8),
    /// Bytes that are no frames.
    Garbage(u16),
    /// A command of the owner, heard on the line, is sent again.
    Replay,
    /// A command that is signed with another key.
    WrongKey,
    /// A command that its owner signed for another probe.
    OtherProbe,
    /// The clock steps by so many microseconds.
    ClockStep(i64),
    /// All work takes so many times as long, for so many microseconds.
    Overload(u64, u64),
    /// A stage never comes to its end.
    Hang(Stage),
    /// The owner asks for something: no trouble.
    Owner,
}

/// Names of the kinds of trouble, in the order of the table.
pub const KINDS: [&str; 22] = [
    "power cut",
    "power cut planned within the next 80 words or sectors, tearing one",
    "the same, before or after one",
    "marginal bit in the word of the cut",
    "torn word that cannot be read",
    "whole word that cannot be read any more",
    "bit of the flash that changes",
    "damage of the counter's latest copy",
    "fault of a sensor's bus",
    "fault of a sensor",
    "sensors that fall silent at rest, then drilling",
    "noise on the line",
    "line that takes nothing",
    "flood of commands without the key",
    "garbage on the line",
    "command sent again",
    "command with another key",
    "command for another probe",
    "clock that jumps ahead",
    "clock that goes back for good",
    "overload",
    "stage that hangs",
];

impl Trouble {
    /// Its place among [`KINDS`]; one behind them: it is none.
    pub const fn kind(&self) -> usize {
        match self {
            Self::PowerCut => 0,
            Self::CutInFlash(_, Cut::Torn) => 1,
            Self::CutInFlash(..) => 2,
            Self::MarginalBit => 3,
            Self::UnreadableTorn => 4,
            Self::UnreadableRotten => 5,
            Self::BitRot => 6,
            Self::CounterRotten => 7,
            Self::Wire(..) => 8,
            Self::Part(..) => 9,
            Self::SilentStart => 10,
            Self::LineNoise(..) => 11,
            Self::LineStall(..) => 12,
            Self::Flood(_) => 13,
            Self::Garbage(_) => 14,
            Self::Replay => 15,
            Self::WrongKey => 16,
            Self::OtherProbe => 17,
            Self::ClockStep(0..) => 18,
            Self::ClockStep(_) => 19,
            Self::Overload(..) => 20,
            Self::Hang(_) => 21,
            Self::Owner => KINDS.len(),
        }
    }

    /// Returns true if the program starts again after it.
    const fn restarts(&self) -> bool {
        matches!(self, Self::PowerCut | Self::CutInFlash(..) | Self::Hang(_))
    }

    /// Draws a trouble.
    fn draw(random: &mut Random) -> Self {
        let lasting = |random: &mut Random, low: f64, high: f64| (random.between(low, high) * 1e6) as u64;
        match random.index(19) {
            0 => Self::PowerCut,
            1 | 2 => {
                let cut = CUTS[random.index(CUTS.len())];
                Self::CutInFlash(random.index(80) as u64, cut)
            }
            3 | 4 => {
                let faults = [
                    BusFault::Nack,
                    BusFault::ArbitrationLoss,
                    BusFault::TimeOut,
                    BusFault::Locked,
                    BusFault::ShortRead { whole: random.index(12) as u16 },
                    BusFault::BitFlip { bit: random.index(200) as u16 },
                ];
                let fault = faults[random.index(faults.len())];
                let long = if fault == BusFault::TimeOut { 0.05 } else { 3.0 };
                Self::Wire(random.uniform() < 0.6, fault, lasting(random, 0.0, long))
            }
            5 | 6 => {
                let faults = [
                    PartFault::DataReadyStuckHigh,
                    PartFault::DataReadyStuckLow,
                    PartFault::FifoOverrun,
                    PartFault::SilentReset,
                    PartFault::FrozenOutput,
                    PartFault::DeadAxis(random.index(6) as u8),
                    PartFault::WrongIdentification,
                ];
                let fault = faults[random.index(faults.len())];
                Self::Part(random.uniform() < 0.6, fault, lasting(random, 0.0, 4.0))
            }
            7 => Self::LineNoise(20 + random.index(400) as u32, lasting(random, 0.2, 4.0)),
            8 => Self::LineStall(lasting(random, 0.1, 2.0)),
            9 => Self::Flood(10 + random.index(90) as u8),
            10 => Self::Garbage(random.index(1_000) as u16),
            11 | 12 => Self::Replay,
            13 => Self::WrongKey,
            14 => Self::OtherProbe,
            15 => Self::ClockStep(lasting(random, 0.05, 30.0) as i64),
            16 => Self::ClockStep(-(lasting(random, 0.05, 30.0) as i64)),
            17 => Self::Overload(4 + random.index(21) as u64, lasting(random, 0.3, 3.0)),
            _ => Self::Hang([Stage::Acquisition, Stage::Samples, Stage::Work, Stage::Telemetry][random.index(4)]),
        }
    }
}

/// Troubles of one run in order of time, microseconds.
pub fn draw(random: &mut Random, proportions: &Proportions, drilling_from_s: &[f64]) -> Vec<(u64, Trouble)> {
    let &Proportions { length_s, pauses_s, owner_s, silent_starts, goes_through, .. } = proportions;
    let mut plan = Vec::new();
    let mut at_s = random.between(0.5, 3.0);
    let pause_s = match *pauses_s {
        [pause_s] => pause_s,
        _ => pauses_s[random.index(pauses_s.len())],
    };
    while at_s < length_s {
        plan.push(((at_s * 1e6) as u64, Trouble::draw(random)));
        at_s += pause_s * random.exponential();
    }
    let mut at_s = random.between(0.5, 3.0);
    while at_s < length_s {
        plan.push(((at_s * 1e6) as u64, Trouble::Owner));
        at_s += owner_s * random.exponential();
    }
    for begin_s in drilling_from_s {
        if random.uniform() < silent_starts {
            plan.push((((begin_s - random.between(0.1, 0.6)) * 1e6) as u64, Trouble::SilentStart));
        }
    }
    if goes_through > 0.0 && random.uniform() < goes_through {
        plan.retain(|(_, trouble)| !trouble.restarts());
    }
    plan.sort_by_key(|(at_us, _)| *at_us);
    plan
}
