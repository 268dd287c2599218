//! The recordings that a command line names: files, folders, patterns, and lists.

use std::path::{Path, PathBuf};

use testbed::failure::Failure;

/// Endings of traces.
const ENDINGS: [&str; 2] = [".csv", ".csv.gz"];

/// Recordings that a command line names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    /// In the order of their naming, each once; those of a folder in the order of their names.
    pub recordings: Vec<PathBuf>,
    /// Folders that were named: all recordings in them are read, those of their own folders too.
    pub folders: Vec<PathBuf>,
}

impl Inputs {
    /// Finds them. `@FILE` names a list, one a line.
    ///
    /// # Errors
    /// A list or a folder that cannot be read, or one that holds nothing.
    pub fn of(inputs: &[String]) -> Result<Self, Failure> {
        let mut found = Self::default();
        for input in inputs {
            add(input, &mut found)?;
        }
        let mut seen = std::collections::BTreeSet::new();
        found.recordings.retain(|path| seen.insert(path.clone()));
        Ok(found)
    }
}

fn add(input: &str, found: &mut Inputs) -> Result<(), Failure> {
    let bad = |what: String| Err(Failure::BadInput(format!("{input}: {what}")));
    if let Some(list) = input.strip_prefix('@') {
        let text = testbed::console::text(Path::new(list));
        let text = text.map_err(|error| Failure::unread(Path::new(list), &error))?;
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
        let before = found.recordings.len();
        lines.into_iter().try_for_each(|line| add(line, found))?;
        return if found.recordings.len() > before { Ok(()) } else { bad("the list names nothing".into()) };
    }
    let path = Path::new(input);
    if path.is_dir() {
        let before = found.recordings.len();
        folder(path, &mut found.recordings)?;
        found.folders.push(path.to_owned());
        return if found.recordings.len() > before {
            Ok(())
        } else {
            bad("the folder holds no .csv and no .csv.gz".into())
        };
    }
    // A file may have a star in its name.
    if !input.contains(['*', '?', '[']) || path.exists() {
        found.recordings.push(path.to_owned());
        return Ok(());
    }
    let matches = match glob::glob(input) {
        Ok(matches) => matches,
        Err(error) => return bad(format!("is no pattern: {error}")),
    };
    let before = found.recordings.len();
    found.recordings.extend(matches.flatten().filter(|path| path.is_file()));
    if found.recordings.len() > before { Ok(()) } else { bad("no file is so named".into()) }
}

fn folder(path: &Path, found: &mut Vec<PathBuf>) -> Result<(), Failure> {
    for path in testbed::trace::recordings::listed(path)? {
        let name = path.to_string_lossy().into_owned();
        if path.is_dir() && !name.ends_with(super::parts::ENDING) {
            folder(&path, found)?;
        } else if ENDINGS.iter().any(|ending| name.ends_with(ending)) {
            found.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::fs;

    use super::*;

    #[test]
    fn files_folders_patterns_and_lists_are_each_recording_once() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        fs::create_dir(at("deep")).unwrap();
        for name in ["b.csv", "a.csv.gz", "deep/c.csv", "notes.txt"] {
            fs::write(at(name), "").unwrap();
        }
        fs::write(at("list"), format!("# two\n{}\n\n{}\n", at("b.csv"), at("gone.csv"))).unwrap();
        let inputs = [at("deep/../b.csv"), at(""), at("*.csv"), format!("@{}", at("list"))];
        let all = Inputs::of(&inputs).unwrap();
        assert_eq!(all.folders, [Path::new(&at(""))]);
        let names: Vec<_> = all.recordings.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
        // The list's missing file is a row of its own later.
        assert_eq!(names, ["b.csv", "a.csv.gz", "b.csv", "c.csv", "gone.csv"]);
        assert!(Inputs::of(&[at("*.mat")]).unwrap_err().to_string().ends_with("no file is so named"));
        assert!(Inputs::of(&[format!("@{}", at("none"))]).is_err());
        fs::write(at("list"), "# none\n\n").unwrap();
        let error = Inputs::of(&[at("b.csv"), format!("@{}", at("list"))]).unwrap_err().to_string();
        assert!(error.ends_with("list: the list names nothing"), "{error}");
    }
}
