//! The tier `identify` as an image. On a desk this is an empty program.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use meerkat_mwd::probe::AttitudeProbe;
    use static_cell::ConstStaticCell;
    use tiers::Small;

    static PROBE: ConstStaticCell<AttitudeProbe> = ConstStaticCell::new(AttitudeProbe::new());
    static ESTIMATOR: ConstStaticCell<Small> = ConstStaticCell::new(Small::zero());

    // SAFETY: the name is nobody else's, and `reset` calls it once.
    #[allow(unsafe_code)]
    #[unsafe(no_mangle)]
    extern "C" fn tier() -> ! {
        tiers::run(&mut tiers::Identify::new(PROBE.take(), ESTIMATOR.take()))
    }
}

#[cfg(not(target_os = "none"))]
fn main() {}
