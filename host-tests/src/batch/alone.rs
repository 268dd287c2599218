//! One recording of a batch that another engine distributes, such as Dask: its own three tables.

use std::path::Path;

use super::{flown::Beside, flown_or_refused, key::Key, options::Options, parquet_file::Tables, parts::Part, schema};
use testbed::failure::Failure;

/// Flies the recording in `file`, which the engine knows by its `address`, and writes `results` and the two
/// tables beside it, as [`super::run`] does of many. What cannot be flown is a row with its reason; so is a
/// file that could not be fetched, in the place of which stands why.
///
/// Returns the key of the rows. It is `key`, or that of the address where the recording is not to blame and
/// should be flown again.
///
/// # Errors
/// A table cannot be written.
pub fn alone(
    address: &str,
    file: Result<&Path, String>,
    key: Key,
    results: &Path,
    options: &Options,
) -> Result<Key, Failure> {
    let (part, is_of_the_input) = match file {
        Ok(file) => flown_or_refused(file, options, &Beside::of(file, &key, options)),
        Err(why) => (Part::refused(why), false),
    };
    let address = Path::new(address);
    let key = if is_of_the_input { key } else { Key::of_path(address) };
    let mut tables = Tables::create(results)?;
    tables.push(&schema::rows(address, &key, &part))?;
    tables.finish()?;
    Ok(key)
}
