//! A recorded or simulated trace. (Provisional copy of the shared type.)
#![allow(missing_docs)]
use std::io::{BufRead, Write};
use std::path::{Path, PathBuf};

use meerkat_mwd::{Sample, SampleFlags};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EarthFrame {
    #[default]
    Ned,
    Enu,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BodyFrame {
    Tool,
    #[default]
    Sensor,
}

#[derive(Clone, Debug, Default)]
pub struct Keys {
    pub earth_frame: EarthFrame,
    pub body_frame: BodyFrame,
    pub magnetic_declination_deg: Option<f64>,
    pub gravity_m_s2: Option<f64>,
    pub magnetic_field_ut: Option<f64>,
    pub dip_deg: Option<f64>,
    pub latitude_deg: Option<f64>,
    pub gyro_full_scale_rad_s: Option<f64>,
    pub accel_full_scale_m_s2: Option<f64>,
    pub mag_full_scale_ut: Option<f64>,
    pub reference_north: bool,
    pub source: Option<String>,
    pub licence: Option<String>,
}

#[derive(Clone, Debug, Default)]
pub struct Trace {
    pub path: PathBuf,
    pub keys: Keys,
    pub samples: Vec<Sample>,
    pub reference: Vec<Option<[f64; 4]>>,
    pub movement: Option<Vec<bool>>,
    pub rest: Option<Vec<bool>>,
    pub true_rate: Option<Vec<[f64; 3]>>,
    pub notes: Vec<String>,
}

#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    #[error("{0}")]
    Io(#[from] std::io::Error),
}

impl Trace {
    pub fn nominal_period_us(&self) -> u32 {
        let mut steps: Vec<u64> = self.samples.windows(2).map(|w| w[1].t_us - w[0].t_us).collect();
        steps.sort_unstable();
        steps.get(steps.len() / 2).map_or(0, |&s| s as u32)
    }

    pub fn duration_s(&self) -> f64 {
        match (self.samples.first(), self.samples.last()) {
            (Some(a), Some(b)) => (b.t_us - a.t_us) as f64 * 1e-6,
            _ => 0.0,
        }
    }

    pub fn read(path: &Path) -> Result<Trace, TraceError> {
        let file = std::io::BufReader::new(flate2::read::GzDecoder::new(std::fs::File::open(path)?));
        let mut trace = Trace { path: path.to_path_buf(), ..Trace::default() };
        let mut header: Vec<String> = Vec::new();
        let (mut movement, mut rest) = (Vec::new(), Vec::new());
        for line in file.lines() {
            let line = line?;
            if line.starts_with('#') {
                if line.contains("ENU") {
                    trace.keys.earth_frame = EarthFrame::Enu;
                }
                continue;
            }
            if header.is_empty() {
                header = line.split(',').map(str::to_owned).collect();
                continue;
            }
            let cells: Vec<Option<f64>> = line.split(',').map(|c| c.parse().ok()).collect();
            let cell = |name: &str| header.iter().position(|h| h == name).and_then(|i| cells.get(i).copied().flatten());
            let vector = |names: [&str; 3]| {
                let [a, b, c] = names.map(cell);
                a.zip(b).zip(c).map(|((a, b), c)| [a as f32, b as f32, c as f32])
            };
            let mut sample = Sample {
                t_us: (cell("t_s").unwrap_or(0.0) * 1e6).round() as u64,
                flags: SampleFlags::TEMPERATURE_MISSING,
                ..Sample::default()
            };
            match vector(["gx", "gy", "gz"]) {
                Some(v) => sample.gyro_rad_s = v,
                None => sample.flags |= SampleFlags::GYRO_MISSING,
            }
            match vector(["ax", "ay", "az"]) {
                Some(v) => sample.accel_m_s2 = v,
                None => sample.flags |= SampleFlags::ACCEL_MISSING,
            }
            match vector(["mx", "my", "mz"]) {
                Some(v) => sample.mag_ut = v,
                None => sample.flags |= SampleFlags::MAG_MISSING,
            }
            trace.samples.push(sample);
            let q = ["qw", "qx", "qy", "qz"].map(cell);
            trace.reference.push(match q {
                [Some(w), Some(x), Some(y), Some(z)] => Some([w, x, y, z]),
                _ => None,
            });
            movement.push(cell("movement") == Some(1.0));
            rest.push(cell("rest") == Some(1.0));
        }
        if header.iter().any(|h| h == "movement") {
            trace.movement = Some(movement);
        }
        if header.iter().any(|h| h == "rest") {
            trace.rest = Some(rest);
        }
        Ok(trace)
    }

    pub fn write(&self, path: &Path) -> Result<(), TraceError> {
        let mut out = flate2::write::GzEncoder::new(std::fs::File::create(path)?, flate2::Compression::default());
        writeln!(out, "t_s,gx,gy,gz,ax,ay,az,mx,my,mz,qw,qx,qy,qz,wx_true,wy_true,wz_true")?;
        for (i, s) in self.samples.iter().enumerate() {
            write!(out, "{:.6}", s.t_us as f64 * 1e-6)?;
            for v in s.gyro_rad_s.iter().chain(&s.accel_m_s2).chain(&s.mag_ut) {
                write!(out, ",{v}")?;
            }
            match self.reference.get(i).copied().flatten() {
                Some(q) => q.iter().try_for_each(|v| write!(out, ",{v:.9}"))?,
                None => write!(out, ",,,,")?,
            }
            match self.true_rate.as_ref().and_then(|t| t.get(i)) {
                Some(w) => w.iter().try_for_each(|v| write!(out, ",{v:.9}"))?,
                None => write!(out, ",,,")?,
            }
            writeln!(out)?;
        }
        out.finish()?;
        Ok(())
    }
}
