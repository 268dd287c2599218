//! Fingerprint of a configuration: names what stored numbers are relative to.

/// FNV-1a hash of words, taken by their bytes. It is to show differences, not to withstand an attack.
pub(crate) struct Fingerprint(u32);

impl Fingerprint {
    pub const fn new() -> Self {
        Self(0x811C_9DC5)
    }

    pub fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
        }
    }

    // Not inlined: the callers have many numbers, and call it when a probe is configured.
    #[inline(never)]
    pub fn numbers(&mut self, numbers: &[f32]) {
        for number in numbers {
            self.bytes(&number.to_bits().to_le_bytes());
        }
    }

    pub const fn value(&self) -> u32 {
        self.0
    }
}

#[cfg(test)]
mod tests;
