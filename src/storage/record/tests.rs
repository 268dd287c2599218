//! Records as written, and as damaged.

use super::*;

#[test]
fn a_record_is_read_as_it_was_written_and_no_flipped_bit_passes() {
    let mut record = [0; 3 * GRANULE];
    let payload: [u8; 50] = core::array::from_fn(|i| (i * 37) as u8);
    let granules = encode(&mut record, Kind::COUNTER, 7, 123_456, |w| w.bytes(&payload));
    assert_eq!(granules, Some(3));
    let header = Header::parse(&record).unwrap();
    assert_eq!((header.kind, header.version, header.number), (Kind::COUNTER, 7, 123_456));
    assert_eq!(header.payload(&record), Some(&payload[..]));
    for bit in 0..8 * (HEADER + payload.len()) {
        let mut bad = record;
        bad[bit / 8] ^= 1 << (bit % 8);
        let read = Header::parse(&bad).and_then(|header| header.payload(&bad).map(<[u8]>::len));
        assert_eq!(read, None, "bit {bit}");
    }
}

/// Step through the numbers of the next test: every number, but fewer under the interpreter Miri.
const STEP: usize = if cfg!(miri) { 1_021 } else { 1 };

/// Every magic number, every kind and version, and every length with every number of bytes there.
#[test]
fn a_header_is_one_for_its_magic_number_and_a_length_that_fits_whatever_the_rest_is() {
    let with = |magic: u16, kind: u8, version: u8, length: u16| {
        let mut bytes = [0xA5; GRANULE];
        let mut writer = Writer::new(&mut bytes[CHECK..HEADER]);
        writer.u16(magic);
        writer.u8(kind);
        writer.u8(version);
        writer.u32(u32::MAX);
        writer.u16(length);
        bytes
    };
    for magic in (0..=u16::MAX).step_by(STEP).chain([MAGIC]) {
        assert_eq!(Header::parse(&with(magic, 1, 1, 0)).is_some(), magic == MAGIC);
    }
    let bytes = || (0..=u8::MAX).step_by(STEP.min(51));
    for (kind, version) in bytes().flat_map(|kind| bytes().map(move |version| (kind, version))) {
        let header = Header::parse(&with(MAGIC, kind, version, 0)).unwrap();
        assert_eq!((header.kind, header.version, header.number), (Kind(kind), version, u32::MAX));
    }
    let record = [0xA5; MAX_RECORD + GRANULE];
    for length in (0..=u16::MAX).step_by(STEP) {
        let header = Header::parse(&with(MAGIC, 1, 1, length));
        assert_eq!(header.is_some(), HEADER + usize::from(length) <= MAX_RECORD, "{length}");
        let Some(header) = header else { continue };
        assert!(header.bytes() <= MAX_RECORD && header.bytes() - GRANULE < HEADER + usize::from(length));
        assert_eq!(usize::from(header.granules()) * GRANULE, header.bytes());
        let there = if cfg!(miri) { HEADER..=HEADER } else { 0..=record.len() };
        for there in there {
            assert_eq!(header.payload(&record[..there]), None, "its check is wrong");
        }
    }
    for there in 0..=GRANULE {
        let whole = with(MAGIC, 1, 1, 0);
        assert_eq!(Header::parse(&whole[..there]).is_some(), there >= HEADER - 2, "{there}");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut record = [0; GRANULE];
    assert_eq!(encode(&mut record, Kind::COUNTER, 0, 0, |w| w.bytes(&[0; GRANULE - HEADER])), Some(1));
    assert_eq!(encode(&mut record, Kind::COUNTER, 0, 0, |w| w.bytes(&[0; GRANULE - HEADER + 1])), None);
}
