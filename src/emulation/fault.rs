//! Faults of a part, and when they strike.

/// Fault inside a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PartFault {
    /// The identification register reads another part's value.
    WrongIdentification,
    /// Data ready is asserted, on the pin and in the registers, whether or not there is anything new.
    DataReadyStuckHigh,
    /// Data ready is never asserted.
    DataReadyStuckLow,
    /// The FIFO overruns: its oldest half is lost. On a part without FIFO the unread measurement is lost.
    FifoOverrun,
    /// A brown-out: every register is back at its default, the FIFO is empty, nothing converts any more.
    SilentReset,
    /// Conversions go on and give the word of the last one before the fault.
    FrozenOutput,
    /// One axis reads exact zeros: 0 to 2 x, y, z of the gyro (of the magnetometer), 3 to 5 of the accelerometer.
    DeadAxis(u8),
}

/// A fault and when it strikes: with the transaction of this number (the first is 0), for this long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Injection<F> {
    /// Fault.
    pub fault: F,
    /// Number of transactions before the fault.
    pub at_transaction: u32,
    /// Duration of the fault from its transaction on, microseconds; 0: that one transaction only.
    pub lasting_us: u64,
}

/// Schedule of one fault, with counts of the transactions so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule<F> {
    injection: Option<Injection<F>>,
    transactions: u32,
    bytes: u64,
    struck_at_us: Option<u64>,
}

impl<F: Copy> Schedule<F> {
    /// Schedules no fault.
    #[must_use]
    pub const fn none() -> Self {
        Self { injection: None, transactions: 0, bytes: 0, struck_at_us: None }
    }

    /// Schedules this fault.
    #[must_use]
    pub const fn of(injection: Injection<F>) -> Self {
        Self { injection: Some(injection), ..Self::none() }
    }

    /// Transactions so far, also those that failed.
    #[must_use]
    pub const fn transactions(&self) -> u32 {
        self.transactions
    }

    /// Bytes of these transactions, written and read; counted by a `FaultyBus`, not by a model.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(super) const fn moves(&mut self, bytes: usize) {
        self.bytes = self.bytes.saturating_add(bytes as u64);
    }

    /// Time at which the fault struck, microseconds; `None` before.
    #[must_use]
    pub const fn struck_at_us(&self) -> Option<u64> {
        self.struck_at_us
    }

    pub(super) fn lasting_us(&self) -> u64 {
        self.injection.map_or(0, |injection| injection.lasting_us)
    }

    /// Counts a transaction. Returns the fault if it strikes with this one.
    pub(super) fn begin(&mut self, now_us: u64) -> Option<F> {
        let number = self.transactions;
        self.transactions = self.transactions.saturating_add(1);
        let injection = self.injection.filter(|injection| injection.at_transaction == number)?;
        self.struck_at_us = Some(now_us);
        Some(injection.fault)
    }

    /// Returns the fault if it acts at `now_us`.
    pub(super) fn acting(&self, now_us: u64) -> Option<F> {
        let (injection, struck) = (self.injection?, self.struck_at_us?);
        let of_this_transaction = injection.at_transaction.checked_add(1) == Some(self.transactions);
        let over = now_us.saturating_sub(struck) >= injection.lasting_us;
        if over && !(injection.lasting_us == 0 && of_this_transaction) { None } else { Some(injection.fault) }
    }
}

#[cfg(test)]
mod tests;
