//! The models that outlive the power: one restored at the start, one stored when it is stable.

use core::mem::MaybeUninit;
use embedded_storage::nor_flash::NorFlash;
#[cfg(feature = "spi-sensors")]
use embedded_storage::nor_flash::ReadNorFlash;
#[cfg(feature = "spi-sensors")]
use meerkat_mwd::storage::FactoryRecords;
use meerkat_mwd::{
    Config, Probe, Sample, SampleFlags,
    compensation::{GyroModel, effects::LIBRARY},
    identification::{Decision, Refusal, WindowReport},
    storage::{
        Limits, ModelStore, NotDrilling, Outcome, Preparation, Progress, StabilityGate, StorageError, StoredModel,
    },
    telemetry::CounterStore,
};

/// Sectors of the ring.
const SECTORS: usize = 3;

/// Calls of [`ModelStore::prepare`] after which a flash that never is ready is left alone.
const MOST_PREPARATIONS: u8 = 16;

/// The ring of sectors, and what is on its way into it.
pub struct Memory<F> {
    store: ModelStore<F, SECTORS>,
    gate: StabilityGate,
    /// What is being written.
    writing: Option<StoredModel>,
    restored: Option<u32>,
}

impl<F: NorFlash> Memory<F> {
    /// Reads the ring. Nothing is written.
    ///
    /// # Errors
    /// A flash that cannot be used; the probe then flies without.
    fn open(flash: F, config: &Config) -> Result<Self, StorageError<F::Error>> {
        let store = ModelStore::open(flash, Limits::new(config, &LIBRARY))?;
        Ok(Self { store, gate: StabilityGate::new(&config.gyro, None), writing: None, restored: None })
    }

    /// Opens the ring and makes it ready, in the RAM that is kept for it. Before the first sample: it may have to erase.
    #[inline(never)]
    pub fn start(
        place: &'static mut MaybeUninit<Self>,
        flash: F,
        config: &Config,
        feed: impl FnMut(),
    ) -> Option<&'static mut Self> {
        // A flash that fails is no reason not to fly; the boot's report then names no model, and health counts the failures.
        let memory = place.write(Self::open(flash, config).ok()?);
        let _ = memory.prepare(NotDrilling::PowerUp, feed);
        Some(memory)
    }

    /// Erases what has to be, one sector between two calls of `feed`.
    fn prepare(&mut self, why: NotDrilling, mut feed: impl FnMut()) -> Result<(), StorageError<F::Error>> {
        for _ in 0..MOST_PREPARATIONS {
            feed();
            if let Preparation::Ready { .. } = self.store.prepare(why)? {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Flies the stored model whose temperature is nearest to that of the first sample, which is not pushed yet.
    pub fn restore(&mut self, probe: &mut Probe, first: &Sample) {
        let warm = !first.flags.intersects(SampleFlags::TEMPERATURE_MISSING | SampleFlags::FAULT);
        let Ok(restoration) = self.store.restore(warm.then_some(first.temperature_c)) else { return };
        if let Outcome::Chosen { model, number, .. } = restoration.outcome
            && probe.restore(&model).is_ok()
        {
            self.gate = StabilityGate::new(&probe.config().gyro, Some(&model));
            self.restored = Some(number);
        }
    }

    /// The number of the model that flew from the start.
    pub const fn restored(&self) -> Option<u32> {
        self.restored
    }

    pub fn sample(&mut self, sample: &Sample) {
        self.gate.sample(sample);
    }

    /// Begins to store the model that flies, where this window makes it worth it.
    #[inline(never)]
    pub fn window(&mut self, probe: &Probe, report: &WindowReport) {
        if let Decision::Refused(Refusal::RolledBack { .. }) = report.decision {
            // What fails is counted; a stored model that no longer holds is rolled back after every start.
            let _ = self.retire(&probe.config().gyro);
            return;
        }
        let Some(model) = probe.model_worth_storing(report, &mut self.gate) else { return };
        // What is refused, or cannot begin, the store counts.
        if self.store.begin_model(&model).is_ok() {
            self.writing = Some(model);
        }
    }

    /// Programs the next piece. What fails is counted, and the next window offers the model again.
    #[inline(never)]
    pub fn step(&mut self) {
        if !self.store.is_writing() {
            return;
        }
        match self.store.step() {
            Ok(Progress::Stored { .. }) => {
                if let Some(model) = self.writing.take() {
                    self.gate.stored(&model);
                }
            }
            Ok(_) => {}
            Err(_) => self.writing = None,
        }
    }

    /// No model that is stored is restored any more; the next stable one is stored as the first.
    pub fn retire(&mut self, factory: &GyroModel) -> Result<(), StorageError<F::Error>> {
        self.gate = StabilityGate::new(factory, None);
        self.store.retire_models().map(drop)
    }

    /// The same, and what they took is erased.
    pub fn erase(&mut self, factory: &GyroModel, feed: impl FnMut()) -> Result<(), StorageError<F::Error>> {
        self.retire(factory)?;
        self.prepare(NotDrilling::Command, feed)
    }

    /// Models stored, and models and counters that could not be.
    pub const fn stored_and_failed(&self) -> [u32; 2] {
        let counts = self.store.counts();
        let refused = counts.refused_full.saturating_add(counts.refused_implausible);
        [counts.stored, counts.failed.saturating_add(refused)]
    }
}

impl<F: NorFlash> CounterStore for Memory<F> {
    type Error = StorageError<F::Error>;

    fn read(&mut self) -> Result<u64, Self::Error> {
        Ok(self.store.read_counter())
    }

    fn store(&mut self, counter: u64) -> Result<(), Self::Error> {
        self.store.store_counter(counter)
    }
}

/// What the factory wrote; nothing, where it cannot be read.
#[cfg(feature = "spi-sensors")]
pub fn factory_records<R: ReadNorFlash>(region: &mut R) -> FactoryRecords {
    FactoryRecords::read(region).unwrap_or_default()
}

/// The factory's calibration, or the default without.
#[cfg(feature = "spi-sensors")]
pub fn factory_config(records: &FactoryRecords) -> Config {
    match &records.calibration {
        Some(calibration) => {
            Config { gyro: calibration.gyro, accel: calibration.accel, mag: calibration.mag, ..Config::default() }
        }
        None => Config::default(),
    }
}
