//! Results of single recordings, each in a file beside the tables, named by its key. A file appears whole or
//! not at all, so that a run that was killed goes on with what is there.

use std::{
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::key::Key;
use testbed::{failure::Failure, trace::Trace};

/// Ending of the folder.
pub const ENDING: &str = ".parts";

/// Result of one recording, without its path: two copies of a file have one result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Hash of the recording's bytes alone; none if it cannot be read.
    pub recording: Option<String>,
    /// Why there is no result.
    pub error: Option<String>,
    /// The result as `--json` writes it; null if there is none.
    pub result: Value,
    /// The surveys as `--surveys` writes them.
    pub surveys: String,
}

impl Part {
    /// The part of a recording that was not flown.
    #[must_use]
    pub fn refused(why: String) -> Self {
        Self { error: Some(why), ..Self::default() }
    }

    /// With the probe and the day of the recording, where its header has them: a damaged one is still of its probe.
    #[must_use]
    pub fn of_probe(self, path: &Path) -> Self {
        let keys = Trace::header(path).unwrap_or_default();
        let known = [("serial", keys.serial), ("date", keys.date.map(|date| date.to_string()))];
        let trace: Map<String, Value> =
            known.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?.into()))).collect();
        Self { result: if trace.is_empty() { Value::Null } else { json!({ "trace": trace }) }, ..self }
    }

    /// Length of the recording, seconds; zero if it was refused.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.result["trace"]["duration_s"].as_f64().unwrap_or(0.0)
    }
}

/// The folder of a run's parts.
pub struct Parts(PathBuf);

impl Parts {
    /// Opens or makes the folder beside the tables.
    pub fn beside(results: &Path) -> Result<Self, Failure> {
        let mut name = OsString::from(results.file_name().unwrap_or_default());
        name.push(ENDING);
        let folder = results.with_file_name(name);
        fs::create_dir_all(&folder).map_err(|error| Failure::output(&folder, &error))?;
        Ok(Self(folder))
    }

    fn file(&self, key: &Key) -> PathBuf {
        self.0.join(key.text()).with_extension("json")
    }

    pub fn has(&self, key: &Key) -> bool {
        self.file(key).exists()
    }

    pub fn read(&self, key: &Key) -> Result<Part, Failure> {
        let file = self.file(key);
        let bad = |what: String| Failure::BadInput(format!("{}: {what}; delete it and run again", file.display()));
        let text = fs::read_to_string(&file).map_err(|error| bad(format!("cannot be read: {error}")))?;
        serde_json::from_str(&text).map_err(|error| bad(error.to_string()))
    }

    /// Writes a part under another name first, so that it is never there in half.
    pub fn write(&self, key: &Key, part: &Part) -> Result<(), Failure> {
        let file = self.file(key);
        let failed = |error: std::io::Error| Failure::output(&file, &error);
        let text = serde_json::to_string(part).map_err(|error| failed(error.into()))?;
        let mut unfinished = tempfile::NamedTempFile::new_in(&self.0).map_err(failed)?;
        std::io::Write::write_all(&mut unfinished, text.as_bytes()).map_err(failed)?;
        unfinished.persist(&file).map_err(|error| failed(error.error)).map(|_| ())
    }
}
