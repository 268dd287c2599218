//! A full multi-station analysis as an image. On a desk this is an empty program.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use meerkat_mwd::survey::multi_station::MultiStation;
    use static_cell::ConstStaticCell;

    static STATIONS: ConstStaticCell<MultiStation> = ConstStaticCell::new(MultiStation::new());

    // SAFETY: the name is nobody else's, and `reset` calls it once.
    #[allow(unsafe_code)]
    #[unsafe(no_mangle)]
    extern "C" fn tier() -> ! {
        tiers::run_stations(STATIONS.take())
    }
}

#[cfg(not(target_os = "none"))]
fn main() {}
