//! Outputs that would overwrite an input or each other: tests whether two paths name one file, even if it does not
//! exist yet.

use std::path::{Path, PathBuf};

use testbed::{console::is_stdio, failure::Failure};

/// Refuses to overwrite an input, and to write two results to one file.
///
/// # Errors
/// The first output that would overwrite something.
pub fn none_overwritten(outputs: &[&Path], inputs: &[&Path]) -> Result<(), Failure> {
    for (index, output) in outputs.iter().enumerate() {
        // A terminal or /dev/null may be named any number of times.
        if output.exists() && !output.is_file() {
            continue;
        }
        let taken =
            |what: &str| Err(Failure::BadInput(format!("{}: the result would overwrite {what}", output.display())));
        if inputs.iter().any(|input| same_file(output, input)) {
            return taken("what is read");
        }
        if outputs.iter().take(index).any(|other| other == output || same_file(output, other)) {
            return taken("another one");
        }
    }
    Ok(())
}

/// Returns true if writing to one path would change what is read from the other.
#[must_use]
pub fn same_file(a: &Path, b: &Path) -> bool {
    // The standard input is no file.
    !is_stdio(a) && !is_stdio(b) && resolved(a).is_some_and(|a| resolved(b) == Some(a))
}

/// Returns true if a folder, which need not exist yet, is another one or lies in it.
#[must_use]
pub fn lies_in(folder: &Path, other: &Path) -> bool {
    let absolute = std::path::absolute(folder).unwrap_or_default();
    let there = absolute.ancestors().find_map(|ancestor| ancestor.canonicalize().ok());
    there.zip(other.canonicalize().ok()).is_some_and(|(there, other)| there.starts_with(other))
}

/// Absolute path; for a file that does not exist yet, that of its folder and its name.
fn resolved(path: &Path) -> Option<PathBuf> {
    if let Ok(there) = path.canonicalize() {
        return Some(there);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some(folder.canonicalize().ok()?.join(path.file_name()?))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_file_that_is_not_there_yet_has_one_identity_however_it_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("inner")).unwrap();
        assert!(same_file(&at("x.json"), &at("inner/../x.json")));
        assert!(same_file(Path::new("none.json"), Path::new("./none.json")));
        assert!(!same_file(&at("x.json"), &at("inner/x.json")));
        assert!(!same_file(&at("x.json"), &at("y.json")));
        assert!(!same_file(&at("none/x.json"), &at("nowhere/x.json")), "neither can be written");
        std::fs::write(at("x.json"), "").unwrap();
        assert!(same_file(&at("x.json"), &at("inner/../x.json")));
    }
}
