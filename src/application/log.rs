//! Log of the application: by defmt on a chip, nothing elsewhere.

#[cfg(all(feature = "defmt", target_os = "none"))]
pub(super) use defmt::{error, info, warn};

#[cfg(not(all(feature = "defmt", target_os = "none")))]
macro_rules! log {
    ($text:literal $(, $value:expr)*) => {{
        $(let _ = &$value;)*
    }};
}
#[cfg(not(all(feature = "defmt", target_os = "none")))]
pub(super) use {log as error, log as info, log as warn};
