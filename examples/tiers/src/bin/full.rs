//! The tier `full` as an image. On a desk this is an empty program.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use meerkat_mwd::survey::Surveyor;
    use static_cell::{ConstStaticCell, StaticCell};
    use tiers::FullProbe;

    static PROBE: ConstStaticCell<FullProbe> = ConstStaticCell::new(FullProbe::zero());
    /// Written at the start: as a constant it would take its size in flash, too.
    static SURVEYOR: StaticCell<Surveyor> = StaticCell::new();

    // SAFETY: the name is nobody else's, and `reset` calls it once.
    #[allow(unsafe_code)]
    #[unsafe(no_mangle)]
    extern "C" fn tier() -> ! {
        tiers::run(&mut tiers::Full::new(PROBE.take(), SURVEYOR.init_with(Surveyor::new)))
    }
}

#[cfg(not(target_os = "none"))]
fn main() {}
