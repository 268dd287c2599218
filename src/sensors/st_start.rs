//! Start of ST's parts.

use super::{BusOperation, bisync};
use crate::sensors::StartError;

/// Does the first step of a start of ST's parts: checks the identity (register and value), then resets
/// (register and bit).
#[bisync]
pub(super) async fn reset<B: BusOperation>(
    bus: &mut B,
    (who_am_i, identity): (u8, u8),
    (control, sw_reset): (u8, u8),
) -> Result<(), StartError<B::Error>> {
    let found = read_one(bus, who_am_i).await?;
    if found != identity {
        return Err(StartError::WrongIdentity { expected: identity, found });
    }
    bus.write_to_register(control, &[sw_reset]).await?;
    Ok(())
}

/// Reads one register.
#[bisync]
pub(super) async fn read_one<B: BusOperation>(bus: &mut B, register: u8) -> Result<u8, B::Error> {
    let mut value = [0];
    bus.read_from_register(register, &mut value).await?;
    let [value] = value;
    Ok(value)
}
