//! Bus load of a sample: what the drivers move, at each part's greatest clock.

mod wire;

use meerkat_mwd::sensors::{
    InertialReading, Lsm6dsv320xRange, MagneticReading, Mounting, PartData, Rm3100Settings, Trigger,
    blocking::{
        Bmi088, Icm42688, Iis2mdc, InertialSource, Ism330dhcx, Lsm6dsv320x, MagneticSource, Part, Rm3100, Supervised,
    },
};

use testbed::study::{Cell, Effort, Table};
use wire::Wire;

/// Sample period of the measurement, microseconds (200 Hz).
const SAMPLE_US: u64 = 5_000;
/// Number of samples: twenty seconds, in which every thermometer is read some times.
const SAMPLES: u64 = 4_000;
/// Samples at the start that are left out: starting and settling are not the sampling path.
const SETTLED: u64 = 200;

const MHZ: f64 = 1e6;

/// Runs once: bytes are counted, not measured.
pub fn run(_: Effort) -> anyhow::Result<Vec<Table>> {
    let mut table = Table::new(
        "Bus per sample at 200 Hz: the parts polled every 5 ms for 20 s, settings read back with every burst; gaps between bytes and transactions are the board's",
        &["", "bus and its clock", "readings a second", "transactions", "bytes", "us", "% of the sample period"],
    );
    let (wire, other) = (Wire::new(0x36, 0x22, wire::rm3100), Wire::new(0x0F, 0x6B, wire::ism330dhcx));
    let pair = of_magnetic("SPI", MHZ, &wire, Rm3100::new_spi(wire.clone(), Rm3100Settings::default()), &mut table)
        + of_inertial("SPI", 10.0 * MHZ, &[&other], Ism330dhcx::new_spi(other.clone(), 1), &mut table);
    table.row([
        Cell::from("both"),
        Cell::default(),
        Cell::default(),
        Cell::default(),
        Cell::default(),
        Cell::number(pair, 1),
        Cell::percent(pair / SAMPLE_US as f64, 2),
    ]);
    let wire = Wire::new(0x36, 0x22, wire::rm3100);
    of_magnetic("I2C", 0.4 * MHZ, &wire, Rm3100::new_i2c(wire.clone(), 0x20, Rm3100Settings::default()), &mut table);
    let wire = Wire::new(0x4F, 0x40, wire::iis2mdc);
    of_magnetic("I2C", 0.4 * MHZ, &wire, Iis2mdc::new_i2c(wire.clone()), &mut table);
    for (range, respond) in [
        (Lsm6dsv320xRange::G16, wire::lsm6dsv320x as wire::Respond),
        (Lsm6dsv320xRange::G320, wire::lsm6dsv320x_high_g),
    ] {
        let wire = Wire::new(0x0F, 0x73, respond);
        of_inertial("SPI", 10.0 * MHZ, &[&wire], Lsm6dsv320x::new_spi(wire.clone(), range, 1), &mut table);
    }
    let wire = Wire::new(0x75, 0x47, wire::icm42688);
    of_inertial("SPI", 24.0 * MHZ, &[&wire], Icm42688::new(wire.clone()), &mut table);
    let (accel, gyro) = (Wire::new(0x00, 0x1E, wire::bmi088_accel), Wire::new(0x00, 0x0F, wire::bmi088_gyro));
    of_inertial("SPI", 10.0 * MHZ, &[&accel, &gyro], Bmi088::new(accel.clone(), gyro.clone()), &mut table);
    Ok(vec![table])
}

fn of_inertial<P: Part<2>>(bus: &str, clock_hz: f64, wires: &[&Wire], part: P, table: &mut Table) -> f64 {
    let data = part.data();
    let mut source = Supervised::<P, 2>::new(part, Mounting::ALIGNED);
    measure(&data, bus, clock_hz, wires, table, |now_us| {
        let mut out = heapless::Vec::<InertialReading, 32>::new();
        let _ = source.read(now_us, Trigger::Polled, &mut out);
        out.len()
    })
}

fn of_magnetic<P: Part<1>>(bus: &str, clock_hz: f64, wire: &Wire, part: P, table: &mut Table) -> f64 {
    let data = part.data();
    let mut source = Supervised::<P, 1>::new(part, Mounting::ALIGNED);
    measure(&data, bus, clock_hz, &[wire], table, |now_us| {
        let mut out = heapless::Vec::<MagneticReading, 32>::new();
        let _ = source.read(now_us, Trigger::Polled, &mut out);
        out.len()
    })
}

/// Adds the row of a part; returns the time for which it keeps the bus busy per sample, microseconds.
fn measure<const V: usize>(
    data: &PartData<V>,
    bus: &str,
    clock_hz: f64,
    wires: &[&Wire],
    table: &mut Table,
    mut read: impl FnMut(u64) -> usize,
) -> f64 {
    let (mut readings, mut next_us) = (0, 0);
    let mut before = (0, 0, 0);
    let moved = || {
        let of = |count: fn(&Wire) -> u64| wires.iter().map(|wire| count(wire)).sum::<u64>();
        (of(Wire::bits), of(Wire::bytes), of(Wire::transactions))
    };
    for k in 0..SAMPLES + SETTLED {
        let now_us = k * SAMPLE_US;
        while next_us <= now_us {
            wires.iter().for_each(|wire| wire.measure());
            next_us += u64::from(data.period_us);
        }
        if k == SETTLED {
            (before, readings) = (moved(), 0);
        }
        readings += read(now_us);
    }
    let after = moved();
    let per_sample = |after: u64, before: u64| (after - before) as f64 / SAMPLES as f64;
    let busy_us = MHZ * per_sample(after.0, before.0) / clock_hz;
    table.row([
        Cell::from(data.name),
        Cell::from(format!("{bus}, {} MHz", clock_hz / MHZ)),
        Cell::number(readings as f64 * MHZ / (SAMPLES * SAMPLE_US) as f64, 0),
        Cell::number(per_sample(after.2, before.2), 2),
        Cell::number(per_sample(after.1, before.1), 1),
        Cell::number(busy_us, 1),
        Cell::percent(busy_us / SAMPLE_US as f64, 2),
    ]);
    busy_us
}
