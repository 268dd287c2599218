//! Results take effect at their instants, however the work is sliced, across gaps and at a freeze.

use super::*;

const PERIOD_US: u64 = 10_000;

/// Fate of one update.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Landed {
    asked_us: u64,
    effect_us: u64,
    is_window: bool,
    /// Number of the sample that it was asked for with; `None` for an overrun.
    result: Option<u64>,
}

/// Samples every 10 ms, and beside them so many units of work an update, done in pieces of `slice` after every
/// `every`th sample.
struct Run {
    freeze_us: Option<u64>,
    /// Seconds before the freeze at which it is asked for; `None`: before the first sample.
    asked_ahead_s: Option<u64>,
    samples: u64,
    work: u64,
    slice: u64,
    every: u64,
    /// Samples that are missing.
    gap: core::ops::Range<u64>,
}

impl Run {
    fn new(freeze_s: Option<u64>) -> Self {
        let freeze_us = freeze_s.map(|s| s * 1_000_000);
        Self { freeze_us, asked_ahead_s: None, samples: 12_000, work: 50, slice: 1, every: 1, gap: 0..0 }
    }

    fn landed(&self) -> Vec<Landed, 64> {
        let mut schedule = Schedule::zero();
        schedule.configure(&Config::default());
        let freeze_us = self.freeze_us.unwrap_or(u64::MAX);
        let freezes_us = self.asked_ahead_s.map(|ahead_s| freeze_us.saturating_sub(ahead_s * 1_000_000));
        if self.freeze_us.is_some() && freezes_us.is_none() {
            schedule.freeze(freeze_us);
        }
        schedule.start(0);
        let mut landed = Vec::new();
        let (mut done, mut last_us) = (0, 0);
        for number in (0..self.samples).filter(|number| !self.gap.contains(number)) {
            let t_us = number * PERIOD_US;
            if t_us - last_us > PERIOD_US {
                schedule.gap(last_us, t_us);
            }
            last_us = t_us;
            if freezes_us == Some(t_us) {
                schedule.freeze(freeze_us);
            }
            if let Some((update, result)) = schedule.take_effect(t_us) {
                let Update { t_us: asked_us, is_window, .. } = update;
                assert!(landed.push(Landed { asked_us, effect_us: t_us, is_window, result }).is_ok());
            }
            if schedule.push(t_us).is_some() {
                done = 0;
            }
            if number % self.every == 0
                && let Some(update) = schedule.asked()
            {
                done += self.slice;
                if done >= self.work {
                    schedule.conclude(update.t_us / PERIOD_US);
                }
            }
        }
        landed
    }
}

#[test]
fn every_result_takes_effect_exactly_at_its_instant_however_the_work_is_sliced() {
    let landed = Run::new(None).landed();
    assert_eq!(landed.len(), 23, "every 5 s of two minutes, the last one still waits");
    for (number, found) in (1..).zip(&landed) {
        let asked_us = number * 5_000_000;
        let is_window = asked_us >= 50_000_000 && asked_us % 25_000_000 == 0;
        let result = Some(asked_us / PERIOD_US);
        assert_eq!(*found, Landed { asked_us, effect_us: asked_us + 1_000_000, is_window, result });
    }
    for (slice, every) in [(50, 1), (7, 3), (1_000, 20), (50, 100)] {
        assert_eq!(Run { slice, every, ..Run::new(None) }.landed(), landed, "{slice} {every}");
    }
}

#[test]
fn work_that_is_not_done_in_time_is_an_overrun_and_the_next_update_stands_by_itself() {
    // One unit a sample: 100 of them in the second of the latency.
    assert!(Run { work: 100, ..Run::new(None) }.landed().iter().all(|found| found.result.is_some()));
    let late = Run { work: 102, ..Run::new(None) }.landed();
    assert!(late.len() == 23 && late.iter().all(|found| found.result.is_none()));
    let mut schedule = Schedule::zero();
    schedule.configure(&Config::default());
    schedule.start(0);
    assert!(schedule.push(4_999_999).is_none() && schedule.push(5_000_000).is_some());
    assert!(schedule.take_effect(5_999_999).is_none() && !schedule.is_idle());
    assert!(matches!(schedule.take_effect(6_000_000), Some((_, None))));
    // A result that comes too late is dropped.
    schedule.conclude(1);
    assert!(schedule.is_idle() && schedule.take_effect(7_000_000).is_none());
    assert!(schedule.push(10_000_000).is_some());
    schedule.conclude(2);
    assert!(matches!(schedule.take_effect(11_000_000), Some((_, Some(2)))));
}

#[test]
fn nothing_takes_effect_after_a_freeze_and_the_last_window_lands_on_it() {
    for freeze_s in [30, 51, 57, 99, 100] {
        let landed = Run::new(Some(freeze_s)).landed();
        let (last, others) = landed.split_last().unwrap();
        assert_eq!((last.effect_us, last.is_window), (freeze_s * 1_000_000, true), "{freeze_s}");
        assert_eq!(last.asked_us, (freeze_s - 1) * 1_000_000);
        assert!(others.iter().all(|found| found.effect_us <= last.asked_us), "{freeze_s}");
    }
    // It is too early for any update.
    assert!(Run::new(Some(1)).landed().is_empty());
}

#[test]
fn a_freeze_may_be_asked_for_while_samples_come() {
    for freeze_s in [30, 51, 57, 99, 100] {
        let told_first = Run::new(Some(freeze_s)).landed();
        for ahead_s in [2, 3, 10, 29] {
            let told_later = Run { asked_ahead_s: Some(ahead_s), ..Run::new(Some(freeze_s)) };
            assert_eq!(told_later.landed(), told_first, "{freeze_s} {ahead_s}");
        }
        // Too late for a last window: what waits lands, and nothing is asked for any more.
        let at_once = Run { asked_ahead_s: Some(0), ..Run::new(Some(freeze_s)) }.landed();
        assert!(at_once.iter().all(|found| found.asked_us < freeze_s * 1_000_000), "{freeze_s}");
    }
}

#[test]
fn a_second_freeze_does_not_begin_anew() {
    let mut schedule = Schedule::<u64>::zero();
    schedule.configure(&Config::default());
    schedule.start(0);
    schedule.freeze(3_000_000);
    assert!(schedule.push(2_000_000).is_some());
    schedule.conclude(1);
    assert!(schedule.take_effect(3_000_000).is_some() && schedule.is_over());
    schedule.freeze(90_000_000);
    assert!(schedule.is_over() && schedule.push(60_000_000).is_none());
}

#[test]
fn a_gap_delays_a_result_by_its_length_and_no_window_ends_with_it() {
    // Half a second after the second update was asked for 20 s are missing.
    let landed = Run { gap: 1_050..3_050, ..Run::new(None) }.landed();
    let at = |number: usize| landed.get(number).copied().unwrap();
    assert_eq!((at(1).asked_us, at(1).effect_us), (10_000_000, 31_010_000));
    // An update that was due in the gap is asked for once the waiting result has landed; then the old instants hold.
    assert_eq!((at(2).asked_us, at(3).asked_us), (31_010_000, 35_000_000));
    let windows = landed.iter().filter(|found| found.is_window);
    assert!(windows.map(|found| found.asked_us).eq([50_000_000, 75_000_000, 100_000_000]));
    // After a freeze only a result that was ready before it lands, and nothing that was due in the gap.
    let frozen = Run { gap: 1_050..3_050, ..Run::new(Some(20)) }.landed();
    let last = Landed { asked_us: 10_000_000, effect_us: 30_500_000, is_window: false, result: Some(1_000) };
    assert_eq!(frozen.last(), Some(&last));
    let quick = Run { gap: 1_850..3_050, slice: 1_000, ..Run::new(Some(20)) }.landed();
    assert_eq!(quick.last().map(|found| found.asked_us), Some(15_000_000));
}
