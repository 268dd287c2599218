//! The gate against the same tools: what it says of axes that are right, and of one that is wrong.

use super::draw::draw;
use crate::import::plausible::units_and_axes_of;
use meerkat_mwd::{Config, Sample};
use testbed::{
    flight::configuration::of_trace,
    simulate::simulate,
    study::{Cell, Effort, Table, seeds::each_seed},
    trace::Trace,
};

/// A mistake in wiring a part, what the gate calls it, and how it reads.
struct Mistake {
    name: &'static str,
    sensor: &'static str,
    fix: &'static str,
    make: fn(&mut Sample),
}

const MISTAKES: [Mistake; 9] = [
    Mistake { name: "gyro: sign of x", sensor: "gyro", fix: "x is -x", make: |s| s.gyro_rad_s[0] *= -1.0 },
    Mistake { name: "gyro: sign of y", sensor: "gyro", fix: "y is -y", make: |s| s.gyro_rad_s[1] *= -1.0 },
    Mistake { name: "gyro: sign of z", sensor: "gyro", fix: "z is -z", make: |s| s.gyro_rad_s[2] *= -1.0 },
    Mistake { name: "gyro: x and y swapped", sensor: "gyro", fix: "x is y, y is x", make: |s| s.gyro_rad_s.swap(0, 1) },
    Mistake { name: "gyro: y and z swapped", sensor: "gyro", fix: "y is z, z is y", make: |s| s.gyro_rad_s.swap(1, 2) },
    Mistake { name: "magnetometer: sign of x", sensor: "magnetometer", fix: "x is -x", make: |s| s.mag_ut[0] *= -1.0 },
    Mistake { name: "magnetometer: sign of y", sensor: "magnetometer", fix: "y is -y", make: |s| s.mag_ut[1] *= -1.0 },
    Mistake { name: "magnetometer: sign of z", sensor: "magnetometer", fix: "z is -z", make: |s| s.mag_ut[2] *= -1.0 },
    Mistake {
        name: "accelerometer: sign of z",
        sensor: "accelerometer",
        fix: "z is -z",
        make: |s| s.accel_m_s2[2] *= -1.0,
    },
];

/// Answer of the gate to a trace.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Said {
    /// Nothing that cannot be.
    LetIn,
    /// The mistake, by its name.
    Named,
    /// Something else.
    Otherwise,
}

fn said(trace: &Trace, config: &Config, mistake: Option<&Mistake>) -> Said {
    let findings = units_and_axes_of(trace, config);
    let certain: Vec<&str> =
        findings.iter().filter(|finding| finding.is_certain()).map(|finding| finding.told.as_str()).collect();
    let is_name = |told: &&str| {
        mistake.is_some_and(|Mistake { sensor, fix, .. }| {
            told.contains(&format!("axes of the {sensor} are wrong")) && told.ends_with(&format!(" {fix}"))
        })
    };
    match certain.as_slice() {
        [] => Said::LetIn,
        told if told.iter().any(is_name) => Said::Named,
        _ => Said::Otherwise,
    }
}

pub(super) fn table(effort: Effort) -> anyhow::Result<Table> {
    let seeds = effort.seeds(300);
    let number = seeds.end - seeds.start;
    let all = each_seed(seeds.clone(), |seed| {
        let (mut trace, _) = simulate(&draw(seed).scenario, seed);
        let config = of_trace(&trace);
        let right = trace.samples.clone();
        let mut all = vec![said(&trace, &config, None)];
        for mistake in &MISTAKES {
            trace.samples.clone_from(&right);
            trace.samples.iter_mut().for_each(mistake.make);
            all.push(said(&trace, &config, Some(mistake)));
        }
        Ok(all)
    })?;
    let mut table = Table::new(
        format!("{number} tools drawn whole at the gate, as they are and with one mistake each"),
        &["mistake", "let in", "refused, and named", "refused by another name", "seeds of these"],
    );
    let names = ["none"].into_iter().chain(MISTAKES.iter().map(|mistake| mistake.name));
    for (index, name) in names.enumerate() {
        let count = |of: Said| Cell::number(all.iter().filter(|said| said[index] == of).count() as f64, 0);
        // A right trace has no name of a mistake: each is another.
        let otherwise = seeds.clone().zip(&all).filter(|(_, said)| index == 0 && said[index] == Said::Otherwise);
        let otherwise: Vec<String> = otherwise.map(|(seed, _)| seed.to_string()).collect();
        table.row([
            Cell::from(name),
            count(Said::LetIn),
            count(Said::Named),
            count(Said::Otherwise),
            Cell::from(otherwise.join(" ")),
        ]);
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn right_axes_are_let_in_and_most_turned_signs_of_the_fast_axis_are_not() {
        let mistake = MISTAKES.iter().find(|mistake| mistake.name == "gyro: sign of z").unwrap();
        let mut named = 0;
        // The last two turn at 120 rpm, with hard iron or a delay.
        let seeds = (1_200..1_210).chain([123, 559]);
        for seed in seeds.clone() {
            let (mut trace, _) = simulate(&draw(seed).scenario, seed);
            let config = of_trace(&trace);
            assert!(said(&trace, &config, None) == Said::LetIn, "{seed}");
            trace.samples.iter_mut().for_each(mistake.make);
            named += usize::from(said(&trace, &config, Some(mistake)) == Said::Named);
        }
        assert!(2 * named > seeds.count(), "{named}");
    }
}
