//! Flash and RAM of the firmware by module, and its stack: what has grown is told by name.

use super::{
    emulate::{Feed, fly_emulated},
    error::EmulateError,
    firmware::{Board, build_firmware},
    image::Image,
    toolchain,
};
use std::collections::BTreeMap;
use testbed::{flight::configuration::of_trace, trace::Trace};

/// Bytes under which a module or a static has no row of its own.
const LEAST: u64 = 1024;
/// Growth that is not told, of the size before, and in bytes: alignment.
const SHARE: f64 = 0.02;
const SLACK: f64 = 64.0;

/// Rows of a table: name and bytes.
pub type Sizes = BTreeMap<String, u64>;

/// Sizes of the firmware for a real STM32F405, and the stack of a flight on the emulated one.
///
/// # Errors
/// It does not build, or the flight fails.
pub fn measured(flight: &Trace) -> Result<Sizes, EmulateError> {
    let toolchain = toolchain::prepare()?;
    let firmware = build_firmware(&toolchain, Board::Stm32f405)?;
    let image = Image::parse(&firmware.elf)?;
    let (mut flash, mut ram) = (Sizes::new(), Sizes::new());
    for symbol in image.symbols() {
        let (into, name) =
            if symbol.in_flash { (&mut flash, module(symbol.name)) } else { (&mut ram, last(symbol.name)) };
        *into.entry(name).or_default() += symbol.bytes;
    }
    let mut sizes = Sizes::new();
    for (kind, all, total) in [("flash", flash, firmware.size.flash_bytes), ("RAM", ram, firmware.size.ram_bytes())] {
        let large: Sizes = all.into_iter().filter(|(_, bytes)| *bytes >= LEAST).collect();
        let rest = total.saturating_sub(large.values().sum());
        sizes.extend(large.into_iter().map(|(name, bytes)| (format!("{kind}: {name}"), bytes)));
        sizes.insert(format!("{kind}: everything else"), rest);
        sizes.insert(format!("{kind}, in all"), total);
    }
    let flown = fly_emulated(&of_trace(flight), None, &flight.samples, Feed::Direct)?;
    sizes.insert("stack, one window of drilling".to_owned(), flown.summary.stack_used_bytes.into());
    Ok(sizes)
}

/// Names of what has grown over a fiftieth, with its sizes before and now.
#[must_use]
pub fn grown(before: &Sizes, now: &Sizes) -> Vec<String> {
    let told = now.iter().filter_map(|(name, now)| {
        let before = before.get(name).copied().unwrap_or(0);
        let most = before as f64 * (1.0 + SHARE) + SLACK;
        (*now as f64 > most).then(|| format!("{name}: {before} -> {now} bytes"))
    });
    told.collect()
}

/// Crate and module of a function or constant; for the library the module alone.
fn module(mangled: &str) -> String {
    let mut path = segments(mangled);
    let (first, second) = (path.next().unwrap_or_default(), path.next().unwrap_or_default());
    // `<impl library::module::Type>::function`: the path stands inside of the first segment.
    let inside = first.split_once("meerkat_mwd..").or_else(|| mangled.split_once("11meerkat_mwd"));
    match inside {
        _ if first == "meerkat_mwd" => second.to_owned(),
        Some((_, after)) if first.starts_with("_$") => {
            after.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).next().unwrap_or_default().to_owned()
        }
        _ if first == "probe" => "board".to_owned(),
        _ if first.is_empty() || first.starts_with("_$") => "other crates".to_owned(),
        _ => first.to_owned(),
    }
}

/// The last segment of a static's path.
fn last(mangled: &str) -> String {
    let before_hash = segments(mangled).filter(|segment| !(segment.len() == 17 && segment.starts_with('h'))).last();
    before_hash.unwrap_or(mangled).to_owned()
}

/// Segments of a path as the compiler mangles it: each with its length before it.
fn segments(mangled: &str) -> impl Iterator<Item = &str> {
    let mut rest = mangled.strip_prefix("_ZN").unwrap_or_default();
    std::iter::from_fn(move || {
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (length, after) = rest.split_at_checked(digits)?;
        let (segment, next) = after.split_at_checked(length.parse().ok()?)?;
        rest = next;
        Some(segment)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_belongs_to_the_module_that_its_path_begins_with() {
        for (mangled, expected) in [
            ("_ZN11meerkat_mwd9estimator8unrolled9add_times17h9d7c60796360ba60E", "estimator"),
            (
                "_ZN74_$LT$meerkat_mwd..storage..error..Error$u20$as$u20$core..fmt..Debug$GT$3fmt17h0123456789abcdefE",
                "storage",
            ),
            ("_ZN5probe12trace_flight9configure17h0123456789abcdefE", "board"),
            ("_ZN4libm4math4sinf17h0123456789abcdefE", "libm"),
            ("__aeabi_memcpy", "other crates"),
        ] {
            assert_eq!(module(mangled), expected, "{mangled}");
        }
        assert_eq!(last("_ZN5probe9stm32f4054main5PROBE17h6f234a8966c7b84bE"), "PROBE");
    }

    #[test]
    fn what_is_new_and_what_grows_by_more_than_a_fiftieth_is_told() {
        let sizes =
            |all: &[(&str, u64)]| all.iter().map(|(name, bytes)| ((*name).to_owned(), *bytes)).collect::<Sizes>();
        let before = sizes(&[("a", 10_000), ("b", 10_000), ("c", 100), ("gone", 5_000)]);
        let now = sizes(&[("a", 10_263), ("b", 10_265), ("c", 160), ("new", 1_024)]);
        assert_eq!(grown(&before, &now), ["b: 10000 -> 10265 bytes", "new: 0 -> 1024 bytes"]);
    }
}
