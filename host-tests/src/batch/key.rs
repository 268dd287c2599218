//! Hash of all that a result depends on: the recording's bytes, the configuration's, the options and the
//! program itself.

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
    sync::OnceLock,
};

use sha2::{Digest, Sha256};

use super::options::Options;

/// Hash of a recording and all that its result depends on, 32 hexadecimal digits.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(String);

impl Key {
    /// The key of a recording's content.
    ///
    /// # Errors
    /// The recording or the configuration cannot be read.
    pub fn of(path: &Path, options: &Options) -> io::Result<Self> {
        Self::by(program(), path, options)
    }

    /// The key of a recording's content that another program flies, which is known by a hash.
    ///
    /// # Errors
    /// The recording or the configuration cannot be read.
    pub fn by(program: &[u8], path: &Path, options: &Options) -> io::Result<Self> {
        let mut hash = Sha256::new();
        hash.update(program);
        hash.update(options.told());
        if let Some(config) = &options.config {
            add(&mut hash, config)?;
        }
        hash.update(b"trace");
        add(&mut hash, path)?;
        Ok(Self::from(hash))
    }

    /// The key of a recording that cannot be read.
    #[must_use]
    pub fn of_path(path: &Path) -> Self {
        Self::from(Sha256::new_with_prefix(path.to_string_lossy().as_bytes()))
    }

    /// The hash of a file's bytes alone, whatever flies it; `None` if it cannot be read.
    #[must_use]
    pub fn of_bytes(path: &Path) -> Option<Self> {
        let mut hash = Sha256::new();
        add(&mut hash, path).ok()?;
        Some(Self::from(hash))
    }

    fn from(hash: Sha256) -> Self {
        Self(hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect())
    }

    /// A key that was told as text.
    #[must_use]
    pub const fn told(text: String) -> Self {
        Self(text)
    }

    /// As text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Name of a file of a recording's own: recordings of one name in two folders differ in their keys.
    #[must_use]
    pub fn file(&self, path: &Path, ending: &str) -> String {
        format!("{}.{}.{ending}", testbed::trace::recordings::name(path), &self.0[..8])
    }
}

/// Hash of the program's own file: another build may fly otherwise. Its version where the file is not there.
#[must_use]
pub fn program() -> &'static [u8] {
    static PROGRAM: OnceLock<Vec<u8>> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let mut hash = Sha256::new_with_prefix(env!("CARGO_PKG_VERSION"));
        if let Ok(file) = std::env::current_exe() {
            let _ = add(&mut hash, &file);
        }
        hash.finalize().to_vec()
    })
}

fn add(hash: &mut Sha256, path: &Path) -> io::Result<()> {
    let mut file = File::open(path)?;
    let mut buffer = vec![0; 1 << 16];
    loop {
        let count = file.read(&mut buffer)?;
        if count == 0 {
            return Ok(());
        }
        hash.update(&buffer[..count]);
    }
}
