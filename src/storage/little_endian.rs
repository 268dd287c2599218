//! Fixed little-endian fields: the layout of a record does not depend on a compiler, a crate or the order of an enum.

/// Writer of fields, one after another; a field without room is left out and remembered.
pub(super) struct Writer<'a> {
    bytes: &'a mut [u8],
    at: usize,
    overflowed: bool,
}

impl<'a> Writer<'a> {
    pub const fn new(bytes: &'a mut [u8]) -> Self {
        Self { bytes, at: 0, overflowed: false }
    }

    #[inline(never)]
    pub fn bytes(&mut self, field: &[u8]) {
        let end = self.at.saturating_add(field.len());
        match self.bytes.get_mut(self.at..end) {
            Some(room) => {
                // Not `copy_from_slice`: its panic would be linked.
                room.iter_mut().zip(field).for_each(|(room, byte)| *room = *byte);
                self.at = end;
            }
            None => self.overflowed = true,
        }
    }

    pub fn u8(&mut self, x: u8) {
        self.bytes(&[x]);
    }

    pub fn u16(&mut self, x: u16) {
        self.bytes(&x.to_le_bytes());
    }

    pub fn u32(&mut self, x: u32) {
        self.bytes(&x.to_le_bytes());
    }

    pub fn u64(&mut self, x: u64) {
        self.bytes(&x.to_le_bytes());
    }

    #[inline(never)]
    pub fn f32s(&mut self, fields: &[f32]) {
        fields.iter().for_each(|x| self.u32(x.to_bits()));
    }

    /// A missing number is a NaN.
    pub fn optional(&mut self, x: Option<f32>) {
        self.f32s(&[x.unwrap_or(f32::NAN)]);
    }

    /// Returns the number of bytes written; `None` if they did not fit.
    pub fn finish(self) -> Option<usize> {
        (!self.overflowed).then_some(self.at)
    }
}

/// Reader of fields, one after another; `None` at the end of the bytes.
pub(super) struct Reader<'a>(pub &'a [u8]);

impl Reader<'_> {
    pub fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (field, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*field)
    }

    pub fn u8(&mut self) -> Option<u8> {
        self.bytes::<1>().map(|[x]| x)
    }

    pub fn u16(&mut self) -> Option<u16> {
        self.bytes().map(u16::from_le_bytes)
    }

    #[inline(never)]
    pub fn u32(&mut self) -> Option<u32> {
        self.bytes().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Option<u64> {
        self.bytes().map(u64::from_le_bytes)
    }

    pub fn f32(&mut self) -> Option<f32> {
        self.u32().map(f32::from_bits)
    }

    pub fn f32s<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut fields = [0.0; N];
        for x in &mut fields {
            *x = self.f32()?;
        }
        Some(fields)
    }

    /// A missing number is a NaN.
    pub fn optional(&mut self) -> Option<Option<f32>> {
        self.f32().map(|x| (!x.is_nan()).then_some(x))
    }
}
