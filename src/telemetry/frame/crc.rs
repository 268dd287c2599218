//! Check of a frame. Records in flash have the same polynomial (`storage/record.rs`).

use crc::{CRC_32_ISCSI, Crc, Digest, NoTable};

/// CRC-32C, Castagnoli's polynomial as in iSCSI (RFC 3720 section 12.1): Hamming distance 6 up to 5,243 bits, where the
/// CRC of Ethernet has 4 beyond 2,974 bits (P. Koopman, DSN 2002). Bit by bit: a table would take 1 KiB of flash.
static CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// Returns an empty check, to which bytes are then added.
pub(super) fn digest() -> Digest<'static, u32, NoTable> {
    CRC.digest()
}
