//! No board: the pipeline's calls and nothing around them. Whatever panic could be reached from them would be linked
//! into this image, so a test can look for one; it is never run.

use core::{hint::black_box, panic::PanicInfo};
use cortex_m_rt::entry;
use meerkat_mwd::{
    Config, Probe, Sample,
    config::{ConfigError, Earth, SurveyConfig},
    identification::WindowReport,
    probe::Output,
    survey::{Survey, SurveyInput, SurveyNews, Surveyor},
};

#[entry]
fn main() -> ! {
    static mut PROBE: Probe = Probe::new();
    static mut SURVEYOR: Surveyor = Surveyor::new();
    // Opaque to the compiler: it must expect any configuration and any sample.
    let _ = black_box(configure_probe(PROBE, &black_box(Config::default())));
    let _ = black_box(configure_surveyor(SURVEYOR, &black_box(SurveyConfig::default())));
    loop {
        black_box(push_sample(PROBE, &black_box(Sample::default())));
        black_box(poll_probe(PROBE));
        black_box(push_survey(SURVEYOR, &black_box(SurveyInput::default())));
        black_box(continuous_survey(SURVEYOR));
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

#[inline(never)]
fn configure_surveyor(surveyor: &mut Surveyor, config: &SurveyConfig) -> Result<(), ConfigError> {
    surveyor.configure(&black_box(Earth::default()), config)
}

#[inline(never)]
fn push_survey(surveyor: &mut Surveyor, input: &SurveyInput) -> SurveyNews {
    black_box(surveyor.stationary());
    black_box(surveyor.rotating());
    black_box(surveyor.dynamics());
    surveyor.push(input)
}

#[inline(never)]
fn continuous_survey(surveyor: &Surveyor) -> Option<Survey> {
    surveyor.continuous()
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}
