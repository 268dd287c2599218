use super::*;

const STEP_US: u64 = 5_000;

/// A burst that is sent takes seconds. Without `begin_anew` the first samples after it would be compared together with
/// the last ones before it.
#[test]
fn no_burst_reaches_across_the_samples_that_were_dropped_while_one_was_sent() {
    let mut burst = Burst::new();
    let mut taken = 0_u32;
    let mut take = |burst: &mut Burst, count: u32| {
        for _ in 0..count {
            taken += 1;
            // It shakes more and more, so that every comparison finds a worse second.
            let force = [1e-3 * taken as f32 * libm::sinf(taken as f32), 0.0, 9.8];
            burst.push(&SurveyInput {
                t_us: u64::from(taken) * STEP_US,
                raw_accel_m_s2: force,
                force_m_s2: Some(force),
                ..SurveyInput::default()
            });
        }
    };
    let sent = |burst: &mut Burst, mut while_waiting: Option<&mut dyn FnMut(&mut Burst)>| {
        burst.send();
        let mut samples = Vec::<_, BURST_SAMPLES>::new();
        while let Some(part) = burst.take_part() {
            assert_eq!(usize::from(part.first), samples.len());
            samples.extend_from_slice(&part.samples).unwrap();
            if let Some(waits) = &mut while_waiting {
                waits(burst);
            }
        }
        samples
    };
    take(&mut burst, 500);
    let before = sent(&mut burst, Some(&mut |burst| take(burst, 7)));
    assert_eq!(before.len(), BURST_SAMPLES);
    // Fewer samples than a burst has followed: the worst is the one before.
    take(&mut burst, 150);
    assert_eq!(sent(&mut burst, None), before);
    take(&mut burst, 400);
    let after = sent(&mut burst, None);
    assert!(after[0].t_us > before[0].t_us);
    assert!(after.windows(2).all(|pair| pair[1].t_us - pair[0].t_us == STEP_US), "{after:?}");
}
