use super::*;

#[test]
fn a_model_of_the_layout_before_is_read_and_one_of_a_later_is_not() {
    let model = StoredModel {
        gyro: GyroModel { b_rad_s: [0.01, 0.02, -0.03], ..GyroModel::IDENTITY },
        sigma: core::array::from_fn(|i| 1e-3 * i as f32),
        effects: ActiveEffects::none(),
        library: 0x1234_5678,
        temperature_c: Some([20.0, 85.0]),
        t_us: 1_234_567_890_123,
        reason: StoreReason::Stable { windows: 3 },
    };
    let mut buffer = [0; 256];
    let mut writer = Writer::new(&mut buffer);
    model.encode(&mut writer);
    let length = writer.finish().unwrap();
    let payload = &buffer[..length];
    assert_eq!(StoredModel::decode(VERSION, payload), Some(model));
    // Version 1 has two more numbers, before the library's fingerprint and the number of effects.
    let mut earlier = [0; 256];
    let (head, tail) = payload.split_at(length - 5);
    earlier[..head.len()].copy_from_slice(head);
    earlier[head.len()..][..8].copy_from_slice([0.9_f32.to_le_bytes(), f32::NAN.to_le_bytes()].as_flattened());
    earlier[head.len() + 8..][..tail.len()].copy_from_slice(tail);
    assert_eq!(StoredModel::decode(1, &earlier[..length + 8]), Some(model));
    for version in [0, 1, VERSION + 1] {
        assert_eq!(StoredModel::decode(version, payload), None, "{version}");
    }
}
