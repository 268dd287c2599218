//! The tier `attitude` as an image. On a desk this is an empty program.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use meerkat_mwd::{probe::AttitudeProbe, survey::Surveyor};
    use static_cell::ConstStaticCell;

    static PROBE: ConstStaticCell<AttitudeProbe> = ConstStaticCell::new(AttitudeProbe::new());
    static SURVEYOR: ConstStaticCell<Surveyor> = ConstStaticCell::new(Surveyor::new());

    // SAFETY: the name is nobody else's, and `reset` calls it once.
    #[allow(unsafe_code)]
    #[unsafe(no_mangle)]
    extern "C" fn tier() -> ! {
        tiers::run(&mut tiers::Attitude::new(PROBE.take(), SURVEYOR.take()))
    }
}

#[cfg(not(target_os = "none"))]
fn main() {}
