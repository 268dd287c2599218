use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use meerkat_mwd::sensors::{Burst, Frame, blocking::Iis2mdc};

use super::{burst, start};

#[test]
fn start_and_one_burst() {
    let read = |register: u8, values: &[u8]| Transaction::write_read(0x1E, vec![register], values.to_vec());
    let write = |bytes: &[u8]| Transaction::write(0x1E, bytes.to_vec());
    let mut bus = Mock::new(&[
        read(0x4F, &[0x40]),
        // Idle, soft reset; then compensated, 100 Hz, continuous; offset cancelled; block data update,
        // data-ready on the pin.
        write(&[0x60, 0x23]),
        write(&[0x60, 0x8C, 0x02, 0x11]),
        read(0x60, &[0x8C, 0x02, 0x11]),
        read(0x67, &[0x00, 1, 0, 2, 0, 3, 0, 0, 0]),
        read(0x60, &[0x8C, 0x02, 0x11]),
        read(0x67, &[0x0F, 0x01, 0x00, 0xFE, 0xFF, 0x34, 0x12, 0x08, 0x00]),
        read(0x60, &[0x8C, 0x02, 0x11]),
    ]);
    let mut part = Iis2mdc::new_i2c(bus.clone());
    assert_eq!(start(&mut part), [10_000]);
    assert_eq!(burst(&mut part), Burst::default());
    assert_eq!(burst(&mut part).frames(), [Frame { codes: [Some([1, -2, 0x1234])], temperature: Some(8) }]);
    bus.done();
}
