//! Texts for C: bytes that a zero ends.

use core::ffi::c_char;

/// Writes the parts of a text one behind the other, cut off where the room ends.
///
/// # Safety
/// `text` is NULL or leads to `bytes` bytes.
pub unsafe fn put(parts: [&str; 3], text: *mut c_char, bytes: usize) {
    if text.is_null() || bytes == 0 {
        return;
    }
    let room = bytes - 1;
    let mut used = 0;
    for byte in parts.iter().flat_map(|part| part.bytes()).take(room) {
        // SAFETY: below `bytes`.
        unsafe { text.add(used).write(byte as c_char) };
        used += 1;
    }
    // SAFETY: `used` is at most `bytes - 1`.
    unsafe { text.add(used).write(0) };
}

/// A name in a field of fixed size; the last byte is always a zero.
pub fn name<const N: usize>(name: &str) -> [c_char; N] {
    let mut field = [0; N];
    for (place, byte) in field.iter_mut().zip(name.bytes().take(N.saturating_sub(1))) {
        *place = byte as c_char;
    }
    field
}
