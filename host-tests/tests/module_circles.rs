//! The modules of library, firmware, desk and bindings: none imports what imports it.
//!
//! An arrow runs from a file to the file that defines a name it uses, in a `use` or in a path. A re-export is
//! a door, not an arrow: it leads to the file that defines the name. A module may name its own ancestors,
//! because it is a part of them. Unit tests do not count.

#![allow(clippy::unwrap_used)]

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// A path, as names from the root of the crate or as written.
type Names = Vec<String>;

/// The crates that are read: folder below the repository, and first file.
const CRATES: [(&str, &str); 8] = [
    ("src", "lib.rs"),
    ("src/bin/probe", "main.rs"),
    ("host-tests/src", "lib.rs"),
    ("host-tests/attack/src", "lib.rs"),
    ("host-tests/testbed/src", "lib.rs"),
    ("host-tests/research/src", "lib.rs"),
    ("bindings/c/src", "lib.rs"),
    ("bindings/python/src", "lib.rs"),
];

/// A file of a crate.
struct Module {
    file: PathBuf,
    /// Re-exported paths, by the names they get.
    doors: BTreeMap<String, Names>,
    /// Paths that the file names.
    named: Vec<Names>,
}

/// The modules of a crate by their paths.
type Crate = BTreeMap<Names, Module>;

#[test]
fn no_module_imports_what_imports_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for (folder, first) in CRATES {
        let arrows = arrows(&read_crate(&root.join(folder), first));
        let circles = circles(&arrows);
        assert!(circles.is_empty(), "{folder}: modules import each other in a circle: {circles:#?}");
    }
}

/// A top-level folder, with the file that has its name, is one subject, and subjects form layers. The firmware's board
/// is one subject in several: its chip's files lie under what all boards share, and its set-up above.
#[test]
fn no_folder_imports_what_imports_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let folder = |file: &PathBuf| file.iter().next().map(|name| Path::new(name).with_extension("")).unwrap();
    for (crate_folder, first) in CRATES.iter().filter(|(folder, _)| *folder != "src/bin/probe") {
        let mut folders: BTreeMap<PathBuf, BTreeSet<PathBuf>> = BTreeMap::new();
        for (from, to) in arrows(&read_crate(&root.join(crate_folder), first)) {
            let others = to.iter().map(folder).filter(|to| *to != folder(&from));
            folders.entry(folder(&from)).or_default().extend(others);
        }
        let circles = circles(&folders);
        assert!(circles.is_empty(), "{crate_folder}: folders import each other in a circle: {circles:#?}");
    }
}

/// Settled research is left alone by everything but the command that prints it, and the test of that command.
#[test]
fn only_the_bench_command_calls_settled_research() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let modules = read_crate(&root.join("src"), "lib.rs");
    let texts =
        modules.values().map(|module| (&module.file, fs::read_to_string(root.join("src").join(&module.file)).unwrap()));
    let callers = texts.filter(|(_, text)| code_of(text).contains("research::"));
    let callers: Vec<_> = callers.map(|(file, _)| file.display().to_string()).collect();
    assert_eq!(callers, ["commands/bench/sections.rs"]);
    for folder in ["attack", "testbed"] {
        let manifest = fs::read_to_string(root.join(folder).join("Cargo.toml")).unwrap();
        assert!(!manifest.contains("research"), "{folder}");
    }
}

#[test]
fn a_circle_is_found_through_a_door_and_through_a_path_without_use() {
    let sources = [
        ("", "mod a; mod b; mod c; pub use b::B;"),
        ("a", "use crate::{B, c::{self as other}}; fn f() -> B { other::g() }"),
        ("b", "pub struct B; // crate::a::f is only a comment's\n fn h() { super::c::g() }"),
        ("c", "pub fn g() {} mod tests { use crate::a::f; }"),
    ];
    let of = |sources: &[(&str, &str)]| -> Crate {
        let names = |path: &str| path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect::<Names>();
        let all: BTreeSet<Names> = sources.iter().map(|(path, _)| names(path)).collect();
        let module = |(path, text): &(&str, &str)| (names(path), Module::parse(path.into(), &names(path), text, &all));
        sources.iter().map(module).collect()
    };
    assert_eq!(circles(&arrows(&of(&sources))).len(), 0);
    let mut closed = sources;
    closed[3].1 = "pub fn g() { crate::a::f() }";
    let found = circles(&arrows(&of(&closed)));
    let files: Vec<_> = found.iter().map(|(files, _)| files.iter().map(|file| file.display().to_string())).collect();
    assert_eq!(files.into_iter().map(Iterator::collect).collect::<Vec<Vec<_>>>(), [["a", "b", "c"]]);
}

fn read_crate(folder: &Path, first: &str) -> Crate {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(path) = folders.pop() {
        for entry in fs::read_dir(path).unwrap() {
            let path = entry.unwrap().path();
            let file = path.strip_prefix(folder).unwrap().to_owned();
            let is_own = file.components().next().is_some_and(|name| name.as_os_str() != "bin");
            let is_test = file.with_extension("").ends_with("tests");
            if is_test {
                continue;
            }
            if path.is_dir() && is_own {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") && (is_own || folder.ends_with("probe")) {
                let mut names: Names =
                    file.with_extension("").iter().map(|name| name.to_string_lossy().into_owned()).collect();
                let is_first = file == Path::new(first);
                if is_first || names.last().is_some_and(|name| name == "mod") {
                    names.pop();
                }
                // The library's `bin` has first files of its own.
                if is_first || !["lib.rs", "main.rs"].map(Path::new).contains(&file.as_path()) {
                    files.insert(names, file);
                }
            }
        }
    }
    let all: BTreeSet<Names> = files.keys().cloned().collect();
    let read = |(names, file): (Names, PathBuf)| {
        let text = fs::read_to_string(folder.join(&file)).unwrap();
        (names.clone(), Module::parse(file, &names, &text, &all))
    };
    files.into_iter().map(read).collect()
}

impl Module {
    fn parse(file: PathBuf, own: &Names, text: &str, all: &BTreeSet<Names>) -> Self {
        let mut module = Self { file, doors: BTreeMap::new(), named: Vec::new() };
        let mut modules_by_name: BTreeMap<String, Names> = BTreeMap::new();
        let mut rest = String::new();
        let mut imported = Vec::new();
        for statement in code_of(text).split_inclusive([';', '{', '}']).collect::<String>().split(';') {
            // The text before `use` in the same statement is an attribute or the end of a block.
            let Some((before, tree)) = split_at_use(statement) else {
                rest.push_str(statement);
                rest.push(';');
                continue;
            };
            rest.push_str(before);
            let is_door = before.trim_end().ends_with("pub") || before.trim_end().ends_with(')');
            for (path, alias) in leaves(tree) {
                let Some(path) = from_root(&path, own, all) else { continue };
                let name = alias.or_else(|| path.last().cloned()).unwrap_or_default();
                if is_door && name != "*" {
                    module.doors.insert(name, path);
                } else if all.contains(&path) {
                    modules_by_name.insert(name, path);
                } else {
                    imported.push(path);
                }
            }
        }
        module.named = imported;
        for path in paths(&rest) {
            let head = modules_by_name.get(&path[0]);
            let full = head.map(|head| head.iter().cloned().chain(path[1..].iter().cloned()).collect());
            module.named.extend(full.or_else(|| from_root(&path, own, all)));
        }
        module
    }
}

/// The code without comments and unit tests.
fn code_of(text: &str) -> String {
    let mut code = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("mod tests") {
            break;
        }
        code.push_str(line.split("//").next().unwrap_or_default());
        code.push(' ');
    }
    // Lines were joined, so the tests of a file may stand in one line with its code.
    code.split(" mod tests {").next().unwrap_or_default().to_owned()
}

/// The text before `use`, and the tree behind it.
fn split_at_use(statement: &str) -> Option<(&str, &str)> {
    let at = statement.match_indices("use ").find(|(at, _)| {
        statement[..*at]
            .chars()
            .next_back()
            .is_none_or(|before| before.is_whitespace() || before == '{' || before == '}')
    })?;
    Some((&statement[..at.0], &statement[at.0 + 4..]))
}

/// The paths of a tree of imports, with their aliases.
fn leaves(tree: &str) -> Vec<(Names, Option<String>)> {
    let tree = tree.trim();
    if let Some((stem, branches)) = tree.split_once('{') {
        let branches = branches.trim_end().strip_suffix('}').unwrap_or(branches);
        let (mut depth, mut start, mut found) = (0_usize, 0, Vec::new());
        for (at, letter) in branches.char_indices().chain([(branches.len(), ',')]) {
            match letter {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    let branch = branches[start..at].trim();
                    if !branch.is_empty() {
                        found.extend(leaves(&format!("{stem}{branch}")));
                    }
                    start = at + 1;
                }
                _ => {}
            }
        }
        return found;
    }
    let (path, alias) = tree.split_once(" as ").map_or((tree, None), |(path, alias)| (path, Some(alias.trim())));
    let mut names: Names = path.split("::").map(|name| name.trim().to_owned()).collect();
    if names.len() > 1 && names.last().is_some_and(|name| name == "self") {
        names.pop();
    }
    vec![(names, alias.map(str::to_owned))]
}

/// Paths of two or more names in the code.
fn paths(code: &str) -> Vec<Names> {
    let is_of_path = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
    let words = code.split(|letter| !is_of_path(letter)).filter(|word| word.contains("::"));
    let names = words.map(|word| word.trim_matches(':').split("::").map(str::to_owned).collect::<Names>());
    names.filter(|names| names.len() > 1).collect()
}

/// A path as names from the root of the crate; `None` if it leaves the crate.
fn from_root(path: &Names, own: &Names, all: &BTreeSet<Names>) -> Option<Names> {
    let head = path.first()?.as_str();
    let ups = path.iter().take_while(|name| *name == "super").count();
    let (base, rest) = match head {
        "crate" => (Names::new(), &path[1..]),
        "self" => (own.clone(), &path[1..]),
        "super" => (own[..own.len().checked_sub(ups)?].to_vec(), &path[ups..]),
        _ => (own.clone(), &path[..]),
    };
    let full: Names = base.iter().chain(rest).cloned().collect();
    let is_relative = matches!(head, "crate" | "self" | "super");
    let child: Names = own.iter().chain([&path[0]]).cloned().collect();
    (is_relative || all.contains(&child)).then_some(full)
}

/// The module that defines what a path names, through every door.
fn definer(modules: &Crate, path: &Names, depth: usize) -> Option<Names> {
    let module = (0..=path.len()).rev().map(|n| &path[..n]).find(|stem| modules.contains_key(*stem))?.to_vec();
    let Some(item) = path.get(module.len()) else { return Some(module) };
    let here = modules.get(&module)?;
    // A door may lead to another door; doors in a loop do not compile.
    let Some(behind) = here.doors.get(item).filter(|_| depth < 8) else { return Some(module) };
    let behind = behind.iter().chain(&path[module.len() + 1..]).cloned().collect();
    definer(modules, &behind, depth + 1)
}

/// The files that each file names.
fn arrows(modules: &Crate) -> BTreeMap<PathBuf, BTreeSet<PathBuf>> {
    let mut arrows = BTreeMap::new();
    for (own, module) in modules {
        let targets = module.named.iter().filter_map(|path| definer(modules, path, 0));
        let files =
            targets.filter(|to| !own.starts_with(to)).map(|to| modules[&to].file.clone()).collect::<BTreeSet<_>>();
        arrows.insert(module.file.clone(), files);
    }
    arrows
}

/// The circles: files of each, and the arrows between them.
fn circles(arrows: &BTreeMap<PathBuf, BTreeSet<PathBuf>>) -> Vec<(BTreeSet<PathBuf>, Vec<String>)> {
    let reached = |from: &PathBuf| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(file) = open.pop() {
            open.extend(arrows.get(file).into_iter().flatten().filter(|to| seen.insert((*to).clone())));
        }
        seen
    };
    let reached: BTreeMap<&PathBuf, BTreeSet<PathBuf>> = arrows.keys().map(|from| (from, reached(from))).collect();
    let sets: BTreeSet<BTreeSet<PathBuf>> = (reached.iter().filter(|(from, to)| to.contains(**from)))
        .map(|(from, to)| to.iter().filter(|other| reached[other].contains(*from)).cloned().collect())
        .collect();
    let ties = |set: &BTreeSet<PathBuf>| {
        let inside = |from: &PathBuf| arrows[from].iter().filter(|to| set.contains(*to)).cloned().collect::<Vec<_>>();
        let lines = set.iter().flat_map(|from| inside(from).into_iter().map(move |to| (from, to)));
        lines.map(|(from, to)| format!("{} -> {}", from.display(), to.display())).collect()
    };
    sets.into_iter().map(|set| (set.clone(), ties(&set))).collect()
}
