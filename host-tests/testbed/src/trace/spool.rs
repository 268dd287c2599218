//! Rows of fixed size in a temporary file: what is as long as a recording, and is read from its start to its end,
//! takes no memory. Up to a megabyte stays in memory, so that a short recording makes no file.

use std::{
    io::{self, Read, Seek, SeekFrom, Write},
    marker::PhantomData,
    sync::{Arc, Mutex, PoisonError},
};

use tempfile::SpooledTempFile;

/// Bytes that stay in memory before there is a file.
const IN_MEMORY: usize = 1 << 20;

/// Rows that are written and read together.
const AT_ONCE: usize = 1_024;

/// A value that takes the same number of bytes whatever it is.
pub trait Fixed: Copy {
    /// Number of bytes.
    const SIZE: usize;

    /// Appends the bytes.
    fn put(&self, bytes: &mut Vec<u8>);

    /// Reads them again.
    fn take(bytes: &mut Bytes) -> Self;
}

/// Bytes of rows, read from the first on.
pub struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    /// The next `N` bytes; zeros behind the end.
    #[must_use]
    pub fn take_bytes<const N: usize>(&mut self) -> [u8; N] {
        let (next, rest) = self.0.split_first_chunk().map_or(([0; N], &[][..]), |(next, rest)| (*next, rest));
        self.0 = rest;
        next
    }

    /// The next value of 32 bits.
    #[must_use]
    pub fn number(&mut self) -> f32 {
        f32::from_le_bytes(self.take_bytes())
    }

    /// The next values of 32 bits.
    #[must_use]
    pub fn numbers<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| self.number())
    }
}

/// Appends values of 32 bits.
pub fn put_numbers(bytes: &mut Vec<u8>, numbers: &[f32]) {
    numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
}

/// Rows in a temporary file, which is gone when the last owner of it is. Written once, then read any number of times.
#[derive(Clone, Debug)]
pub struct Spool<T> {
    shared: Arc<Mutex<Shared>>,
    unwritten: Vec<u8>,
    len: usize,
    of: PhantomData<T>,
}

#[derive(Debug)]
struct Shared {
    file: SpooledTempFile,
    /// First error of the file.
    failed: Option<(io::ErrorKind, String)>,
}

impl Shared {
    fn note<R>(&mut self, result: io::Result<R>) -> Option<R> {
        result.map_err(|error| self.failed.get_or_insert_with(|| (error.kind(), error.to_string()))).ok()
    }
}

impl<T> Default for Spool<T> {
    fn default() -> Self {
        let shared = Shared { file: SpooledTempFile::new(IN_MEMORY), failed: None };
        Self { shared: Arc::new(Mutex::new(shared)), unwritten: Vec::new(), len: 0, of: PhantomData }
    }
}

impl<T> PartialEq for Spool<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.shared, &other.shared)
    }
}

impl<T: Fixed> Spool<T> {
    /// Appends a row. An error of the file is kept for [`Spool::checked`].
    pub fn push(&mut self, row: &T) {
        row.put(&mut self.unwritten);
        self.len += 1;
        if self.unwritten.len() >= AT_ONCE * T::SIZE {
            self.flush();
        }
    }

    /// Writes what [`Spool::push`] has kept back; needed before the rows are read.
    pub fn flush(&mut self) {
        let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        let written = shared.file.write_all(&self.unwritten);
        shared.note(written);
        self.unwritten.clear();
    }

    /// Number of rows.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Returns true if there is no row.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The rows from the first on. They end early where the file cannot be read; [`Spool::checked`] tells.
    #[must_use]
    pub fn iter(&self) -> Rows<'_, T> {
        Rows { spool: self, bytes: Vec::new(), at: 0, read: 0 }
    }

    /// The first error that the file had.
    ///
    /// # Errors
    /// The file could not be written or read.
    pub fn checked(&self) -> io::Result<()> {
        let shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        shared.failed.clone().map_or(Ok(()), |(kind, why)| {
            Err(io::Error::new(kind, format!("the temporary file of a long recording: {why}")))
        })
    }
}

/// Rows of a [`Spool`].
pub struct Rows<'a, T> {
    spool: &'a Spool<T>,
    bytes: Vec<u8>,
    at: usize,
    /// Rows that were read of the file.
    read: usize,
}

impl<T: Fixed> Rows<'_, T> {
    fn read_on(&mut self) -> Option<()> {
        let count = (self.spool.len - self.read).min(AT_ONCE);
        if count == 0 {
            return None;
        }
        self.bytes.resize(count * T::SIZE, 0);
        let mut shared = self.spool.shared.lock().unwrap_or_else(PoisonError::into_inner);
        let place = SeekFrom::Start((self.read * T::SIZE) as u64);
        let read = shared.file.seek(place).and_then(|_| shared.file.read_exact(&mut self.bytes));
        shared.note(read)?;
        (self.at, self.read) = (0, self.read + count);
        Some(())
    }
}

impl<T: Fixed> Iterator for Rows<'_, T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        if self.at >= self.bytes.len() {
            self.read_on()?;
        }
        let row = self.bytes.get(self.at..self.at + T::SIZE)?;
        self.at += T::SIZE;
        Some(T::take(&mut Bytes(row)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Number(u64);

    impl Fixed for Number {
        const SIZE: usize = 8;

        fn put(&self, bytes: &mut Vec<u8>) {
            bytes.extend(self.0.to_le_bytes());
        }

        fn take(bytes: &mut Bytes) -> Self {
            Self(u64::from_le_bytes(bytes.take_bytes()))
        }
    }

    #[test]
    fn rows_come_back_from_memory_and_from_a_file_to_several_readers_at_once() {
        for count in [0, 1, AT_ONCE as u64, 700_001] {
            let mut spool = Spool::default();
            (0..count).for_each(|k| spool.push(&Number(k * k)));
            spool.flush();
            assert_eq!(spool.len() as u64, count);
            let both = spool.iter().zip(spool.iter().skip(1));
            assert!(both.enumerate().all(|(k, (a, b))| a == Number((k * k) as u64) && b.0 == a.0 + 2 * k as u64 + 1));
            assert_eq!(spool.iter().count() as u64, count);
            spool.checked().unwrap();
        }
    }
}
