//! Fault injection around an SPI device.

use super::{Course, FaultyBus, Flip, InjectedError, OPERATIONS, spoil};
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use heapless::Vec;

impl<B: ErrorType> ErrorType for FaultyBus<'_, B> {
    type Error = InjectedError<B::Error>;
}

fn length(operation: &Operation<'_, u8>) -> usize {
    match operation {
        Operation::Read(bytes) | Operation::TransferInPlace(bytes) => bytes.len(),
        Operation::Write(bytes) => bytes.len(),
        Operation::Transfer(read, write) => read.len().max(write.len()),
        Operation::DelayNs(_) => 0,
    }
}

impl<B: SpiDevice> SpiDevice for FaultyBus<'_, B> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        self.measured(|bus| bus.do_spi(operations))
    }
}

impl<B: SpiDevice> FaultyBus<'_, B> {
    fn do_spi(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), InjectedError<B::Error>> {
        let bytes = operations.iter().map(length).sum();
        let course = self.begin(bytes);
        let fault = match course {
            Course::Blocked(fault) => return Err(InjectedError::Injected(fault)),
            Course::Unanswered(_) => None,
            Course::Through(fault) => fault,
        };
        let flip = Flip::of(fault, bytes);
        self.pass_on_spi(operations, flip)?;
        let (mut offset, mut already_read) = (0, 0);
        for operation in operations.iter_mut() {
            let here = length(operation);
            if let Operation::Read(bytes) | Operation::TransferInPlace(bytes) | Operation::Transfer(bytes, _) =
                operation
            {
                spoil(bytes, offset, already_read, fault, flip);
                already_read += bytes.len();
            }
            offset += here;
        }
        if let Course::Unanswered(fault) = course { Err(InjectedError::Injected(fault)) } else { Ok(()) }
    }

    /// Does the transaction on the wrapped device, with the flipped bit if it is in a written byte.
    fn pass_on_spi(
        &mut self,
        operations: &mut [Operation<'_, u8>],
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
        let mut passed: Vec<Operation<'_, u8>, OPERATIONS> = Vec::new();
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
                (Operation::Transfer(read, write), _) => push(Operation::Transfer(read, write))?,
                (Operation::TransferInPlace(bytes), _) => push(Operation::TransferInPlace(bytes))?,
                (Operation::DelayNs(time), _) => push(Operation::DelayNs(*time))?,
            }
        }
        self.inner.transaction(&mut passed).map_err(InjectedError::Bus)
    }
}
