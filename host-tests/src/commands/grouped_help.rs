//! The help of the whole program, with its commands in groups by what a user has in hand.

use std::fmt::Write;

use clap::{Command, builder::StyledStr};

/// Groups with their commands.
pub const GROUPS: [(&str, &[&str]); 5] = [
    ("With a recording", &["import", "replay", "diagnose", "calibrate", "survey"]),
    ("With many recordings", &["batch", "fleet"]),
    ("With a probe on a line", &["record", "monitor", "command", "provision", "update"]),
    ("Without either", &["simulate", "emulate", "bench"]),
    ("To look up", &["field", "man", "completions", "help"]),
];

/// The command with its help grouped. Styles are left out where the output is no terminal.
#[must_use]
pub fn grouped(command: Command) -> Command {
    let styles = command.get_styles().clone();
    let (header, literal) = (styles.get_header(), styles.get_literal());
    let mut groups = String::new();
    for (name, members) in GROUPS {
        // Writing to a string does not fail.
        let _ = writeln!(groups, "{header}{name}:{header:#}");
        for member in members {
            let about = command.find_subcommand(member).and_then(Command::get_about).map(ToString::to_string);
            let about = about.unwrap_or_else(|| "Print this message or the help of a command".to_owned());
            let _ = writeln!(groups, "  {literal}{member:<11}{literal:#} {about}");
        }
        groups.push('\n');
    }
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}{header}Options of the main job:{header:#}\n{{options}}{{after-help}}"
    );
    command.help_template(StyledStr::from(template))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use clap::CommandFactory;

    use super::*;
    use crate::commands::Cli;

    #[test]
    fn every_command_is_in_one_group() {
        let mut grouped_names: Vec<&str> = GROUPS.iter().flat_map(|(_, members)| members.iter().copied()).collect();
        grouped_names.sort_unstable();
        let command = Cli::command();
        let mut all: Vec<&str> = command.get_subcommands().map(Command::get_name).chain(["help"]).collect();
        all.sort_unstable();
        assert_eq!(grouped_names, all);
        let help = grouped(Cli::command()).render_help().to_string();
        assert!(help.contains("\nWith a recording:\n  import ") && help.contains("--details"), "{help}");
        assert!(!help.contains('\u{1b}') && help.trim_end().ends_with("replay --help"), "{help}");
    }
}
