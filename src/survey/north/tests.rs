use super::*;

#[test]
fn true_is_magnetic_plus_declination_and_grid_is_true_less_convergence() {
    let earth = Earth { declination_rad: Some(-4.0_f32.to_radians()), ..Earth::default() };
    let config = SurveyConfig { grid_convergence_rad: Some(1.5_f32.to_radians()), ..SurveyConfig::default() };
    for (magnetic, true_deg, grid_deg) in [(100.0, 96.0, 94.5), (2.0, 358.0, 356.5), (5.0, 1.0, 359.5_f32)] {
        let azimuth = Uncertain { value: f32::to_radians(magnetic), sigma: 0.003 };
        let norths = Norths::of(azimuth, 16.0, &earth, &config);
        let near = |x: Option<Uncertain>, deg: f32| (x.unwrap().value.to_degrees() - deg).abs() < 1e-3;
        assert!(near(norths.true_azimuth_rad, true_deg) && near(norths.grid_azimuth_rad, grid_deg), "{magnetic}");
        // 0.36 deg and 5,000 deg nT / 16,000 nT beside 0.003 rad.
        let expected = libm::hypotf(0.003, libm::hypotf(0.36, 5_000.0 / 16_000.0).to_radians());
        assert!((norths.true_azimuth_rad.unwrap().sigma / expected - 1.0).abs() < 1e-5);
    }
    let azimuth = Uncertain { value: 1.0, sigma: 0.003 };
    let unknown = Norths::of(azimuth, 16.0, &Earth::default(), &config);
    assert!(unknown.true_azimuth_rad.is_none() && unknown.grid_azimuth_rad.is_none());
}
