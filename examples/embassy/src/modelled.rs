//! Stand-ins for a board's sensors: register models of an ISM330DHCX and an RM3100, each on a bus that takes its
//! time.

use crate::Clock;
use core::cell::{Cell, RefCell};
use embassy_futures::yield_now;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice as Blocking};
use embedded_hal_async::spi::SpiDevice;
use meerkat_mwd::{
    Sample,
    emulation::{Conversions, Ism330dhcx, OnSpi, Rm3100},
    sensors::{
        Mounting, Rm3100Settings,
        asynchronous::{
            InertialSource, Ism330dhcx as Ism330dhcxAdapter, MagneticSource, Rm3100 as Rm3100Driver, Supervised,
        },
    },
};

/// Depth of the FIFO, words.
const WORDS: usize = 16;

/// The parts, and their time.
pub struct Parts {
    inertial: RefCell<Ism330dhcx<WORDS>>,
    magnetic: RefCell<Rm3100>,
    now_us: Cell<u64>,
}

/// A bus that lets other tasks run while it works.
pub struct Waiting<B>(B);

impl<B: ErrorType> ErrorType for Waiting<B> {
    type Error = B::Error;
}

impl<B: Blocking> SpiDevice for Waiting<B> {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        yield_now().await;
        self.0.transaction(operations)
    }
}

impl Default for Parts {
    fn default() -> Self {
        Self::new()
    }
}

impl Parts {
    /// Switched on at time 0.
    #[must_use]
    pub fn new() -> Self {
        Self {
            inertial: RefCell::new(Ism330dhcx::new(Conversions::AtItsRate)),
            magnetic: RefCell::new(Rm3100::new(Conversions::AtItsRate)),
            now_us: Cell::new(0),
        }
    }

    /// Gyro and accelerometer, read over the bus.
    pub fn inertial(&self) -> impl InertialSource + '_ {
        let bus = Waiting(OnSpi::new(&self.inertial, &self.now_us));
        Supervised::new(Ism330dhcxAdapter::new_spi(bus, 1), Mounting::ALIGNED)
    }

    /// Magnetometer, read over a bus of its own.
    pub fn magnetic(&self) -> impl MagneticSource + '_ {
        let bus = Waiting(OnSpi::new(&self.magnetic, &self.now_us));
        Supervised::new(Rm3100Driver::new_spi(bus, Rm3100Settings::default()), Mounting::ALIGNED)
    }

    /// Time passes for a tool that rests at 30 deg of inclination, its highside up.
    fn pass_to(&self, t_us: u64) {
        // A little noise: a sensor that never changes counts as frozen.
        let noise = |n: u32| {
            let drawn = (t_us as u32).wrapping_mul(2_654_435_761).rotate_left(n) >> 20;
            (drawn as f32 - 2_047.5) * 4e-6
        };
        let truth = Sample {
            t_us,
            gyro_rad_s: [noise(0), -noise(5), noise(9)],
            accel_m_s2: [4.903 + noise(3), noise(11), -8.493 + noise(14)],
            mag_ut: [-40.5 + noise(1), -10.0 + noise(7), 27.7 + noise(18)],
            temperature_c: 25.0,
            ..Sample::default()
        };
        self.now_us.set(t_us);
        self.inertial.borrow_mut().play(&truth);
        self.magnetic.borrow_mut().play(&truth);
    }
}

/// A clock with which the models' time passes.
pub struct Played<'a, C> {
    /// The clock.
    pub clock: C,
    /// The models.
    pub parts: &'a Parts,
}

impl<C: Clock> Clock for Played<'_, C> {
    async fn tick(&mut self) -> u64 {
        let now_us = self.clock.tick().await;
        self.parts.pass_to(now_us);
        now_us
    }
}
