//! Memory of a running program, as Linux counts it.

use std::fs;

/// Largest memory of a process so far, KiB, as long as it runs; `None` on other systems.
#[must_use]
pub fn largest_kib(pid: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()
}
