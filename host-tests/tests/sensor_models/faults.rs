//! Injected faults act as stated, at their transaction and for their time, and at no other time.

use super::{Random, wire::*};
use embedded_hal::{
    i2c::{self, Error as _, I2c},
    spi::{self, SpiDevice},
};
use meerkat_mwd::{
    Sample,
    emulation::{
        BusFault, Conversions, FaultyBus, Injection, Ism330dhcx, OnI2c, OnSpi, PartFault, Rm3100, Schedule, ism330dhcx,
    },
};
use std::cell::{Cell, RefCell};

fn at(at_transaction: u32, lasting_us: u64) -> impl Fn(PartFault) -> Injection<PartFault> {
    move |fault| Injection { fault, at_transaction, lasting_us }
}

/// A part that converts with every sample, with both its sensors in the output registers and in the FIFO.
fn running() -> Wired<Ism330dhcx> {
    let wired = Wired::ism330dhcx(Conversions::WithEverySample);
    wired.write(0x09, &[0x66, 0x06]);
    wired.write(0x10, &[0x60, 0x60]);
    wired
}

fn play(wired: &Wired<Ism330dhcx>, k: u64, random: &mut Random) {
    let (gyro_rad_s, accel_m_s2) = (random.vector(3.0), random.vector(9.0));
    wired.play(&Sample { t_us: k * 1_000, gyro_rad_s, accel_m_s2, ..Sample::default() });
}

#[test]
fn a_wrong_identification_lasts_its_time() {
    let wired = Wired::ism330dhcx(Conversions::AtItsRate);
    wired.part.borrow_mut().inject(at(1, 1_000)(PartFault::WrongIdentification));
    assert_eq!(wired.byte(0x0F), 0x6B);
    assert_ne!(wired.byte(0x0F), 0x6B);
    wired.now_us.set(1_000);
    assert_eq!(wired.byte(0x0F), 0x6B);
}

#[test]
fn a_silent_reset_takes_the_settings_and_answers_on() {
    let mut random = Random::new(1);
    let wired = running();
    play(&wired, 1, &mut random);
    wired.part.borrow_mut().inject(at(0, 0)(PartFault::SilentReset));
    assert_eq!(wired.byte(0x0F), 0x6B);
    assert_eq!(wired.read::<2>(0x10), [0, 0]);
    assert_eq!(wired.read::<2>(0x3A), [0, 0]);
    play(&wired, 2, &mut random);
    assert_eq!(wired.byte(0x1E), 0, "nothing converts");
}

#[test]
fn a_frozen_output_goes_on_and_never_changes_and_a_dead_axis_reads_zero() {
    let mut random = Random::new(2);
    let wired = running();
    play(&wired, 1, &mut random);
    let before = wired.read::<12>(0x22);
    wired.part.borrow_mut().inject(at(0, 4_000)(PartFault::FrozenOutput));
    for k in 2..=8 {
        wired.byte(0x0F);
        play(&wired, k, &mut random);
        let now = wired.read::<12>(0x22);
        assert_eq!(now == before, k < 5, "{k}");
    }
    wired.part.borrow_mut().inject(at(0, 100_000)(PartFault::DeadAxis(4)));
    wired.byte(0x0F);
    play(&wired, 9, &mut random);
    let now = wired.read::<12>(0x22);
    assert_eq!(words(&now[6..])[1], 0);
    assert!(words(&now).iter().chain([&words(&now[6..])[0], &words(&now[6..])[2]]).all(|word| *word != 0));
}

#[test]
fn data_ready_sticks_either_way() {
    let mut random = Random::new(3);
    for (fault, level) in [(PartFault::DataReadyStuckHigh, true), (PartFault::DataReadyStuckLow, false)] {
        let wired = running();
        wired.write(0x0D, &[0b11]);
        if !level {
            play(&wired, 1, &mut random);
        }
        wired.part.borrow_mut().inject(at(0, 10_000)(fault));
        assert_eq!(wired.byte(0x1E) != 0, level);
        assert_eq!(wired.part.borrow().interrupt(), level);
        assert_eq!(wired.byte(0x3A) != 0, level);

        let compass = Wired::rm3100(Conversions::WithEverySample);
        compass.write(0x01, &[0x79]);
        compass.part.borrow_mut().inject(at(0, 10_000)(fault));
        assert_eq!(compass.byte(0x34) & 0x80 != 0, level);
    }
}

#[test]
fn an_overrun_loses_the_oldest_words_and_says_so() {
    let mut random = Random::new(4);
    let wired = running();
    (1..=4).for_each(|k| play(&wired, k, &mut random));
    let newest = wired.read::<12>(0x22);
    wired.part.borrow_mut().inject(at(0, 0)(PartFault::FifoOverrun));
    let [count, status] = wired.read::<2>(0x3A);
    assert_eq!((count, status & 0b100_1000), (4, 0b100_1000));
    let left = wired.read::<28>(0x78);
    assert_eq!(left[15..21], newest[..6]);
    assert_eq!(left[22..28], newest[6..]);
}

/// A bus whose part answers with a running number.
struct Counting(u8);

impl spi::ErrorType for Counting {
    type Error = spi::ErrorKind;
}

impl SpiDevice for Counting {
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), spi::ErrorKind> {
        for operation in operations {
            match operation {
                spi::Operation::Write(bytes) => self.0 = bytes.iter().fold(self.0, |sum, byte| sum.wrapping_add(*byte)),
                spi::Operation::Read(bytes) => bytes.fill(self.0),
                _ => {}
            }
        }
        Ok(())
    }
}

fn faulty<'a>(
    fault: BusFault,
    now_us: &'a Cell<u64>,
    schedule: &'a Cell<Schedule<BusFault>>,
) -> FaultyBus<'a, Counting> {
    schedule.set(Schedule::of(Injection { fault, at_transaction: 1, lasting_us: 20_000 }));
    FaultyBus::new(Counting(0), now_us, schedule)
}

#[test]
fn every_bit_of_a_transaction_can_be_flipped_on_the_way_there_and_back() {
    let now_us = Cell::new(0);
    let schedule = Cell::new(Schedule::none());
    for bit in 0..40_u16 {
        schedule.set(Schedule::of(Injection { fault: BusFault::BitFlip { bit }, at_transaction: 1, lasting_us: 0 }));
        let mut bus = FaultyBus::new(Counting(0), &now_us, &schedule);
        let mut exchange = || {
            let mut read = [0; 3];
            bus.transaction(&mut [spi::Operation::Write(&[0x00, 0x00]), spi::Operation::Read(&mut read)]).unwrap();
            read
        };
        assert_eq!(exchange(), [0; 3]);
        let flipped = 0x80 >> (bit % 8);
        let expected = match bit / 8 {
            0 | 1 => [flipped; 3],
            byte => [2, 3, 4].map(|place| if place == byte { flipped } else { 0 }),
        };
        assert_eq!(exchange(), expected, "bit {bit}");
        // The part keeps what it took wrongly; the bus is sound again.
        assert_eq!(exchange(), if bit < 16 { [flipped; 3] } else { [0; 3] });
    }
}

#[test]
fn a_locked_bus_passes_nothing_until_it_is_released_and_a_time_out_takes_time() {
    let (now_us, schedule) = (Cell::new(0), Cell::new(Schedule::none()));
    let mut bus = faulty(BusFault::Locked, &now_us, &schedule);
    bus.write(&[1]).unwrap();
    now_us.set(500);
    assert!(bus.write(&[1]).is_err());
    now_us.set(20_499);
    assert!(bus.write(&[1]).is_err());
    now_us.set(20_500);
    bus.write(&[1]).unwrap();
    assert_eq!(schedule.get().transactions(), 4);
    assert_eq!(schedule.get().struck_at_us(), Some(500));

    now_us.set(0);
    let mut bus = faulty(BusFault::TimeOut, &now_us, &schedule);
    bus.write(&[1]).unwrap();
    assert!(bus.write(&[1]).is_err());
    assert_eq!(now_us.get(), 20_000);
    let mut read = [0];
    bus.read(&mut read).unwrap();
    assert_eq!(read, [2], "the part had done what it was asked");
}

#[test]
fn a_short_read_is_the_idle_line_from_there_on() {
    let (now_us, schedule) = (Cell::new(0), Cell::new(Schedule::none()));
    let mut bus = faulty(BusFault::ShortRead { whole: 2 }, &now_us, &schedule);
    bus.write(&[1]).unwrap();
    let mut read = [7; 5];
    bus.read(&mut read).unwrap();
    assert_eq!(read, [1, 1, 0xFF, 0xFF, 0xFF]);
}

#[test]
fn i2c_has_its_own_errors() {
    let part = RefCell::new(Ism330dhcx::<8>::new(Conversions::AtItsRate));
    let now_us = Cell::new(0);
    let kind = |fault| {
        let schedule = Cell::new(Schedule::of(Injection { fault, at_transaction: 0, lasting_us: 0 }));
        let bus = OnI2c::new(&part, &now_us, ism330dhcx::I2C_ADDRESS);
        let mut read = [0];
        let mut bus = FaultyBus::new(bus, &now_us, &schedule);
        let kind = bus.write_read(ism330dhcx::I2C_ADDRESS, &[0x0F], &mut read).unwrap_err().kind();
        bus.write_read(ism330dhcx::I2C_ADDRESS, &[0x0F], &mut read).unwrap();
        assert_eq!(read, [0x6B]);
        kind
    };
    assert_eq!(kind(BusFault::Nack), i2c::ErrorKind::NoAcknowledge(i2c::NoAcknowledgeSource::Unknown));
    assert_eq!(kind(BusFault::ArbitrationLoss), i2c::ErrorKind::ArbitrationLoss);
    assert_eq!(kind(BusFault::Locked), i2c::ErrorKind::Bus);
    let mut bus = OnI2c::new(&part, &now_us, 0x6B);
    assert!(bus.write(0x20, &[0]).is_err(), "nobody is there");
}

/// The wrapper does not change a sound transaction.
#[test]
fn a_bus_without_a_fault_is_as_it_was() {
    let part = RefCell::new(Rm3100::new(Conversions::AtItsRate));
    let (now_us, schedule) = (Cell::new(0), Cell::new(Schedule::none()));
    let mut bus = FaultyBus::new(OnSpi::new(&part, &now_us), &now_us, &schedule);
    bus.write(&[0x04, 1, 2, 3, 4, 5, 6]).unwrap();
    let mut read = [0; 7];
    bus.transaction(&mut [spi::Operation::Transfer(&mut read, &[0x84])]).unwrap();
    assert_eq!(read, [0, 1, 2, 3, 4, 5, 6]);
    assert_eq!(schedule.get().transactions(), 2);
}
