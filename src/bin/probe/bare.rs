//! No board: the pipeline's calls and nothing around them. Whatever panic could be reached from them would be linked into
//! this image, so a test can look for one; it is never run.

use core::{hint::black_box, panic::PanicInfo};
use cortex_m_rt::entry;
use meerkat_mwd::{Config, Probe, Sample, config::ConfigError, identification::WindowReport, probe::Output};

#[entry]
fn main() -> ! {
    static mut PROBE: Probe = Probe::new();
    // Opaque to the compiler: it must expect any configuration and any sample.
    let _ = black_box(configure_probe(PROBE, &black_box(Config::default())));
    loop {
        black_box(push_sample(PROBE, &black_box(Sample::default())));
        black_box(poll_probe(PROBE));
    }
}

#[inline(never)]
fn configure_probe(probe: &mut Probe, config: &Config) -> Result<(), ConfigError> {
    probe.configure(config)
}

#[inline(never)]
fn push_sample(probe: &mut Probe, sample: &Sample) -> Option<Output> {
    probe.push(sample)
}

#[inline(never)]
fn poll_probe(probe: &mut Probe) -> Option<WindowReport> {
    probe.poll(black_box(probe.poll_budget()))
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}
