//! Fault injection around an I2C bus.

use super::{Course, FaultyBus, Flip, InjectedError, OPERATIONS, spoil};
use embedded_hal::i2c::{I2c, Operation, SevenBitAddress};
use heapless::Vec;

impl<B: embedded_hal::i2c::ErrorType> embedded_hal::i2c::ErrorType for FaultyBus<'_, B> {
    type Error = InjectedError<B::Error>;
}

fn length(operation: &Operation<'_>) -> usize {
    match operation {
        Operation::Read(bytes) => bytes.len(),
        Operation::Write(bytes) => bytes.len(),
    }
}

impl<B: I2c> I2c for FaultyBus<'_, B> {
    fn transaction(&mut self, address: SevenBitAddress, operations: &mut [Operation<'_>]) -> Result<(), Self::Error> {
        self.measured(|bus| bus.do_i2c(address, operations))
    }
}

impl<B: I2c> FaultyBus<'_, B> {
    fn do_i2c(
        &mut self,
        address: SevenBitAddress,
        operations: &mut [Operation<'_>],
    ) -> Result<(), InjectedError<B::Error>> {
        let bytes = operations.iter().map(length).sum();
        let course = self.begin(bytes);
        let fault = match course {
            Course::Blocked(fault) => return Err(InjectedError::Injected(fault)),
            Course::Unanswered(_) => None,
            Course::Through(fault) => fault,
        };
        let flip = Flip::of(fault, bytes);
        self.pass_on_i2c(address, operations, flip)?;
        let (mut offset, mut already_read) = (0, 0);
        for operation in operations.iter_mut() {
            let here = length(operation);
            if let Operation::Read(bytes) = operation {
                spoil(bytes, offset, already_read, fault, flip);
                already_read += bytes.len();
            }
            offset += here;
        }
        if let Course::Unanswered(fault) = course { Err(InjectedError::Injected(fault)) } else { Ok(()) }
    }

    /// Does the transaction on the wrapped bus, with the flipped bit if it is in a written byte.
    fn pass_on_i2c(
        &mut self,
        address: SevenBitAddress,
        operations: &mut [Operation<'_>],
        flip: Option<Flip>,
    ) -> Result<(), InjectedError<B::Error>> {
        let mut changed = [0_u8];
        let mut offset = 0;
        for operation in operations.iter() {
            if let Operation::Write(bytes) = operation
                && let Some(flip) = flip
                && let Some(byte) = flip.within(offset, bytes.len()).and_then(|place| bytes.get(place))
            {
                changed = [byte ^ flip.mask];
            }
            offset += length(operation);
        }
        let mut passed: Vec<Operation<'_>, OPERATIONS> = Vec::new();
        let mut offset = 0;
        for operation in operations.iter_mut() {
            let here = length(operation);
            let place = flip.and_then(|flip| flip.within(offset, here));
            offset += here;
            let mut push = |operation| passed.push(operation).map_err(|_| InjectedError::TooManyOperations);
            match (operation, place) {
                (Operation::Write(bytes), Some(place)) => {
                    let (before, rest) = bytes.split_at_checked(place).unwrap_or((bytes, &[]));
                    push(Operation::Write(before))?;
                    push(Operation::Write(&changed))?;
                    push(Operation::Write(rest.get(1..).unwrap_or(&[])))?;
                }
                (Operation::Write(bytes), None) => push(Operation::Write(bytes))?,
                (Operation::Read(bytes), _) => push(Operation::Read(bytes))?,
            }
        }
        self.inner.transaction(address, &mut passed).map_err(InjectedError::Bus)
    }
}
