//! MATLAB's files.

use tempfile::TempDir;

use crate::files::{flies_as_the_original, imported, mag, original};

/// A .mat with a structure of single and double arrays, one of which lies, byte by byte after MathWorks' description of
/// version 5; files that MATLAB itself wrote are in `bindings/python/tests/test_foreign.py`.
#[test]
fn a_mat_file() {
    fn element(kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }
    fn array(class: u8, dimensions: [usize; 2], name: &str, parts: &[Vec<u8>]) -> Vec<u8> {
        let dimensions: Vec<u8> = dimensions.iter().flat_map(|size| (*size as u32).to_le_bytes()).collect();
        let head = [element(6, &[class, 0, 0, 0, 0, 0, 0, 0]), element(5, &dimensions), element(1, name.as_bytes())];
        element(14, &[head.concat(), parts.concat()].concat())
    }
    let samples = &original().samples;
    let count = samples.len();
    let time: Vec<u8> = samples.iter().flat_map(|s| (s.t_us as f64 * 1e-6).to_le_bytes()).collect();
    let column_major: Vec<u8> =
        (0..3).flat_map(|axis| samples.iter().flat_map(move |s| s.gyro_rad_s[axis].to_le_bytes())).collect();
    let row_major: Vec<u8> = samples.iter().flat_map(|s| s.accel_m_s2.map(f32::to_le_bytes)).flatten().collect();
    let field: Vec<u8> = (0..3)
        .flat_map(|axis| {
            samples.iter().flat_map(move |s| mag(s, axis).map_or(f32::NAN, |_| s.mag_ut[axis]).to_le_bytes())
        })
        .collect();
    let fields = [
        array(6, [count, 1], "", &[element(9, &time)]),
        array(7, [count, 3], "", &[element(7, &column_major)]),
        array(7, [3, count], "", &[element(7, &row_major)]),
        array(7, [count, 3], "", &[element(7, &field)]),
        array(6, [1, 1], "", &[element(9, &100.0_f64.to_le_bytes())]),
    ];
    let names: Vec<u8> = ["time", "gyro", "acc", "mag", "fs"]
        .iter()
        .flat_map(|name| {
            let mut name = name.as_bytes().to_vec();
            name.resize(8, 0);
            name
        })
        .collect();
    let parts = [vec![element(5, &8_u32.to_le_bytes()), element(1, &names)], fields.to_vec()].concat();
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend(b"\x00\x01IM");
    bytes.extend(array(2, [1, 1], "imu", &parts));
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("log.mat");
    std::fs::write(&path, &bytes).unwrap();
    flies_as_the_original(&imported(std::slice::from_ref(&path)));
    // No cut and no flipped byte makes it panic.
    for cut in (0..2_000).chain((2_000..bytes.len()).step_by(4_001)) {
        std::fs::write(&path, &bytes[..cut]).unwrap();
        let _ = mwd::import::import(std::slice::from_ref(&path), &Default::default(), &[]);
    }
}
