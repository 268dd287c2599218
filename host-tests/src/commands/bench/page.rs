//! Pages of measurements: one Markdown file for each section, which begins with the command that writes it.

use std::path::Path;

use super::sections::{Place, Section};
use testbed::study::{Effort, Table};
use testbed::{failure::Failure, trace::recordings::FOLDER};

/// Writes the page of a section into `folder`, which is made where it is missing.
///
/// # Errors
/// The folder or the file cannot be written.
pub(super) fn write(folder: &Path, section: &Section, effort: Effort, tables: &[Table]) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| Failure::output(folder, &error))?;
    let path = folder.join(section.name).with_extension("md");
    let own_recordings = std::env::var_os(FOLDER).is_some();
    let text = page(section, &command(section, effort, own_recordings), tables);
    std::fs::write(&path, text).map_err(|error| Failure::output(&path, &error))
}

/// Text of a page: its command, its subject and its tables.
fn page(section: &Section, command: &str, tables: &[Table]) -> String {
    let tables: Vec<String> = tables.iter().map(ToString::to_string).collect();
    format!("    {command}\n\n# {}\n\n{}", section.about, tables.join("\n"))
}

/// Command that writes the page of a section again. `FOLDER` stands for a folder of recordings of one's own.
fn command(section: &Section, effort: Effort, own_recordings: bool) -> String {
    let recordings =
        if section.takes_recordings && own_recordings { format!("{FOLDER}=FOLDER ") } else { String::new() };
    let target = if section.place == Place::Target { "--target " } else { "" };
    let effort = match effort {
        Effort::Full => String::new(),
        Effort::Quick => " --quick".to_owned(),
        Effort::Seeds(seeds) => format!(" --seeds {seeds}"),
        Effort::These { first, seeds } => format!(" --seeds {seeds} --first-seed {first}"),
    };
    format!("{recordings}cargo mwd bench {target}--only {}{effort} --markdown docs/measurements", section.name)
}

#[cfg(test)]
mod tests {
    use std::{collections::BTreeSet, fs, path::PathBuf};

    use super::{super::sections::SECTIONS, *};

    #[test]
    fn a_page_begins_with_the_command_that_writes_it_and_shows_every_table() {
        let section = SECTIONS.iter().find(|section| section.name == "benefit").unwrap();
        let command = command(section, Effort::Seeds(3), true);
        let tables = [Table::new("One", &["a", "b"]), Table::new("Two", &["c"])];
        let page = page(section, &command, &tables);
        assert_eq!(
            page.lines().next().unwrap().trim(),
            "MWD_RECORDINGS=FOLDER cargo mwd bench --only benefit --seeds 3 --markdown docs/measurements"
        );
        assert!(page.contains("\nOne\n\n| a | b |\n|---|---|\n\nTwo\n"), "{page}");
    }

    /// A page that the bench writes begins with its command and has the section's subject for a headline; all
    /// other pages begin with a command, too; the index names every page.
    #[test]
    fn every_page_of_measurements_begins_with_its_command_and_is_in_the_index() {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/measurements");
        let index = fs::read_to_string(folder.join("README.md")).unwrap();
        let mut pages = BTreeSet::new();
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            if name == "README" {
                continue;
            }
            let text = fs::read_to_string(&path).unwrap();
            let first = text.lines().next().unwrap();
            match SECTIONS.iter().find(|section| section.name == name) {
                Some(section) => {
                    assert!(first.contains(&format!("cargo mwd bench {}", target(section))), "{name}: {first}");
                    assert!(first.contains(&format!("--only {name}")), "{name}: {first}");
                    assert_eq!(text.lines().nth(2), Some(format!("# {}", section.about).as_str()), "{name}");
                }
                None => assert!(
                    first.starts_with("    cargo ") || first.starts_with("    MWD_MARKDOWN="),
                    "{name}: {first}"
                ),
            }
            assert!(index.contains(&format!("({name}.md)")), "{name} is not in the index");
            pages.insert(name);
        }
        let linked: BTreeSet<String> = index
            .split("](")
            .skip(1)
            .filter_map(|link| link.split_once(".md)").map(|(name, _)| name.to_owned()))
            .filter(|name| !name.contains('/'))
            .collect();
        assert_eq!(linked, pages);
    }

    fn target(section: &Section) -> &'static str {
        if section.place == Place::Target { "--target " } else { "" }
    }
}
