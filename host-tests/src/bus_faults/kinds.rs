//! Kinds of faults that are tried, and the cases of each.

use meerkat_mwd::emulation::{BusFault, Injection, PartFault};

/// A fault of a part or of its wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A fault inside the part.
    Part(PartFault),
    /// A fault of the wire.
    Wire(BusFault),
}

/// A part on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The gyro and accelerometer ISM330DHCX.
    Ism330dhcx,
    /// The magnetometer RM3100.
    Rm3100,
}

/// A kind of fault: a row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Name of the row.
    pub name: &'static str,
    /// Duration of the fault, microseconds.
    pub lasting_us: u64,
    /// The faults of this kind.
    pub faults: fn(Part) -> Vec<Fault>,
}

/// One fault at one transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// The part that it strikes.
    pub part: Part,
    /// The fault.
    pub fault: Fault,
    /// Number of the transaction with this part at which it strikes.
    pub at_transaction: u32,
    /// Duration, microseconds.
    pub lasting_us: u64,
}

impl Case {
    /// The plan for the part's model; none if the fault is the wire's.
    #[must_use]
    pub fn part_injection(&self) -> Option<Injection<PartFault>> {
        let Fault::Part(fault) = self.fault else { return None };
        Some(Injection { fault, at_transaction: self.at_transaction, lasting_us: self.lasting_us })
    }

    /// The plan for the wire; none if the fault is the part's.
    #[must_use]
    pub fn wire_injection(&self) -> Option<Injection<BusFault>> {
        let Fault::Wire(fault) = self.fault else { return None };
        Some(Injection { fault, at_transaction: self.at_transaction, lasting_us: self.lasting_us })
    }
}

const fn kind(name: &'static str, lasting_ms: u64, faults: fn(Part) -> Vec<Fault>) -> Kind {
    Kind { name, lasting_us: 1_000 * lasting_ms, faults }
}

/// All kinds. [`cases`] adds a number that depends on the transaction to the position of a flipped bit.
pub const KINDS: &[Kind] = &[
    kind("not acknowledged", 0, |_| vec![Fault::Wire(BusFault::Nack)]),
    kind("arbitration lost", 0, |_| vec![Fault::Wire(BusFault::ArbitrationLoss)]),
    kind("time-out of 10 ms", 10, |_| vec![Fault::Wire(BusFault::TimeOut)]),
    kind("bus locked for 20 ms", 20, |_| vec![Fault::Wire(BusFault::Locked)]),
    kind("short read", 0, |_| [0, 1, 2, 5, 8, 11].map(|whole| Fault::Wire(BusFault::ShortRead { whole })).to_vec()),
    kind("bit flipped", 0, |_| (0..8).map(|bit| Fault::Wire(BusFault::BitFlip { bit })).collect()),
    kind("wrong identification for 50 ms", 50, |_| vec![Fault::Part(PartFault::WrongIdentification)]),
    kind("data ready stuck high for 100 ms", 100, |_| vec![Fault::Part(PartFault::DataReadyStuckHigh)]),
    kind("data ready stuck low for 100 ms", 100, |_| vec![Fault::Part(PartFault::DataReadyStuckLow)]),
    kind("FIFO overrun, or a reading lost", 0, |_| vec![Fault::Part(PartFault::FifoOverrun)]),
    kind("silent reset", 0, |_| vec![Fault::Part(PartFault::SilentReset)]),
    kind("output frozen for 300 ms", 300, |_| vec![Fault::Part(PartFault::FrozenOutput)]),
    kind("one axis dead for 300 ms", 300, |part| {
        let axes = if part == Part::Ism330dhcx { 6 } else { 3 };
        (0..axes).map(|axis| Fault::Part(PartFault::DeadAxis(axis))).collect()
    }),
];

/// The cases of a kind at every transaction up to `transactions`.
#[must_use]
pub fn cases(kind: &Kind, part: Part, transactions: u32) -> Vec<Case> {
    let faults = (kind.faults)(part);
    (0..transactions)
        .flat_map(|at_transaction| {
            faults.iter().map(move |fault| {
                let fault = match *fault {
                    // Flip another bit in each transaction: 61 is prime to every length.
                    Fault::Wire(BusFault::BitFlip { bit }) => Fault::Wire(BusFault::BitFlip {
                        bit: ((u32::from(bit) * 23 + 61 * at_transaction) % 60_000) as u16,
                    }),
                    other => other,
                };
                Case { part, fault, at_transaction, lasting_us: kind.lasting_us }
            })
        })
        .collect()
}
