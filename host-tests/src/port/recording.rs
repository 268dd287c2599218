//! Raw samples that a probe sends, collected to a trace.

use std::{
    fs, mem,
    path::{Path, PathBuf},
};

use chrono::NaiveDate;
use meerkat_mwd::{
    Config, Sample, SampleFlags,
    config::FullScale,
    telemetry::{Boot, CommandRefusal, LinkCounters, Message, Outcome, RawSample},
};

use testbed::{
    failure::Failure,
    trace::{BodyFrame, Keys, Trace, seconds},
};

/// Step of the probe's clock from one report of health to the next, back, that only a start of the program explains,
/// microseconds. Reports come every 5 s; late ones on a slow line keep their order.
const MOST_BACK_US: u64 = 10_000_000;

/// Raw samples of one run of a probe, with its configuration.
#[derive(Debug, Default)]
pub struct Recording {
    /// Report of the start that applies to the samples.
    boot: Option<Boot>,
    /// Number of the first sample that was flown with another configuration.
    ends_before: Option<u32>,
    samples: Vec<Sample>,
    first_number: u32,
    next_number: u32,
    lost: u64,
    /// Samples whose time did not increase: the pipeline refuses them, and a trace cannot hold them.
    out_of_order: u64,
    /// Samples with a reading that is no number or beyond any sensor, which a trace cannot hold either.
    not_readings: u64,
    restarted: bool,
    /// Time of the latest report of health, microseconds.
    health_us: u64,
    refused: Option<CommandRefusal>,
    /// Day of the recording; nobody knows that of captured bytes.
    pub date: Option<NaiveDate>,
    /// Number of frames of another version.
    pub not_understood: u64,
    /// Counters of the decoder.
    pub link: LinkCounters,
}

/// Progress of a recording: whether anything more belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// More may come.
    Goes,
    /// The probe has started afresh: the recording is complete.
    Over,
}

impl Recording {
    /// Takes the next message.
    pub fn take(&mut self, message: Message) -> Progress {
        match message {
            Message::Boot(boot) => return self.take_boot(boot),
            Message::Sample(RawSample { number, sample }) => return self.take_sample(number, sample),
            Message::Health(health) => {
                let before_us = mem::replace(&mut self.health_us, health.t_us);
                return self.goes_unless(before_us.saturating_sub(health.t_us) > MOST_BACK_US);
            }
            Message::Acknowledgement(answer) => {
                if let Outcome::Refused(reason) = answer.outcome {
                    self.refused = Some(reason);
                }
            }
            _ => {}
        }
        Progress::Goes
    }

    /// Samples may still arrive after the report of a pipeline's start that follows them, none after that of a
    /// program's. The report that opens a recording is no restart.
    fn take_boot(&mut self, boot: Boot) -> Progress {
        if self.samples.is_empty() {
            self.boot = Some(boot);
            return Progress::Goes;
        }
        let Some(before) = &self.boot else { return Progress::Goes };
        let run = |boot: &Boot| (boot.probe, boot.reset, boot.watchdog_resets);
        if run(&boot) != run(before) || boot.first_sample < before.first_sample {
            return self.goes_unless(true);
        }
        if boot.first_sample > before.first_sample {
            self.ends_before = Some(boot.first_sample);
        }
        Progress::Goes
    }

    /// Ends a recording that has begun if the probe has started afresh.
    const fn goes_unless(&mut self, restarted: bool) -> Progress {
        if restarted && !self.samples.is_empty() {
            self.restarted = true;
            return Progress::Over;
        }
        Progress::Goes
    }

    fn take_sample(&mut self, number: u32, sample: Sample) -> Progress {
        if self.samples.is_empty() {
            self.first_number = number;
        } else if number < self.next_number || self.ends_before.is_some_and(|first| number >= first) {
            return self.goes_unless(true);
        } else {
            self.lost += u64::from(number - self.next_number);
        }
        self.next_number = number.saturating_add(1);
        if self.samples.last().is_some_and(|last| sample.t_us <= last.t_us) {
            self.out_of_order += 1;
        } else {
            let clean = sample.sanitised();
            self.not_readings += u64::from(clean.flags != sample.flags);
            self.samples.push(clean);
        }
        Progress::Goes
    }

    /// Returns true if no sample came.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Frames received, damaged and lost, in one line.
    #[must_use]
    pub fn link_line(&self) -> String {
        let LinkCounters { frames, bad, oversize, lost, .. } = self.link;
        let unknown = self.not_understood;
        let asked = self.refused.as_ref().map_or_else(String::new, |why| format!("; the probe refused: {why}"));
        format!(
            "{frames} frames, {bad} damaged, {oversize} oversize, {lost} missing in the sequence, {unknown} of another version{asked}"
        )
    }

    /// The trace; its header holds what the format has of the configuration.
    #[must_use]
    pub fn trace(&self) -> Trace {
        let config = self.boot.as_ref().map(|boot| &boot.config);
        let said =
            SampleFlags::FAULT | SampleFlags::GYRO_CLIPPED | SampleFlags::ACCEL_CLIPPED | SampleFlags::MAG_CLIPPED;
        let flags: Vec<SampleFlags> = self.samples.iter().map(|sample| sample.flags & said).collect();
        Trace {
            keys: Keys {
                date: self.date,
                ..config.map_or_else(Keys::default, |config| keys(config, self.boot.as_ref()))
            },
            samples: self.samples.clone(),
            driver_flags: flags.iter().any(|flags| !flags.is_empty()).then_some(flags),
            ..Trace::default()
        }
    }

    /// Writes the trace and the configuration beside it. Returns lines for the user: what was written, and
    /// how to replay it.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<Vec<String>> {
        let trace = self.trace();
        trace.write(path)?;
        let span = format!("{} to {} s", seconds(trace.first_us()), seconds(trace.first_us() + trace.duration_us()));
        let mut lines = vec![format!("{} samples, {span}, in {}", trace.samples.len(), path.display())];
        match &self.boot {
            Some(boot) => {
                let beside = beside(path);
                let text = toml::to_string(&boot.config)
                    .map_err(|e| Failure::BadInput(format!("the probe's configuration cannot be written: {e}")))?;
                fs::write(&beside, text).map_err(|e| Failure::output(&beside, &e))?;
                lines.push(format!("configuration in {}", beside.display()));
                let mut replay = format!("replay: cargo mwd replay {} --config {}", path.display(), beside.display());
                if let Some(model) = &boot.flies {
                    let beside = model_beside(path);
                    let text = toml::to_string(model)
                        .map_err(|e| Failure::BadInput(format!("the stored model cannot be written: {e}")))?;
                    fs::write(&beside, text).map_err(|e| Failure::output(&beside, &e))?;
                    lines.push(format!("stored model in {}", beside.display()));
                    replay.push_str(&format!(" --model {}", beside.display()));
                }
                lines.push(replay);
            }
            None => {
                lines.push("note: no configuration came, so a replay may differ from what the probe computed".into())
            }
        }
        let mut note = |condition: bool, text: String| {
            if condition {
                lines.push(format!("note: {text}"));
            }
        };
        let first = self.first_number;
        let since = self.boot.as_ref().map_or(0, |boot| boot.first_sample);
        note(first != since, format!("it begins with sample {first} of the run: a replay starts from another state"));
        if let Some(motion_s) = self.boot.as_ref().and_then(|boot| boot.goes_on_after_s) {
            let text =
                format!("its filter went on after {motion_s:.0} s of motion, which a replay does not know: it differs");
            note(true, text);
        }
        note(self.lost > 0, format!("{} samples were lost on the way: a replay differs from there on", self.lost));
        note(self.out_of_order > 0, format!("{} samples whose time did not increase are left out", self.out_of_order));
        let text = format!(
            "readings of {} samples are no numbers or beyond any sensor, and count as missing",
            self.not_readings
        );
        note(self.not_readings > 0, text);
        note(self.restarted, "the probe started afresh, and the recording ends there".into());
        lines.push(self.link_line());
        Ok(lines)
    }
}

/// Path of the configuration's file.
#[must_use]
pub fn beside(trace: &Path) -> PathBuf {
    PathBuf::from(format!("{}.toml", stem(trace)))
}

/// Path of the stored model's file.
#[must_use]
pub fn model_beside(trace: &Path) -> PathBuf {
    PathBuf::from(format!("{}.model.toml", stem(trace)))
}

fn stem(trace: &Path) -> String {
    let name = trace.to_string_lossy();
    let stem = name.strip_suffix(".gz").unwrap_or(&name);
    stem.strip_suffix(".csv").unwrap_or(stem).to_owned()
}

fn keys(config: &Config, boot: Option<&Boot>) -> Keys {
    let degrees = |radians: Option<f32>| radians.map(|x| f64::from(x).to_degrees());
    let wide = |x: Option<f32>| x.map(f64::from);
    let FullScale { gyro_rad_s, accel_m_s2, mag_ut } = config.full_scale;
    let earth = &config.earth;
    Keys {
        body_frame: BodyFrame::Tool,
        magnetic_declination_deg: degrees(earth.declination_rad),
        gravity_m_s2: Some(earth.gravity_m_s2.into()),
        magnetic_field_ut: wide(earth.magnetic_field_ut),
        dip_deg: degrees(earth.dip_rad),
        latitude_deg: degrees(earth.latitude_rad),
        gyro_full_scale_rad_s: wide(gyro_rad_s),
        accel_full_scale_m_s2: wide(accel_m_s2),
        mag_full_scale_ut: wide(mag_ut),
        motion: Some(config.identification.motion),
        serial: boot.map(|boot| boot.probe.to_string()),
        source: boot.map(|boot| {
            let [major, minor, patch] = boot.version;
            format!("recorded from a probe, firmware {major}.{minor}.{patch}")
        }),
        ..Keys::default()
    }
}
