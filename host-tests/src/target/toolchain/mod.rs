//! The toolchain for the chip: Rust's core library for it, and QEMU. Installs them where that is allowed.

mod debian;

use super::{
    deadline::{self, CommandError},
    missing::Missing,
};
use debian::apt_install;
use std::{
    env, fs,
    fs::File,
    path::{Path, PathBuf},
    process::Command,
    sync::OnceLock,
    time::Duration,
};

/// Rust's target for the chip: a Cortex-M4 with a single-precision FPU.
pub const TARGET: &str = "thumbv7em-none-eabihf";
/// Machine of QEMU 8 and later, with the STM32F405's memory.
const OLIMEX: &str = "olimex-stm32-h405";
/// Machine of older QEMU: lacks the chip's CCM and has 64 KiB more SRAM instead.
const NETDUINO: &str = "netduinoplus2";
/// STM32F405 machines, best first.
const MACHINES: [&str; 2] = [OLIMEX, NETDUINO];
/// Environment variable that tells build scripts that the CCM, and with it the stack, is behind the SRAM.
const CCM_BEHIND_SRAM: &str = "MWD_CCM_BEHIND_SRAM";
/// Compiler flags, as in `.cargo/config.toml`: with the processor's own timings the compiler prefers a
/// product and a sum to the slower chained multiply-add.
pub const RUSTFLAGS: [&str; 1] = ["-Ctarget-cpu=cortex-m4"];
const QEMU: &str = "qemu-system-arm";
/// Debian's compiler with the source of the core library, for when the server of rustup's targets cannot be
/// reached.
const DEBIAN_RUST: [&str; 3] = ["rustc-web", "cargo-web", "rust-web-src"];

/// Time allowed for a question to an installed program.
const ASK: Duration = Duration::from_secs(30);
/// Time allowed for rustup, which takes 2 s; if its server never answers it would wait for many minutes.
const RUSTUP: Duration = Duration::from_secs(60);
const FETCH: Duration = Duration::from_secs(180);

/// The compiler and the emulator for the chip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Toolchain {
    /// Path of the emulator.
    pub qemu: PathBuf,
    /// Name of the emulated machine.
    pub machine: &'static str,
    compiler: Compiler,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Compiler {
    /// The Rust that built this program; it has the chip's core library.
    Own,
    /// Debian's Rust, which compiles the core library too, with `linker` from the Rust that built this
    /// program.
    Debian { linker: PathBuf },
}

impl Toolchain {
    /// Cargo with an environment that builds the same firmware whatever the user's flags, profiles and target
    /// directory. The caller adds `-p` and the like.
    #[must_use]
    pub fn cargo_build(&self) -> Command {
        let mut cargo = self.compiler.cargo("build");
        cargo.args(["--release", "--locked", "--target", TARGET, "--target-dir"]).arg(self.target_dir());
        if self.ccm_is_behind_sram() {
            cargo.env(CCM_BEHIND_SRAM, "1");
        } else {
            cargo.env_remove(CCM_BEHIND_SRAM);
        }
        cargo
    }

    /// Version of the compiler, as it states it: another one makes other code.
    ///
    /// # Errors
    /// It cannot be asked.
    pub fn compiler_version(&self) -> Result<String, CommandError> {
        let program = match self.compiler {
            Compiler::Own => rustc(),
            Compiler::Debian { .. } => "/usr/bin/rustc".into(),
        };
        Ok(ask(program, &["--version"])?.trim().to_owned())
    }

    /// Returns true if the emulated machine has more SRAM where the chip has its CCM.
    #[must_use]
    pub fn ccm_is_behind_sram(&self) -> bool {
        self.machine == NETDUINO
    }

    /// Path of the release build of `binary`.
    #[must_use]
    pub fn built(&self, binary: &str) -> PathBuf {
        self.target_dir().join(TARGET).join("release").join(binary)
    }

    fn target_dir(&self) -> PathBuf {
        target_dir().join(match self.compiler {
            Compiler::Own => "firmware",
            Compiler::Debian { .. } => "firmware-debian",
        })
    }
}

impl Compiler {
    fn cargo(&self, verb: &str) -> Command {
        let mut cargo = match self {
            Self::Own => Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into())),
            Self::Debian { .. } => Command::new("/usr/bin/cargo"),
        };
        cargo.current_dir(workspace()).arg(verb);
        for (name, _) in env::vars_os() {
            let text = name.to_string_lossy();
            let changes_the_build = text.ends_with("RUSTFLAGS")
                || text.starts_with("CARGO_PROFILE_")
                || text.starts_with("CARGO_TARGET_THUMBV7EM")
                || text == "RUSTC_WORKSPACE_WRAPPER";
            if changes_the_build {
                cargo.env_remove(&name);
            }
        }
        // Overrides flags from configuration files too.
        cargo.env("CARGO_ENCODED_RUSTFLAGS", RUSTFLAGS.join("\u{1f}"));
        if let Self::Debian { linker } = self {
            let path = env::var("PATH").unwrap_or_default();
            cargo.env_remove("RUSTUP_TOOLCHAIN").env_remove("RUSTC").env_remove("CARGO");
            cargo.env("PATH", format!("/usr/bin:{path}")).env("RUSTC_BOOTSTRAP", "1");
            cargo.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker).arg("-Zbuild-std=core");
        }
        cargo
    }
}

/// Root of the workspace that this program was built in.
#[must_use]
pub fn workspace() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

/// Directory of the workspace's build results.
#[must_use]
pub fn target_dir() -> PathBuf {
    workspace().join(env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// Waits for and takes a lock between processes; held until the file is dropped.
///
/// # Errors
/// The target directory cannot be written.
pub fn lock(name: &str) -> std::io::Result<File> {
    fs::create_dir_all(target_dir())?;
    let file = File::create(target_dir().join(name))?;
    file.lock()?;
    Ok(file)
}

/// Finds the toolchain and installs what is missing, with a note on standard error. With `MWD_NO_INSTALL` set
/// it installs nothing. Tries once per process: another attempt would wait as long for the same answer.
///
/// # Errors
/// Tools that are still missing, with one command that installs them.
pub fn prepare() -> Result<Toolchain, Missing> {
    static PREPARED: OnceLock<Result<Toolchain, Missing>> = OnceLock::new();
    PREPARED.get_or_init(find_or_install).clone()
}

fn find_or_install() -> Result<Toolchain, Missing> {
    let writable = |e| Missing::new(format!("{} cannot be written: {e}", target_dir().display()), "chmod u+w");
    let _one_at_a_time = lock("mwd-toolchain.lock").map_err(writable)?;
    match (compiler(), emulator()) {
        (Ok(compiler), Ok((qemu, machine))) => {
            fetch(&compiler)?;
            Ok(Toolchain { qemu, machine, compiler })
        }
        (Err(one), Err(other)) => Err(Missing {
            what: format!("{}\n{}", one.what, other.what),
            command: format!("{} && {}", one.command, other.command),
        }),
        (Err(missing), _) | (_, Err(missing)) => Err(missing),
    }
}

fn may_install() -> bool {
    env::var_os("MWD_NO_INSTALL").is_none()
}

fn ask(program: impl AsRef<std::ffi::OsStr>, arguments: &[&str]) -> Result<String, CommandError> {
    deadline::run(Command::new(program).args(arguments).current_dir(workspace()), ASK)
}

fn compiler() -> Result<Compiler, Missing> {
    if has_core_library() {
        return Ok(Compiler::Own);
    }
    if let Some(debian) = debian_compiler() {
        return Ok(debian);
    }
    let what = format!("Rust's core library for {TARGET} is not installed");
    let command = format!("rustup target add {TARGET}");
    if !may_install() {
        return Err(Missing::new(what, command));
    }
    eprintln!("installing {TARGET} for Rust: {command}");
    let mut rustup = Command::new("rustup");
    let rustup_says = match deadline::run(rustup.args(["target", "add", TARGET]).current_dir(workspace()), RUSTUP) {
        Ok(_) if has_core_library() => return Ok(Compiler::Own),
        Ok(_) => "rustup installed it for another toolchain".to_owned(),
        Err(error) => error.to_string(),
    };
    eprintln!("{rustup_says}");
    let debian_says = match apt_install(&DEBIAN_RUST) {
        Ok(()) => "the Debian packages came without the core library's source".to_owned(),
        Err(error) => error,
    };
    debian_compiler().ok_or_else(|| Missing::new(format!("{what}; {rustup_says}; {debian_says}"), command))
}

/// Returns true if this Rust can compile for the chip; uses no network.
fn has_core_library() -> bool {
    let Ok(directory) = ask(rustc(), &["--print", "target-libdir", "--target", TARGET]) else { return false };
    let Ok(entries) = fs::read_dir(directory.trim()) else { return false };
    entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-"))
}

fn rustc() -> std::ffi::OsString {
    env::var_os("RUSTC").unwrap_or_else(|| "rustc".into())
}

/// Debian's compiler, if it and everything it needs is installed.
fn debian_compiler() -> Option<Compiler> {
    let sysroot = ask("/usr/bin/rustc", &["--print", "sysroot"]).ok()?;
    let source = Path::new(sysroot.trim()).join("lib/rustlib/src/rust/library/Cargo.lock");
    let own = ask(rustc(), &["--print", "sysroot"]).ok()?;
    let version = ask(rustc(), &["-vV"]).ok()?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: "))?;
    let linker = Path::new(own.trim()).join("lib/rustlib").join(host).join("bin/rust-lld");
    let all_there = source.exists() && linker.exists() && Path::new("/usr/bin/cargo").exists();
    all_there.then_some(Compiler::Debian { linker })
}

/// Downloads the crates that only the firmware needs; building this program did not.
fn fetch(compiler: &Compiler) -> Result<(), Missing> {
    let arguments = ["--locked", "--target", TARGET];
    deadline::run(compiler.cargo("fetch").args(arguments), FETCH).map(drop).map_err(|error| {
        Missing::new(format!("the firmware's dependencies cannot be downloaded; {error}"), "cargo fetch --locked")
    })
}

fn emulator() -> Result<(PathBuf, &'static str), Missing> {
    let mut machines = ask(QEMU, &["-machine", "help"]);
    let mut why = String::new();
    if machines.is_err() && may_install() {
        match apt_install(&[QEMU]) {
            Ok(()) => machines = ask(QEMU, &["-machine", "help"]),
            Err(error) => why = format!("; {error}"),
        }
    }
    let command = if cfg!(target_os = "macos") { "brew install qemu" } else { "sudo apt-get install qemu-system-arm" };
    let Ok(machines) = machines else {
        return Err(Missing::new(format!("the emulator {QEMU} is not installed{why}"), command));
    };
    let listed = |machine: &&str| machines.lines().any(|line| line.split_whitespace().next() == Some(machine));
    match MACHINES.into_iter().find(listed) {
        Some(machine) => Ok((PathBuf::from(QEMU), machine)),
        None => Err(Missing::new(format!("{QEMU} is too old: it has none of {}", MACHINES.join(", ")), command)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_firmware_built_by_hand_is_built_with_the_same_flags() {
        let config = fs::read_to_string(workspace().join(".cargo/config.toml")).unwrap();
        let config: toml::Table = config.parse().unwrap();
        let flags = config["target"][TARGET]["rustflags"].as_array().unwrap();
        assert!(flags.iter().map(|flag| flag.as_str().unwrap()).eq(RUSTFLAGS));
    }
}
