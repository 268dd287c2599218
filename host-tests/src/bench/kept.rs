//! Blocks of a measurement that takes hours. Each is kept in the temporary folder when it is done, so that the same
//! program, started again, goes on where it was stopped.

use crate::batch::program;
use anyhow::Context as _;
use serde::{Serialize, de::DeserializeOwned};
use std::{
    env, fs,
    ops::Range,
    path::{Path, PathBuf},
};

/// Seeds of a block.
const BLOCK: u64 = 1_000;

/// Results of the blocks that `seeds` fall into, in their order: those that this program has kept under `name`, and
/// those that `fly` now makes and that are kept then.
///
/// # Errors
/// That of `fly`, or a result cannot be written.
pub fn each_block<T: Serialize + DeserializeOwned>(
    name: &str,
    seeds: Range<u64>,
    fly: impl FnMut(Range<u64>) -> anyhow::Result<T>,
) -> anyhow::Result<Vec<T>> {
    let digits: String = program().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    each_block_in(&env::temp_dir().join(format!("mwd-{name}-{digits}")), seeds, fly)
}

fn each_block_in<T: Serialize + DeserializeOwned>(
    folder: &Path,
    seeds: Range<u64>,
    mut fly: impl FnMut(Range<u64>) -> anyhow::Result<T>,
) -> anyhow::Result<Vec<T>> {
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let starts = (seeds.start..seeds.end).step_by(BLOCK as usize);
    starts
        .map(|start| {
            let block = start..seeds.end.min(start.saturating_add(BLOCK));
            let path = folder.join(format!("{}-{}.json", block.start, block.end));
            if let Some(kept) = fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()) {
                return Ok(kept);
            }
            let result = fly(block)?;
            keep(&path, &result).with_context(|| path.display().to_string())?;
            Ok(result)
        })
        .collect()
}

/// Whole or not at all: a run may be stopped at any time.
fn keep<T: Serialize>(path: &PathBuf, result: &T) -> anyhow::Result<()> {
    let partial = path.with_extension("partial");
    fs::write(&partial, serde_json::to_vec(result)?)?;
    Ok(fs::rename(partial, path)?)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_run_that_was_stopped_goes_on_with_the_block_that_it_was_in() {
        let folder = tempfile::tempdir().unwrap();
        let mut flown = vec![];
        let stopped = each_block_in(folder.path(), 5..2_905, |block| {
            anyhow::ensure!(block.start < 2_000, "stopped");
            flown.push(block.clone());
            Ok(block.sum::<u64>())
        });
        assert_eq!(stopped.unwrap_err().to_string(), "stopped");
        assert_eq!(flown, [5..1_005, 1_005..2_005]);
        // A block's file that was cut while it was written counts as not there.
        fs::write(folder.path().join("1005-2005.json"), "15").unwrap();
        fs::write(folder.path().join("5-1005.json"), "{").unwrap();
        flown.clear();
        let all = each_block_in(folder.path(), 5..2_905, |block| {
            flown.push(block.clone());
            Ok(block.sum::<u64>())
        });
        assert_eq!(all.unwrap(), [(5..1_005).sum(), 15, (2_005..2_905).sum::<u64>()]);
        assert_eq!(flown, [5..1_005, 2_005..2_905]);
    }
}
