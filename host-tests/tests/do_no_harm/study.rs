//! Study of how the flown model could be fooled: tables over many simulated recordings, and over a folder of real ones.
//! Slow; run by hand.

use crate::{
    played::{Played, play},
    rig::handheld::{self, GyroError, KINDS, Kind},
};
use meerkat_mwd::config::OptimizerKind;
use std::sync::{
    Mutex,
    atomic::{AtomicUsize, Ordering},
};
use testbed::{
    simulate::known_error,
    trace::{Trace, recordings},
};

/// Runs the cases on two threads, results in order.
fn all<C: Sync, R: Send>(cases: &[C], run: impl Fn(&C) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(i) else { break };
                    let result = run(case);
                    results.lock().unwrap().push((i, result));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap();
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, r)| r).collect()
}

fn seeds() -> u64 {
    std::env::var("MWD_SEEDS").ok().and_then(|x| x.parse().ok()).unwrap_or(20)
}

fn line(label: &str, played: &Played) {
    if std::env::var_os("MWD_VERBOSE").is_none() && !(played.harmful()) {
        return;
    }
    let r = played.reports.last().unwrap();
    let s = &played.scores;
    println!(
        "  {label}: {:?} motion {:.0} decided {} nis {:.2} rest {} | raw {:.2} bias {:.2} twelve {:.2} flown {:.2}{}",
        r.decision,
        r.motion_s,
        r.directions_decided,
        r.innovation_nis,
        r.rest_s,
        s.uncompensated.unwrap(),
        s.bias_only.unwrap(),
        s.twelve_parameters.unwrap_or(f64::NAN),
        s.with_effects.unwrap(),
        if played.harmful() { " HARM" } else { "" }
    );
}

/// Counts of a group of cases.
#[derive(Default)]
struct Row {
    cases: usize,
    accepted: usize,
    harmful: usize,
    harmful_accepts: usize,
    better: usize,
    worst: f64,
    would_help: usize,
    worse_than_raw: usize,
}

impl Row {
    fn of<'a>(played: impl IntoIterator<Item = &'a Played>) -> Self {
        let mut row = Self::default();
        for p in played {
            row.cases += 1;
            row.accepted += usize::from(p.accepted());
            row.harmful += usize::from(p.harmful());
            row.harmful_accepts += usize::from(p.harmful() && p.accepted());
            row.better += usize::from(p.ratio() < 0.95);
            row.worst = row.worst.max(p.ratio());
            let would = p.scores.twelve_parameters.unwrap_or(f64::INFINITY) < 0.8 * p.scores.bias_only.unwrap();
            row.worse_than_raw += usize::from(p.scores.with_effects.unwrap() > 1.05 * p.scores.uncompensated.unwrap());
            row.would_help += usize::from(would && !p.accepted());
        }
        row
    }
    fn print(&self, label: &str) {
        println!(
            "{label:28} cases {:4} accepted {:4} better {:4} harmful {:3} (accepts {:3}) worst ratio {:5.2} missed {:4} worse than raw {:3}",
            self.cases,
            self.accepted,
            self.better,
            self.harmful,
            self.harmful_accepts,
            self.worst,
            self.would_help,
            self.worse_than_raw
        );
    }
}

#[test]
#[ignore = "a study, minutes long"]
fn simulated_by_hand() {
    for error in [GyroError::Factory, GyroError::Percent(0.01), GyroError::Percent(0.03), GyroError::Percent(0.1)] {
        let cases: Vec<(Kind, bool, u64)> = KINDS
            .iter()
            .flat_map(|&kind| (0..seeds()).flat_map(move |seed| [false, true].map(|fast| (kind, fast, seed))))
            .collect();
        let results = all(&cases, |&(kind, fast, seed)| {
            let (trace, _) =
                handheld::record(kind, fast, error, 110.0, 1000 * kind as u64 + 2 * seed + u64::from(fast));
            play(&trace, 0.5, OptimizerKind::Lm)
        });
        println!("{error:?}");
        for (case, played) in cases.iter().zip(&results) {
            if let Some(played) = played {
                line(&format!("{case:?}"), played);
            }
        }
        for kind in KINDS {
            for fast in [false, true] {
                let rows = cases
                    .iter()
                    .zip(&results)
                    .filter(|(c, _)| c.0 == kind && c.1 == fast)
                    .filter_map(|(_, p)| p.as_ref());
                Row::of(rows).print(&format!("{kind:?} {}", if fast { "fast" } else { "slow" }));
            }
        }
        Row::of(results.iter().flatten()).print("ALL");
    }
}

fn cut(trace: &Trace, from_s: f64, to_s: f64) -> Trace {
    let start = trace.first_us();
    let inside: Vec<bool> = trace
        .samples
        .iter()
        .map(|s| {
            let t = (s.t_us - start) as f64 * 1e-6;
            (from_s..to_s).contains(&t)
        })
        .collect();
    let keep = |i: &usize| inside[*i];
    let mut piece = trace.clone();
    let all: Vec<usize> = (0..trace.samples.len()).filter(keep).collect();
    piece.samples = all.iter().map(|&i| trace.samples[i]).collect();
    piece.reference = all.iter().map(|&i| trace.reference[i]).collect();
    piece.movement = trace.movement.as_ref().map(|m| all.iter().map(|&i| m[i]).collect());
    piece
}

fn decimated(trace: &Trace, factor: usize) -> Trace {
    let mut piece = trace.clone();
    let groups: Vec<usize> = (0..trace.samples.len() / factor).map(|g| g * factor).collect();
    // Means of the group, at the time of its middle sample's reference.
    piece.samples = groups
        .iter()
        .map(|&i| {
            let group = &trace.samples[i..i + factor];
            let mean = |f: &dyn Fn(&meerkat_mwd::Sample) -> [f32; 3]| {
                std::array::from_fn(|a| group.iter().map(|s| f(s)[a]).sum::<f32>() / factor as f32)
            };
            let mut sample = group[factor / 2];
            sample.gyro_rad_s = mean(&|s| s.gyro_rad_s);
            sample.accel_m_s2 = mean(&|s| s.accel_m_s2);
            sample.mag_ut = mean(&|s| s.mag_ut);
            sample
        })
        .collect();
    piece.reference = groups.iter().map(|&i| trace.reference[i + factor / 2]).collect();
    piece.movement = trace.movement.as_ref().map(|m| groups.iter().map(|&i| m[i + factor / 2]).collect());
    piece
}

/// Another choice of body axes (a proper rotation by half a turn about x).
fn reversed(trace: &Trace) -> Trace {
    let mut piece = trace.clone();
    for s in &mut piece.samples {
        for v in [&mut s.gyro_rad_s, &mut s.accel_m_s2, &mut s.mag_ut] {
            (v[1], v[2]) = (-v[1], -v[2]);
        }
    }
    for q in piece.reference.iter_mut().flatten() {
        let [w, x, y, z] = *q;
        // q (x) i
        *q = [-x, w, z, -y];
    }
    piece
}

#[test]
#[ignore = "a study, minutes long, needs recordings"]
fn pieces_of_recordings() {
    let paths = recordings::given().unwrap();
    assert!(!paths.is_empty(), "{} names a folder of recordings", recordings::FOLDER);
    let traces: Vec<Trace> = paths.iter().map(|p| Trace::read(p).unwrap()).collect();
    let mut pieces: Vec<(String, usize, Trace, f64)> = Vec::new();
    for (n, trace) in traces.iter().enumerate() {
        let name = paths[n].file_name().unwrap().to_string_lossy()[..2].to_owned();
        let length = trace.duration_s();
        for hold_out in [0.3, 0.5, 0.7] {
            pieces.push((format!("{name} whole {hold_out}"), n, trace.clone(), hold_out));
            pieces.push((format!("{name} reversed {hold_out}"), n, reversed(trace), hold_out));
            pieces.push((format!("{name} 143 Hz {hold_out}"), n, decimated(trace, 2), hold_out));
            pieces.push((format!("{name} 95 Hz {hold_out}"), n, decimated(trace, 3), hold_out));
        }
        for cut_s in [60.0, 90.0, 130.0] {
            let mut from = 0.0;
            let mut k = 0;
            while from + cut_s <= length {
                let hold_out = [0.5, 0.3, 0.7][k % 3];
                pieces.push((format!("{name} {from}+{cut_s} {hold_out}"), n, cut(trace, from, from + cut_s), hold_out));
                from += 10.0;
                k += 1;
            }
        }
        if name == "33" || name == "35" {
            pieces.push((format!("{name} magnet on 0.4"), n, cut(trace, 43.0, 98.0), 0.4));
            pieces.push((format!("{name} magnet on 0.25"), n, cut(trace, 43.0, 98.0), 0.25));
        }
    }
    println!("{} pieces", pieces.len());
    for scale in [0.0, 0.1, 0.2, 0.3, 0.5, 1.0] {
        let results = all(&pieces, |(_, n, trace, hold_out)| {
            let mut trace = trace.clone();
            if scale > 0.0 {
                let seed = 1 + *n as u64 + trace.samples.len() as u64 % 7;
                known_error::apply(&mut trace, &known_error::scaled(&known_error::draw(seed), scale));
            }
            play(&trace, *hold_out, OptimizerKind::Lm)
        });
        println!("scale {scale}");
        for (piece, played) in pieces.iter().zip(&results) {
            if let Some(played) = played {
                line(&piece.0, played);
            }
        }
        for n in 0..traces.len() {
            let rows = pieces.iter().zip(&results).filter(|(p, _)| p.1 == n).filter_map(|(_, p)| p.as_ref());
            Row::of(rows)
                .print(&paths[n].file_stem().unwrap().to_string_lossy()[..24.min(paths[n].file_stem().unwrap().len())]);
        }
        Row::of(results.iter().flatten()).print("ALL");
    }
}
