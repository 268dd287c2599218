//! Boot file of a run, `boot.bin`, in postcard's encoding.

use meerkat_mwd::{
    application::{Settings, Stage, apply_factory_records},
    emulation::Recording,
    storage::FactoryRecords,
};
use semihosting::{fs::File, io::Read};

/// Room for the file, bytes: more than the encoding ever takes.
const LONGEST: usize = 1024;

pub struct Boot {
    pub settings: Settings,
    /// Playback of the sensors' file.
    pub sensors: Recording,
    /// Hang to simulate.
    pub hang: Option<Hang>,
    /// Words programmed and sectors erased before the power is cut.
    pub power_cut_after: Option<u32>,
}

/// A stage that does not come to its end, from a sample on.
#[derive(Clone, Copy)]
pub struct Hang {
    pub stage: Stage,
    pub at_sample: u32,
}

impl Boot {
    pub fn read() -> Result<Self, &'static str> {
        let mut bytes = [0; LONGEST];
        let mut file = File::open(c"boot.bin").map_err(|_| "boot.bin cannot be opened")?;
        let mut used = 0;
        loop {
            let room = bytes.get_mut(used..).unwrap_or_default();
            match file.read(room).map_err(|_| "boot.bin cannot be read")? {
                0 => break,
                read => used += read,
            }
        }
        let bytes = bytes.get(..used).unwrap_or_default();
        let (config, stream, recording, key, sensors, hang, power_cut_after): (_, _, _, _, _, Option<(u8, u32)>, _) =
            postcard::from_bytes(bytes).map_err(|_| "boot.bin does not hold a configuration and what to do with it")?;
        let hang = match hang {
            None => None,
            Some((number, at_sample)) => {
                let stages = [Stage::Acquisition, Stage::Samples, Stage::Work, Stage::Telemetry];
                let stage = *stages.get(usize::from(number)).ok_or("boot.bin names a stage that there is not")?;
                Some(Hang { stage, at_sample })
            }
        };
        let settings = Settings { config, stream, recording, key };
        Ok(Self { settings, sensors, hang, power_cut_after })
    }

    /// Replaces the file's settings by the factory's records, where there are any.
    pub fn provisioned(&mut self, records: &FactoryRecords) {
        let Settings { config, key, .. } = &mut self.settings;
        apply_factory_records(records, config);
        *key = records.key.or(*key);
    }
}
