use meerkat_mwd::SampleFlags;
use testbed::simulate::{Scenario, simulate};

#[test]
fn full_scales_clip_and_flag_and_steps_round() {
    let mut scenario = Scenario { duration_s: 60.0, ..Scenario::default() };
    scenario.accel.full_scale_g = Some(2.0);
    scenario.gyro.full_scale_deg_s = Some(250.0);
    scenario.mag.resolution_ut = Some(0.5);
    let (trace, _) = simulate(&scenario, 1);
    let full_scale = trace.keys.accel_full_scale_m_s2.unwrap();
    let clipped = trace.samples.iter().filter(|s| s.flags.contains(SampleFlags::ACCEL_CLIPPED)).count();
    assert!(clipped > 10);
    assert!(trace.samples.iter().any(|s| s.flags.contains(SampleFlags::GYRO_CLIPPED)));
    for sample in &trace.samples {
        let at_full_scale = sample.accel_m_s2.iter().any(|&x| f64::from(x).abs() >= full_scale);
        assert_eq!(at_full_scale, sample.flags.contains(SampleFlags::ACCEL_CLIPPED));
        assert!(sample.accel_m_s2.iter().all(|&x| f64::from(x).abs() <= full_scale));
        assert!(sample.mag_ut.iter().all(|&x| (x * 2.0).fract() == 0.0));
    }
}
