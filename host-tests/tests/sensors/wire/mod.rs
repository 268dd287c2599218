//! Start-up and one burst of each part, byte by byte, with addresses and bits written down from the data
//! sheets once more.

mod bmi088;
mod icm42688;
mod iis2mdc;
mod ism330dhcx;
mod lsm6dsv320x;
mod rm3100;

use embedded_hal_mock::eh1::spi::{Mock, Transaction};
use meerkat_mwd::sensors::{Burst, StartError, StartStep, blocking::Part};

/// A transaction that writes these groups of bytes, and then reads.
fn spi(written: &[&[u8]], read: &[u8]) -> Vec<Transaction<u8>> {
    let mut transactions = vec![Transaction::transaction_start()];
    transactions.extend(written.iter().map(|bytes| Transaction::write_vec(bytes.to_vec())));
    if !read.is_empty() {
        transactions.push(Transaction::read_vec(read.to_vec()));
    }
    transactions.push(Transaction::transaction_end());
    transactions
}

/// A transaction in which as many bytes come back as go out.
fn exchange(out: &[u8], back: &[u8]) -> Vec<Transaction<u8>> {
    vec![
        Transaction::transaction_start(),
        Transaction::transfer_in_place(out.to_vec(), back.to_vec()),
        Transaction::transaction_end(),
    ]
}

fn mock(transactions: &[Vec<Transaction<u8>>]) -> Mock<u8> {
    Mock::new(&transactions.concat())
}

/// Starts a part to the end; its waits, microseconds.
fn start<P: Part<V>, const V: usize>(part: &mut P) -> Vec<u32>
where
    P::Error: std::fmt::Debug,
{
    let mut waits = Vec::new();
    for step in 0..10 {
        match part.start(step).unwrap() {
            StartStep::After(us) => waits.push(us),
            StartStep::Done => return waits,
        }
    }
    panic!("the start has no end");
}

/// Starts a part that does not take a setting; the register.
fn refused<P: Part<V>, const V: usize>(part: &mut P) -> u8
where
    P::Error: std::fmt::Debug,
{
    match (0..10).find_map(|step| part.start(step).err()) {
        Some(StartError::NotTaken { register }) => register,
        other => panic!("{other:?}"),
    }
}

fn burst<P: Part<V>, const V: usize>(part: &mut P) -> Burst<V>
where
    P::Error: std::fmt::Debug,
{
    let mut burst = Burst::default();
    part.read(&mut burst).unwrap();
    assert!(part.is_configured().unwrap());
    burst
}
