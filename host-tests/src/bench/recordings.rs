//! Findings of the loop on recordings of real sensors, and their benefit: parameters and effects from the
//! first half, errors over the second.

use std::path::Path;

use anyhow::Context;
use meerkat_mwd::{Config, magnet::HardIronInterval};

use crate::diagnosis::{Diagnosed, against_reference, diagnosed, has_dense_reference};
use testbed::study::{Cell, Effort, Table, seeds::each_seed};
use testbed::{
    flight::{
        Flight,
        configuration::{freeze_at_us, of_trace},
        fly, fly_frozen,
    },
    score::{self, PerModel, Reference},
    trace::{
        Trace,
        recordings::{FOLDER, bundled, given, name},
    },
};

/// Share of a recording held out for the scores.
const HOLD_OUT: f64 = 0.5;

/// Result of one way to fly a recording.
struct Way {
    found: String,
    /// Residual of the field over a second, before and after.
    field_deg: [Option<f64>; 2],
    p_refused: bool,
    /// Rotation error over 2 s, as it is and with one delay taken out.
    rotation_deg: [PerModel; 2],
}

/// Heading error while a magnet was on the probe.
struct WithMagnet {
    from_to_s: [f64; 2],
    /// Without the loop and with it, degrees rms.
    heading_deg: [Option<f64>; 2],
}

struct Played {
    name: String,
    without: Way,
    /// Result against the reference; `None` without one that is dense.
    against: Option<Way>,
    magnets: Vec<WithMagnet>,
}

pub fn run(_: Effort) -> anyhow::Result<Vec<Table>> {
    let mut paths = bundled()?;
    paths.extend(given().context(FOLDER)?);
    let played = each_seed(0..paths.len() as u64, |index| {
        play(usize::try_from(index).ok().and_then(|index| paths.get(index)).context("a path")?)
    })?;
    Ok(vec![found(&played), rotations(&played), headings(&played)])
}

fn play(path: &Path) -> anyhow::Result<Played> {
    let mut trace = Trace::read(path)?;
    let config = of_trace(&trace);
    trace.mark_clipped(&config.full_scale);
    let freeze_us = freeze_at_us(&trace, HOLD_OUT);
    let flight = fly_frozen(&config, freeze_us, &trace.samples)?;
    let without = way(&trace, &config, &flight, &diagnosed(&trace, &config, &flight));
    let against = if has_dense_reference(&trace) {
        let (flight, diagnosed, _) = against_reference(&trace, &config, Some(freeze_us))?;
        Some(way(&trace, &config, &flight, &diagnosed))
    } else {
        None
    };
    Ok(Played { name: name(path), without, against, magnets: with_magnets(&trace, &config)? })
}

fn way(trace: &Trace, config: &Config, flight: &Flight, diagnosed: &Diagnosed) -> Way {
    let reference = score::score(trace, flight, &score::Settings::of(trace, config, flight)).unwrap_or_default();
    let field = diagnosed.residual.magnetic_deg;
    Way {
        found: in_short(diagnosed),
        field_deg: [field.before, field.after],
        p_refused: flight.reports.iter().all(|report| report.flown.p == config.gyro.p),
        rotation_deg: [reference.orientation_2s_rms_deg, reference.orientation_2s_rms_time_aligned_deg],
    }
}

/// Effects with their sizes, and magnets with their times, as text.
fn in_short(diagnosed: &Diagnosed) -> String {
    let effects = diagnosed.effects.iter().map(|found| {
        let parameters = found.effect.parameters();
        let sizes: Vec<f32> =
            parameters.iter().zip(found.report.found.parameters).map(|(of, x)| of.in_unit * x).collect();
        let unit = parameters
            .first()
            .and_then(|parameter| parameter.name.split_once('_'))
            .map_or("", |(_, unit)| unit)
            .replace('_', "/")
            .replace("ut", "uT");
        let size = sizes.iter().map(|x| f64::from(x * x)).sum::<f64>().sqrt();
        // A size exists for one direction or for a vector, not for elements of a matrix.
        match sizes.as_slice() {
            [_] | [_, _, _] => format!("{} {size:.1} {unit}", found.effect.name()),
            _ => found.effect.name().to_owned(),
        }
    });
    let magnets = diagnosed.magnets.iter().map(|magnet| {
        let [from_s, to_s] = from_to_s(magnet);
        format!("hard_iron {:.1} uT from {from_s:.1} to {to_s:.1} s", magnet.offset().norm())
    });
    let all: Vec<String> = effects.chain(magnets).collect();
    if all.is_empty() { "nothing".to_owned() } else { all.join(", ") }
}

fn from_to_s(magnet: &HardIronInterval) -> [f64; 2] {
    [magnet.from_us as f64 * 1e-6, magnet.to_us.map_or(f64::INFINITY, |to_us| to_us as f64 * 1e-6)]
}

/// Heading errors over each magnet found in the whole recording, nothing frozen.
fn with_magnets(trace: &Trace, config: &Config) -> anyhow::Result<Vec<WithMagnet>> {
    let flight = fly(config, &trace.samples, |_| {})?;
    if flight.magnets.is_empty() {
        return Ok(Vec::new());
    }
    let without = fly(&Config { effects: false, ..*config }, &trace.samples, |_| {})?;
    let one = |magnet: &HardIronInterval| {
        let there = magnet.from_us..magnet.to_us.unwrap_or(u64::MAX);
        let mut scored = trace.clone();
        for (q, sample) in scored.reference.iter_mut().zip(&trace.samples) {
            *q = q.filter(|_| there.contains(&sample.t_us));
        }
        let heading = |flight: &Flight| {
            let reference: Option<Reference> =
                score::score(&scored, flight, &score::Settings::of(trace, config, flight));
            reference.and_then(|reference| reference.attitude_rms_deg.heading)
        };
        WithMagnet { from_to_s: from_to_s(magnet), heading_deg: [heading(&without), heading(&flight)] }
    };
    Ok(flight.magnets.iter().map(one).collect())
}

fn cell(value: Option<f64>) -> Cell {
    Cell::number(value.unwrap_or(f64::NAN), 2)
}

fn found(played: &[Played]) -> Table {
    let mut table = Table::new(
        "Recordings, parameters and effects from the first half: what is found, and the field's residual over a second in the second half, \
         deg rms",
        &[
            "recording",
            "found without the reference",
            "field, before",
            "after",
            "P",
            "found against the reference",
            "field, before",
            "after",
            "P",
        ],
    );
    for played in played {
        let [before, after] = played.without.field_deg.map(cell);
        let p = |way: &Way| if way.p_refused { "refused" } else { "accepted" };
        let mut row = vec![
            played.name.as_str().into(),
            played.without.found.as_str().into(),
            before,
            after,
            p(&played.without).into(),
        ];
        if let Some(against) = &played.against {
            row.push(against.found.as_str().into());
            row.extend(against.field_deg.map(cell));
            row.push(p(against).into());
        }
        table.row(row);
    }
    table
}

fn rotations(played: &[Played]) -> Table {
    let mut table = Table::new(
        "Rotation over 2 s in the second half against the reference, deg rms: as it is, and with one delay of each recording taken out of \
         all readings alike",
        &[
            "recording",
            "the loop",
            "as it is: bias only",
            "12 parameters",
            "with effects",
            "aligned: bias only",
            "12 parameters",
            "with effects",
        ],
    );
    for played in played {
        let ways = [("without the reference", Some(&played.without)), ("against it", played.against.as_ref())];
        for (name, way) in ways {
            let Some(way) = way else { continue };
            let figures = way.rotation_deg.iter();
            let cells = figures.flat_map(|of| [of.bias_only, of.twelve_parameters, of.with_effects]).map(cell);
            table.row([played.name.as_str().into(), name.into()].into_iter().chain(cells));
        }
    }
    table
}

fn headings(played: &[Played]) -> Table {
    let mut table = Table::new(
        "Heading while a magnet that was found was on the probe, whole recordings, nothing frozen, deg rms",
        &["recording", "from, s", "to, s", "without the loop", "with it"],
    );
    for played in played {
        for magnet in &played.magnets {
            let times = magnet.from_to_s.map(|t_s| Cell::number(t_s, 1));
            let row = [played.name.as_str().into()].into_iter().chain(times);
            table.row(row.chain(magnet.heading_deg.map(cell)));
        }
    }
    table
}
