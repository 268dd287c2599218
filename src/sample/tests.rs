use super::*;

#[test]
fn a_non_finite_axis_makes_its_sensor_missing_and_leaves_the_others() {
    let sample = Sample {
        gyro_rad_s: [1.0, f32::NAN, 0.0],
        accel_m_s2: [0.0, 0.0, 9.8],
        temperature_c: f32::INFINITY,
        ..Sample::default()
    };
    let clean = sample.sanitised();
    assert_eq!(clean.flags, SampleFlags::GYRO_MISSING | SampleFlags::TEMPERATURE_MISSING);
    assert_eq!(clean.gyro_rad_s, [0.0; 3]);
    for (celsius, missing) in [(-9_999.0, true), (-40.0, false), (200.0, false), (1e30, true)] {
        let sample = Sample { temperature_c: celsius, ..Sample::default() }.sanitised();
        assert_eq!(sample.flags.contains(SampleFlags::TEMPERATURE_MISSING), missing, "{celsius}");
    }
    let absurd = Sample { mag_ut: [0.0, -1e30, 0.0], ..clean }.sanitised();
    assert_eq!(absurd.flags, clean.flags | SampleFlags::MAG_MISSING);
    assert_eq!(clean.accel_m_s2, [0.0, 0.0, 9.8]);
    let faulty = Sample { flags: SampleFlags::FAULT, ..sample }.sanitised();
    assert!(faulty.flags.contains(SampleFlags::ACCEL_MISSING) && faulty.accel_m_s2 == [0.0; 3]);
}
