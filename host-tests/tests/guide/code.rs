//! Code in the guide's pages, and in the README: Rust and C are compiled, Python and TOML are parsed, recordings are
//! read, and a line of the shell parses, with `cargo mwd` by the program's own options.

use std::{
    collections::BTreeSet,
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use clap::{CommandFactory, Parser, error::ErrorKind};
use meerkat_mwd::{Config, config::SurveyConfig};
use mwd::{commands::Cli, import::ColumnMap, surveys::settings::RunSettings};
use testbed::{simulate::Scenario, trace::Trace};

use super::{guide, pages, root, text};

/// Files of the repository with the code of the guide's pages, and the README: each once, with its text.
fn documents() -> Vec<(PathBuf, String)> {
    let mut found: Vec<(PathBuf, String)> =
        pages(&guide()).into_iter().map(|page| (page.clone(), text(&page))).collect();
    found.push(("README.md".into(), fs::read_to_string(root().join("README.md")).unwrap()));
    found
}

/// A block of code: its document, language and text.
struct Block {
    document: PathBuf,
    language: String,
    text: String,
}

fn blocks() -> Vec<Block> {
    let mut found = Vec::new();
    for (document, text) in documents() {
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            if let Some(language) = line.trim_start().strip_prefix("```") {
                assert!(!language.is_empty(), "{}: a block without a language", document.display());
                let inside: Vec<&str> = lines.by_ref().take_while(|line| line.trim_start() != "```").collect();
                found.push(Block { document: document.clone(), language: language.into(), text: inside.join("\n") });
            }
        }
    }
    assert!(found.len() > 60, "{}", found.len());
    found
}

fn of_language(language: &str) -> Vec<Block> {
    let found: Vec<Block> = blocks().into_iter().filter(|block| block.language == language).collect();
    assert!(!found.is_empty(), "{language}");
    found
}

/// Runs a program with a text as its input.
fn takes(program: &mut Command, input: &str, block: &Block) {
    program.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = program.spawn().unwrap_or_else(|error| panic!("{program:?}: {error}"));
    running.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    let output = running.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {said}\n{}", block.document.display(), block.text);
}

/// Programs with which a line of the shell begins.
const SHELL: [&str; 11] =
    ["cargo", "rustup", "apt", "pip", "python3", "cc", "mkdir", "probe-rs", "arm-none-eabi-gcc", ".ci/run", "git"];

fn is_shell(block: &Block) -> bool {
    block.language == "text" && SHELL.contains(&block.text.split_whitespace().next().unwrap_or_default())
}

/// A recording, or lines of its header.
fn is_recording(block: &Block) -> bool {
    block.language == "text" && (block.text.starts_with("t_s,") || block.text.starts_with("# "))
}

/// No code hides behind a language that nothing reads.
#[test]
fn every_block_is_of_a_kind_that_is_tested() {
    for block in blocks() {
        let place = block.document.display();
        let known = ["rust", "c", "python", "toml", "text", "layout"];
        assert!(known.contains(&block.language.as_str()), "{place}: {}", block.language);
        if block.language == "text" && !is_shell(&block) && !is_recording(&block) {
            let code = block.text.lines().find(|line| line.trim_end().ends_with(';') || line.contains("fn "));
            assert_eq!(code, None, "{place}: this looks like code");
        }
    }
}

/// By the documentation tests of the library, which compile the pages that they include.
#[test]
fn every_rust_block_is_compiled() {
    let library = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let of_pages: BTreeSet<PathBuf> = of_language("rust").into_iter().map(|block| block.document).collect();
    for page in of_pages {
        let shown = page.display();
        let is_there =
            ["", "guide/src/"].iter().any(|folder| library.contains(&format!("include_str!(\"../{folder}{shown}\")")));
        assert!(is_there, "{shown}");
    }
}

/// Against the committed header, as the inside of a function.
#[test]
fn every_c_block_is_compiled() {
    for block in of_language("c") {
        let whole = format!("#include <meerkat_mwd.h>\nvoid block(void);\nvoid block(void) {{\n{}\n}}\n", block.text);
        let mut compiler = Command::new("gcc");
        compiler.args(["-std=c99", "-fsyntax-only", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-Werror"]);
        takes(compiler.arg("-I").arg(root().join("bindings/c/include")).args(["-xc", "-"]), &whole, &block);
    }
}

/// Names of the package that a block uses stand in its sources.
#[test]
fn every_python_block_is_compiled_and_names_what_is_there() {
    let sources = root().join("bindings/python/python/meerkat_mwd");
    let source: String = super::files(&sources, "py").iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    for block in of_language("python") {
        takes(
            Command::new("python3").args(["-c", "import sys; compile(sys.stdin.read(), 'page', 'exec')"]),
            &block.text,
            &block,
        );
        for module in ["mwd.", "fleet."] {
            for (place, _) in block.text.match_indices(module) {
                let name: String = block.text[place + module.len()..]
                    .chars()
                    .take_while(|c| c.is_alphanumeric() || *c == '_')
                    .collect();
                let is_defined =
                    ["def ", "class ", "import "].iter().any(|word| source.contains(&format!("{word}{name}")));
                assert!(
                    is_defined || source.contains(&format!("\"{name}\"")),
                    "{}: {module}{name}",
                    block.document.display()
                );
            }
        }
    }
}

/// A map of columns, settings of a probe, a run and a scenario by the program's parsers; the rest are cargo's files.
#[test]
fn every_toml_block_is_parsed() {
    let cargo_keys = ["dependencies", "profile", "build", "target", "features", "patch", "package"];
    for block in of_language("toml") {
        let document = block.document.to_string_lossy().into_owned();
        let of_a_probe = || toml::from_str::<Config>(&block.text).map(|config| config.validate().unwrap());
        if document.ends_with("commands.md") {
            let map = toml::from_str::<ColumnMap>(&block.text);
            assert!(map.is_ok() || of_a_probe().is_ok(), "{document}: {:?}", map.err());
        } else if document.ends_with("configuration.md") {
            let of_surveys = toml::from_str::<SurveyConfig>(&block.text).map(|config| config.validate().unwrap());
            let error = of_a_probe().err().filter(|_| of_surveys.is_err());
            assert_eq!(error, None, "{document}");
        } else if document.ends_with("scenario.md") {
            toml::from_str::<Scenario>(&block.text).unwrap_or_else(|error| panic!("{document}: {error}"));
        } else if document.ends_with("surveys.md") {
            RunSettings::parse(&block.text).unwrap_or_else(|error| panic!("{document}: {error}"));
        } else {
            let table: toml::Table = block.text.parse().unwrap_or_else(|error| panic!("{document}: {error}"));
            assert!(table.keys().all(|key| cargo_keys.contains(&key.as_str())), "{document}: {table}");
        }
    }
}

/// By the reader of traces; lines of a header with two rows below them.
#[test]
fn every_recording_is_read() {
    let blocks: Vec<Block> = blocks().into_iter().filter(is_recording).collect();
    assert!(blocks.len() >= 3, "{}", blocks.len());
    for block in blocks {
        let rows = "\nt_s,gx,gy,gz,ax,ay,az\n0.0,0,0,0,0,0,-9.8\n0.005,0,0,0,0,0,-9.8";
        let whole = if block.text.starts_with('#') { block.text.clone() + rows } else { block.text.clone() };
        let trace = Trace::of_bytes((whole + "\n").as_bytes());
        assert!(trace.is_ok(), "{}: {:?}", block.document.display(), trace.err());
    }
}

/// The program's options and commands are named right. Words in capitals stand for values.
fn is_taken(document: &Path, line: &str) {
    let words: Vec<&str> = line.split_whitespace().take_while(|word| !["|", ">", "#"].contains(word)).collect();
    let place = document.display();
    // A synopsis: optional parts in brackets, alternatives, repeats.
    if line.contains('[') || line.contains("...") || words.iter().any(|word| word.contains('|')) {
        let cli = Cli::command();
        let named = words.get(2).and_then(|name| cli.find_subcommand(name)).unwrap_or(&cli);
        for word in words.iter().map(|word| word.trim_matches(['[', ']', '.'])).filter(|word| word.starts_with("--")) {
            let option = word.trim_start_matches("--").split(['=', '[']).next().unwrap();
            let is_option = |command: &clap::Command| command.get_arguments().any(|a| a.get_long() == Some(option));
            assert!(is_option(named) || is_option(&cli), "{place}: {line}: --{option}");
        }
        return;
    }
    let Err(error) = Cli::try_parse_from(&words[1..]) else { return };
    let has_placeholder = words.iter().any(|word| word.chars().all(|c| c.is_ascii_uppercase()));
    let is_fine = match error.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
        | ErrorKind::DisplayVersion
        | ErrorKind::MissingRequiredArgument => true,
        ErrorKind::InvalidValue | ErrorKind::InvalidSubcommand => has_placeholder,
        _ => false,
    };
    assert!(is_fine, "{place}: {line}: {error}");
}

/// Lines of the program's commands, in blocks and in backquotes.
#[test]
fn every_command_of_the_program_parses() {
    let in_blocks = blocks().into_iter().filter(is_shell).flat_map(|block| {
        // A line that goes on, after a backslash or as an indented synopsis, is one line.
        let joined = block.text.replace("\\\n", " ").replace("\n  ", " ");
        joined.lines().map(|line| (block.document.clone(), line.to_owned())).collect::<Vec<_>>()
    });
    let in_backquotes = documents().into_iter().flat_map(|(document, text)| {
        let outside: String = text.split("```").step_by(2).collect();
        let quoted = outside.split('`').skip(1).step_by(2).map(|code| code.replace('\n', " "));
        quoted.map(|code| (document.clone(), code)).collect::<Vec<_>>()
    });
    let mut count = 0;
    for (document, line) in in_blocks.chain(in_backquotes) {
        for command in line.split(" | ").map(str::trim).filter(|command| command.starts_with("cargo mwd")) {
            is_taken(&document, command);
            count += 1;
        }
    }
    assert!(count > 60, "{count}");
}

/// The shell takes every line, and what cargo is told to build or test is there.
#[test]
fn every_line_of_the_shell_parses() {
    let blocks: Vec<Block> = blocks().into_iter().filter(is_shell).collect();
    assert!(blocks.len() > 30, "{}", blocks.len());
    let is_there = |option: &str, name: &str| match option {
        "--test" => ["host-tests/tests", "host-tests/attack/tests", "tests"].iter().any(|folder| {
            root().join(folder).join(format!("{name}.rs")).exists() || root().join(folder).join(name).is_dir()
        }),
        "--example" => root().join("examples").join(format!("{name}.rs")).exists(),
        "--bin" => root().join("src/bin").join(name).is_dir(),
        "--features" => {
            let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
            name.split(',').all(|feature| manifest.contains(&format!("\n{feature} = [")))
        }
        _ => true,
    };
    for block in blocks {
        takes(Command::new("sh").arg("-n"), &block.text.replace("[", "").replace("]", ""), &block);
        for line in block.text.lines().filter(|line| line.starts_with("cargo ") && !line.starts_with("cargo mwd")) {
            let words: Vec<&str> = line.split_whitespace().collect();
            for pair in words.windows(2) {
                assert!(is_there(pair[0], pair[1]), "{}: {line}: {}", block.document.display(), pair[1]);
            }
        }
    }
}
