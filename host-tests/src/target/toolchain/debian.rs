//! Installation of Debian packages.

use super::ask;
use crate::target::deadline;
use std::{process::Command, time::Duration};

const APT_UPDATE: Duration = Duration::from_secs(180);
const APT_INSTALL: Duration = Duration::from_secs(600);

/// Installs Debian packages as root, or through a sudo that asks for no password.
pub(super) fn apt_install(packages: &[&str]) -> Result<(), String> {
    let root = ask("id", &["-u"]).is_ok_and(|id| id.trim() == "0");
    if !root && ask("sudo", &["-n", "true"]).is_err() {
        return Err("no right to install packages (not root, and sudo asks for a password)".to_owned());
    }
    let apt_get = |arguments: &[&str], time: Duration| {
        // A root process cannot be stopped from here, but `timeout` runs as root too. It fires a little
        // before the deadline.
        let seconds = time.as_secs().to_string();
        let words = [
            "env",
            "DEBIAN_FRONTEND=noninteractive",
            "timeout",
            "--foreground",
            "--kill-after=10",
            &seconds,
            "apt-get",
        ];
        let mut words = words.iter().chain(arguments);
        let mut command = if root {
            Command::new(words.next().unwrap_or(&"env"))
        } else {
            let mut sudo = Command::new("sudo");
            sudo.arg("-n");
            sudo
        };
        deadline::run(command.args(words), time + Duration::from_secs(15)).map_err(|error| error.to_string())
    };
    eprintln!("installing {}: apt-get install {}", packages.join(" "), packages.join(" "));
    // Go on after an error: the old index may do, and one unreachable mirror fails the update.
    if let Err(error) = apt_get(&["update", "-q"], APT_UPDATE) {
        eprintln!("apt-get update: {error}");
    }
    let install = ["install", "-q", "-y", "--no-install-recommends", "-o", "DPkg::Lock::Timeout=120"];
    apt_get(&[&install[..], packages].concat(), APT_INSTALL).map(drop)
}
