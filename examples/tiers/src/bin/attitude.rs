//! The tier `attitude` as an image. On a desk this is an empty program.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use meerkat_mwd::{probe::AttitudeProbe, survey::Surveys};
    use static_cell::{ConstStaticCell, StaticCell};

    static PROBE: ConstStaticCell<AttitudeProbe> = ConstStaticCell::new(AttitudeProbe::new());
    /// Written at the start: as a constant it would take its size in flash, too.
    static SURVEYS: StaticCell<Surveys> = StaticCell::new();

    // SAFETY: the name is nobody else's, and `reset` calls it once.
    #[allow(unsafe_code)]
    #[unsafe(no_mangle)]
    extern "C" fn tier() -> ! {
        tiers::run(&mut tiers::Attitude::new(PROBE.take(), SURVEYS.init_with(Surveys::new)))
    }
}

#[cfg(not(target_os = "none"))]
fn main() {}
