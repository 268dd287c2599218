//! The command line: each command with its options is one file.

mod batch;
mod bench;
mod calibrate;
mod command;
mod completions;
mod diagnose;
mod emulate;
mod exit_status;
mod field;
mod fleet;
mod grouped_help;
mod hold_out;
mod import;
pub mod main_job;
mod man;
mod monitor;
mod next_step;
mod provision;
mod record;
mod replay;
mod same_file;
pub mod simulate;
mod survey;
mod toml_file;
mod update;

use std::{borrow::Cow, ffi::OsString, process::ExitCode};

use anstyle::{AnsiColor, Style};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use exit_status::exit_status;

use testbed::console;

/// Identifies gyro errors while drilling and streams attitude: replays, emulates, simulates and scores.
/// Without a subcommand: flies a bundled recording end to end, scores it and prints the result.
#[derive(Debug, Parser)]
#[command(
    name = "mwd",
    bin_name = "cargo mwd",
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Examples:\n  cargo mwd\n  cargo mwd replay TRACE.csv --html report.html\n  cargo mwd replay --help"
)]
pub struct Cli {
    /// Options of the main job.
    #[command(flatten)]
    pub main_job: main_job::MainJobArgs,
    /// Print nothing but errors, and show no progress
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Command to run; the main job when absent.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fly a trace on this machine and print parameters (or why they were refused), attitude and scores
    #[command(
        after_help = "Examples:\n  cargo mwd replay host-tests/traces/broad_06_fast_rotation_110s.csv.gz --html report.html\n  cargo mwd replay TRACE.csv --hold-out 0.5 --json result.json --attitude attitude.csv"
    )]
    Replay(replay::ReplayArgs),
    /// Tell which physical effect a trace's residual shows
    #[command(
        after_help = "Examples:\n  cargo mwd diagnose host-tests/traces/broad_06_fast_rotation_110s.csv.gz --html report.html\n  cargo mwd diagnose TRACE.csv --against-reference"
    )]
    Diagnose(diagnose::DiagnoseArgs),
    /// Fly a trace with the firmware on an emulated Cortex-M4F, through register models of the sensors
    #[command(
        after_help = "Examples:\n  cargo mwd emulate host-tests/traces/broad_06_fast_rotation_110s.csv.gz --hold-out 0.5"
    )]
    Emulate(emulate::EmulateArgs),
    /// Make accelerometer and magnetometer models from traces with rests and turns
    #[command(
        after_help = "Examples:\n  cargo mwd calibrate host-tests/traces/multipos_mpu9150_imu0.csv.gz -o calibration.toml\n  cargo mwd replay TRACE.csv --config calibration.toml"
    )]
    Calibrate(calibrate::CalibrateArgs),
    /// Make a trace of foreign recordings, and refuse what cannot be
    #[command(
        after_help = "Examples:\n  cargo mwd import log.csv -o trace.csv.gz\n  cargo mwd import flight.ulg --key body_frame=tool -o trace.csv.gz"
    )]
    Import(import::ImportArgs),
    /// Simulate a scenario and write its trace
    #[command(
        after_help = "Examples:\n  cargo mwd simulate host-tests/scenarios/drilling_45deg.toml -o drilling.csv.gz --seed 1"
    )]
    Simulate(simulate::SimulateArgs),
    /// Fly many recordings at once and write tables of the results
    #[command(
        after_help = "Examples:\n  cargo mwd batch recordings -o results.parquet --html fleet.html\n  cargo mwd batch recordings -o results.parquet --hold-out 0.5"
    )]
    Batch(batch::BatchArgs),
    /// Show a batch's recordings as a page, the worst first, with the drift of P over months
    #[command(
        after_help = "Examples:\n  cargo mwd fleet results.parquet\n  cargo mwd fleet march.parquet april.parquet --html fleet.html"
    )]
    Fleet(fleet::FleetArgs),
    /// Measure speed and accuracy, and print tables
    #[command(
        after_help = "Examples:\n  cargo mwd bench --quick\n  cargo mwd bench --only benefit --markdown docs/measurements"
    )]
    Bench(bench::BenchArgs),
    /// Record a probe's raw samples as a trace, with the configuration beside it
    #[command(after_help = "Examples:\n  cargo mwd record /dev/ttyUSB0 --baud 921600 -o trace.csv.gz --seconds 120")]
    Record(record::RecordArgs),
    /// Show what a probe reports
    #[command(
        after_help = "Examples:\n  cargo mwd monitor /dev/ttyUSB0 --baud 921600\n  cargo mwd monitor capture.bin --once\n  cargo mwd monitor /dev/ttyUSB0 --web"
    )]
    Monitor(monitor::MonitorArgs),
    /// Send a command to a probe and wait for its answer
    #[command(
        after_help = "Examples:\n  cargo mwd command /dev/ttyUSB0 --baud 921600 self-test\n  cargo mwd command /dev/ttyUSB0 --key probe.key configure config.toml\n  cargo mwd command /dev/ttyUSB0 configure --help"
    )]
    Command(command::CommandArgs),
    /// Write the factory's records into a probe, once: calibration, mounting, key
    #[command(
        after_help = "Examples:\n  cargo mwd provision /dev/ttyUSB0 --baud 921600 --calibration calibration.toml --serial 17 --toolface-offset 12.5 --key probe.key\n  cargo mwd provision /dev/ttyUSB0 --baud 921600 --key probe.key --check"
    )]
    Provision(provision::ProvisionArgs),
    /// Send another program into a probe, start it on trial, and wait until it has confirmed itself
    #[command(
        after_help = "Examples:\n  cargo mwd update /dev/ttyUSB0 --baud 921600 --image probe.elf --number 2 --key probe.key"
    )]
    Update(update::UpdateArgs),
    /// Print a place's reference field and gravity as a configuration
    #[command(
        after_help = "Examples:\n  cargo mwd field --latitude 60.4 --longitude 5.3 --date 2026-06-01 > field.toml"
    )]
    Field(field::FieldArgs),
    /// Correct a run's surveys, work out the path with its uncertainty, and write the files that others read
    #[command(after_help = "Examples:\n  cargo mwd survey stations.csv --run run.toml --csv path.csv")]
    Survey(survey::SurveyArgs),
    /// Print the completions of a shell
    #[command(after_help = "Examples:\n  cargo mwd completions bash > ~/.local/share/bash-completion/completions/mwd")]
    Completions(completions::CompletionsArgs),
    /// Write manual pages of all commands
    #[command(after_help = "Examples:\n  cargo mwd man target/man")]
    Man(man::ManArgs),
}

/// Options of all commands that name an output.
const OUTPUTS: [&str; 16] = [
    "-o",
    "--attitude",
    "--rates",
    "--surveys",
    "--dynamics",
    "--burst",
    "--json",
    "--html",
    "--csv",
    "--plain",
    "--witsml1",
    "--witsml2",
    "--las",
    "--plot",
    "--plot-rate",
    "--plot-error",
];

/// Styles of messages on a terminal.
const RED: Style = AnsiColor::Red.on_default().bold();
const BOLD: Style = Style::new().bold();

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = command_first(std::env::args_os().collect());
    let matches = grouped_help::grouped(Cli::command()).get_matches_from(&arguments);
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    console::begin(cli.quiet, has_result_on_stdout(&arguments));
    let Err(error) = dispatch(&cli) else {
        return ExitCode::SUCCESS;
    };
    if console::reader_is_gone() {
        return ExitCode::SUCCESS;
    }
    anstream::eprintln!("{RED}error:{RED:#} {}", told_once(&error));
    let step = next_step::after_error(&error, matches.subcommand_name());
    anstream::eprintln!("{BOLD}next:{BOLD:#} {step}");
    ExitCode::from(exit_status(&error))
}

/// Arguments with the options of every command behind the command, where they may stand, too. Options of the
/// main job exclude a command, and the parser takes any option before a command for one of these.
fn command_first(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let global = arguments.iter().skip(1).take_while(|argument| *argument == "--quiet" || *argument == "-q").count();
    if let Some(moved) = arguments.get_mut(1..).filter(|_| global > 0) {
        let until = moved.iter().position(|argument| argument == "--").unwrap_or(moved.len());
        if let Some(moved) = moved.get_mut(..until) {
            moved.rotate_left(global);
        }
    }
    arguments
}

/// Returns true if an option that names an output names the standard output.
fn has_result_on_stdout(arguments: &[OsString]) -> bool {
    let arguments: Vec<_> = arguments.iter().map(|argument| argument.to_string_lossy()).collect();
    let names_stdout = |option: &str, value: &str| OUTPUTS.contains(&option) && value == console::STDIO;
    let is_pair = |pair: &[Cow<'_, str>]| matches!(pair, [option, value] if names_stdout(option, value));
    arguments.windows(2).any(is_pair)
        || arguments.iter().any(|argument| argument == "-o-")
        || arguments
            .iter()
            .filter_map(|argument| argument.split_once('='))
            .any(|(option, value)| names_stdout(option, value))
}

/// Text of an error with its causes, leaving out a cause that the text before it already contains.
fn told_once(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |told, cause| {
        if told.is_empty() {
            cause
        } else if told.contains(cause.trim_end()) {
            told
        } else {
            format!("{told}: {cause}")
        }
    })
}

fn dispatch(cli: &Cli) -> anyhow::Result<()> {
    match &cli.command {
        None => main_job::run(&cli.main_job),
        Some(Command::Replay(args)) => replay::run(args),
        Some(Command::Emulate(args)) => emulate::run(args),
        Some(Command::Import(args)) => import::run(args),
        Some(Command::Simulate(args)) => simulate::run(args),
        Some(Command::Diagnose(args)) => diagnose::run(args),
        Some(Command::Calibrate(args)) => calibrate::run(args),
        Some(Command::Batch(args)) => batch::run(args),
        Some(Command::Fleet(args)) => fleet::run(args),
        Some(Command::Bench(args)) => bench::run(args),
        Some(Command::Record(args)) => record::run(args),
        Some(Command::Monitor(args)) => monitor::run(args),
        Some(Command::Command(args)) => command::run(args),
        Some(Command::Provision(args)) => provision::run(args),
        Some(Command::Update(args)) => update::run(args),
        Some(Command::Field(args)) => field::run(args),
        Some(Command::Survey(args)) => survey::run(args),
        Some(Command::Completions(args)) => completions::run(args),
        Some(Command::Man(args)) => man::run(args),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::CommandFactory;

    use super::*;
    use testbed::simulate::Scenario;

    #[test]
    fn a_cause_is_told_once() {
        let scenario = Scenario::read(Path::new("none.toml")).map_err(anyhow::Error::from);
        let told = scenario.map_or_else(|error| told_once(&error), |_| String::new());
        assert!(told.starts_with("none.toml: ") && told.matches("os error").count() == 1, "{told}");
        assert_eq!(told_once(&anyhow::anyhow!("inner").context("outer")), "outer: inner");
    }

    /// The page of commands has a section for each, which names every option but `--help`.
    #[test]
    fn the_page_of_commands_names_every_option() {
        let page = include_str!("../../../docs/commands.md");
        let cli = Cli::command();
        let documented = |command: &clap::Command, section: &str| {
            for option in command.get_arguments().filter_map(clap::Arg::get_long) {
                let is_there = section.contains(&format!("--{option}")) || option == "help";
                assert!(is_there, "{}: --{option}", command.get_name());
            }
        };
        let sections: Vec<&str> = page.split("\n## ").collect();
        // From the last on: the first headline has the word "command" in it, too.
        let of = |name: &str| {
            let is_of = |section: &&&str| section.lines().next().unwrap_or_default().contains(name);
            sections.iter().rev().find(is_of)
        };
        documented(&cli, of("Without a command").unwrap());
        for command in cli.get_subcommands() {
            let shares_its_options = command.get_name() == "emulate";
            let section = of(command.get_name()).unwrap_or_else(|| panic!("{} has no section", command.get_name()));
            let replay = if shares_its_options { of("replay").unwrap() } else { "" };
            documented(command, &format!("{section}{replay}"));
        }
    }

    /// Each example parses, and names files of the repository that are there.
    #[test]
    fn every_help_has_examples_that_are_commands() {
        let cli = Cli::command();
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
        let mut commands = vec![&cli];
        let mut next = 0;
        while let Some(command) = commands.get(next).copied() {
            commands.extend(command.get_subcommands());
            next += 1;
        }
        assert!(commands.len() > 25, "{}", commands.len());
        for command in commands {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let examples: Vec<&str> = help.lines().filter_map(|line| line.strip_prefix("  cargo ")).collect();
            assert!(help.starts_with("Examples:\n") && !examples.is_empty(), "{}: {help}", command.get_name());
            for example in examples {
                let words: Vec<&str> = example.split(' ').take_while(|word| *word != ">").collect();
                let parsed = Cli::try_parse_from(&words);
                let asks_for_help = words.contains(&"--help");
                assert!(parsed.is_ok() || asks_for_help, "{example}: {}", parsed.unwrap_err());
                for path in words.iter().filter(|word| word.starts_with("host-tests/")) {
                    assert!(root.join(path).exists(), "{example}: {path}");
                }
            }
        }
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
