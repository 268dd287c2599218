//! Account of what an import understood and found, in words.

use std::io::{self, Write};

use super::{
    gate::{Finding, Verdict},
    merged::Merged,
    resolve::{Resolved, name},
    series::Series,
    units::Quantity,
};

/// Writes the map, a line a sensor, and the findings, a line each with the fix below.
///
/// # Errors
/// When it cannot be written.
pub fn write(
    out: &mut impl Write,
    parts: &[Resolved],
    all: &[Series],
    merged: &Merged,
    findings: &[Finding],
) -> io::Result<()> {
    for (part, series) in parts.iter().zip(all) {
        let map = &part.part;
        let columns = map.columns.as_deref().unwrap_or_default().join(", ");
        let table = map.table.as_deref().unwrap_or_default();
        writeln!(out, "{:12} {table}: {columns}", name(part.quantity))?;
        if part.quantity != Quantity::Reference {
            writeln!(out, "{:12} in {}, {}", "", map.unit.as_deref().unwrap_or_default(), part.unit_why)?;
        }
        let time = match (&map.time, map.rate_hz) {
            (_, Some(rate)) => format!("{rate} Hz"),
            (time, None) => {
                format!("{} in {}", time.as_deref().unwrap_or_default(), map.time_unit.as_deref().unwrap_or_default())
            }
        };
        let how = merged.how.iter().find(|(quantity, _)| *quantity == part.quantity).map(|(_, how)| how.told());
        let how = how.map_or_else(String::new, |how| format!("; {how}"));
        writeln!(
            out,
            "{:12} time {time}, {}; {:.2} Hz, {} readings{how}",
            "",
            part.time_why,
            series.rate_hz(),
            series.t_us.len()
        )?;
    }
    for note in &merged.notes {
        writeln!(out, "note: {note}")?;
    }
    for finding in findings {
        let mark = match finding.verdict {
            Verdict::Fine => "ok   ",
            Verdict::Note => "note ",
            Verdict::Wrong => "WRONG",
        };
        writeln!(out, "{mark} {}", finding.told)?;
        if let Some(fix) = &finding.fix {
            writeln!(out, "      likely fix: {fix}")?;
        }
    }
    Ok(())
}
