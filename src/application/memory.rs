//! Stored models, which outlive the power: one is restored at the start, one is stored when it is stable.

use super::log::{error, info, warn};
use crate::{
    Config, Probe, Sample, SampleFlags,
    compensation::effects::LIBRARY,
    identification::WindowReport,
    storage::{
        LearntProgress, Limits, ModelHistory, ModelStore, NotDrilling, Outcome, Preparation, Progress, StabilityGate,
        StorageError, StoreReason, StoredCommand, StoredModel, fingerprint,
    },
    survey::VibrationDose,
    telemetry::{Command, CommandRefusal, CounterStore},
};
use core::mem::MaybeUninit;
use embedded_storage::nor_flash::NorFlash;

/// Sectors of the ring in flash.
const SECTORS: usize = 3;

/// Calls of [`ModelStore::prepare`] after which a flash that is still not ready is told to be full.
const MOST_PREPARATIONS: u8 = 16;

/// The ring of sectors in flash, and the model on its way into it.
pub struct Memory<F> {
    store: ModelStore<F, SECTORS>,
    gate: StabilityGate,
    history: ModelHistory,
    restored: Option<u32>,
    /// Seconds of motion that the estimator had learnt from when it was stored, if it goes on from there.
    goes_on_after_s: Option<f32>,
    /// Reason of the model that is to be stored once the estimator's learnt state is written.
    reason: Option<StoreReason>,
    /// True if a command's counter found no room.
    lacks_room: bool,
}

impl<F: NorFlash> Memory<F> {
    /// Reads the ring. Nothing is written.
    ///
    /// # Errors
    /// The flash cannot be used; the probe then flies without stored models.
    fn open(flash: F, config: &Config) -> Result<Self, StorageError<F::Error>> {
        let store = ModelStore::open(flash, Limits::new(config, &LIBRARY))?;
        let (gate, history) = afresh(config);
        Ok(Self { store, gate, history, restored: None, goes_on_after_s: None, reason: None, lacks_room: false })
    }

    /// Opens the ring and makes it ready, in the RAM of `place`. Call it before the first sample: it may have to
    /// erase.
    ///
    /// # Errors
    /// The flash cannot be read, or has fewer than three sectors: the probe then flies without stored models.
    #[inline(never)]
    pub fn start<'a>(
        place: &'a mut MaybeUninit<Self>,
        flash: F,
        config: &Config,
        mut feed: impl FnMut(),
    ) -> Result<&'a mut Self, StorageError<F::Error>> {
        // A flash that fails is no reason not to fly; the boot's report then names no model, and health counts the
        // failures.
        let memory = place.write(Self::open(flash, config)?);
        // Models that may fly with the configuration to come are kept.
        memory.apply_commands(&mut { *config });
        let _ = memory.prepare(NotDrilling::PowerUp, &mut feed);
        Ok(memory)
    }

    /// Erases the sectors that have to be, at most one page between two calls of `feed`.
    #[inline(never)]
    pub(super) fn prepare(&mut self, why: NotDrilling, feed: &mut dyn FnMut()) -> Result<(), StorageError<F::Error>> {
        for _ in 0..MOST_PREPARATIONS {
            feed();
            if let Preparation::Ready { .. } = self.store.prepare(why)? {
                return Ok(());
            }
        }
        Err(StorageError::Full)
    }

    /// Returns true, once, if a command whose code was right found no room for its counter.
    pub(super) const fn takes_lack_of_room(&mut self) -> bool {
        core::mem::replace(&mut self.lacks_room, false)
    }

    /// Flies the stored model whose temperature is nearest to that of the first sample, which is not pushed yet.
    pub(super) fn restore(&mut self, probe: &mut Probe, first: &Sample) {
        let warm = !first.flags.intersects(SampleFlags::TEMPERATURE_MISSING | SampleFlags::FAULT);
        let Ok(restoration) = self.store.restore(warm.then_some(first.temperature_c)) else { return };
        if let Outcome::Chosen { model, number, .. } = restoration.outcome
            && probe.restore(&model).is_ok()
        {
            self.flown(probe, &model, number, None);
            self.go_on(probe, number);
        }
    }

    /// Has the estimator go on from the learnt state that was stored with model `number`, if there is one.
    #[inline(never)]
    fn go_on(&mut self, probe: &mut Probe, number: u32) {
        let Ok(Some(head)) = self.store.learnt_with(number) else { return };
        let read = |take: &mut dyn FnMut(usize, f32)| matches!(self.store.read_learnt(number, take), Ok(true));
        match probe.go_on(&head, read) {
            Ok(()) => {
                self.goes_on_after_s = Some(head.motion_s);
                info!("the filter goes on after {=f32} s of motion", head.motion_s);
            }
            Err(why) => warn!("the filter starts afresh: {}", why),
        }
    }

    /// Notes that a stored model flies from now on.
    fn flown(&mut self, probe: &Probe, model: &StoredModel, number: u32, previous: Option<StoredModel>) {
        self.gate = StabilityGate::new(&probe.config().gyro, Some(model));
        self.history = ModelHistory::new(model, fingerprint(&LIBRARY, probe.config()), previous);
        (self.restored, self.goes_on_after_s, self.reason) = (Some(number), None, None);
    }

    /// Notes that the factory's model of a new configuration flies from now on.
    pub(super) fn configured(&mut self, config: &Config) {
        self.store.set_limits(&Limits::new(config, &LIBRARY));
        (self.gate, self.history) = afresh(config);
        (self.restored, self.goes_on_after_s, self.reason) = (None, None, None);
    }

    /// Stores the latest window's model, if that window ended at `window_end_us`, and flies it. Returns true if it
    /// did not fly before.
    #[inline(never)]
    pub(super) fn accept(&mut self, probe: &mut Probe, window_end_us: u64) -> Result<bool, CommandRefusal> {
        let effects = probe.effects();
        let model = self.history.proposed(window_end_us, effects).ok_or(CommandRefusal::NothingThere)?;
        let flying = self.history.flying(probe.gyro_model(), effects);
        let is_new = model.gyro.p != flying.gyro.p;
        let number = self.keep(probe, &model)?;
        if is_new {
            self.fly(probe, &model, number, Some(flying))?;
        } else {
            self.gate.stored(&model);
        }
        Ok(is_new)
    }

    /// Goes back to the model before the flown one. It is stored anew before all others are retired: whenever the
    /// power goes, there is one to restore.
    #[inline(never)]
    pub(super) fn roll_back(&mut self, probe: &mut Probe) -> Result<(), CommandRefusal> {
        let model = match (self.history.previous(), self.restored) {
            (Some(previous), _) => Some(*previous),
            (None, Some(number)) => self.store.model_before(number).map_err(refusal)?,
            (None, None) => None,
        };
        let model = model.ok_or(CommandRefusal::NothingThere)?;
        let number = self.keep(probe, &model)?;
        self.store.retire_models_before(number).map_err(refusal)?;
        self.fly(probe, &model, number, None)
    }

    /// Stores a model that may fly, at once.
    #[inline(never)]
    fn keep(&mut self, probe: &Probe, model: &StoredModel) -> Result<u32, CommandRefusal> {
        probe.may_restore(model).map_err(|_| CommandRefusal::ModelImplausible)?;
        self.store.store_model(model).map_err(refusal)
    }

    /// Starts afresh with a stored model.
    #[inline(never)]
    fn fly(
        &mut self,
        probe: &mut Probe,
        model: &StoredModel,
        number: u32,
        previous: Option<StoredModel>,
    ) -> Result<(), CommandRefusal> {
        probe.restart(Some(model)).map_err(|_| CommandRefusal::ModelImplausible)?;
        self.flown(probe, model, number, previous);
        Ok(())
    }

    /// Returns true if the flash holds what it should.
    ///
    /// # Errors
    /// A record is being written.
    pub(super) fn verify(&mut self) -> Result<bool, CommandRefusal> {
        match self.store.verify() {
            Err(StorageError::Busy) => Err(CommandRefusal::Busy),
            holds => Ok(matches!(holds, Ok(true))),
        }
    }

    /// Returns the flown model if it is not the factory's.
    pub(super) fn flies(&self, probe: &Probe) -> Option<StoredModel> {
        let (gyro, effects) = (probe.gyro_model(), probe.effects());
        let is_factory = *gyro == probe.config().gyro && effects.is_empty();
        (!is_factory).then(|| self.history.flying(gyro, effects))
    }

    /// Stores a command that sets what has to outlive the power, before it is carried out; others are not stored. It
    /// may have to erase, and the tool stands still. A refused command is not to be carried out.
    #[inline(never)]
    pub(super) fn keep_command(
        &mut self,
        command: &Command,
        bytes: &[u8],
        feed: &mut dyn FnMut(),
    ) -> Result<(), CommandRefusal> {
        let stored = match command {
            Command::Configure(_) => StoredCommand::Configure,
            Command::ConfigureSurvey(_) => StoredCommand::ConfigureSurvey,
            _ => return Ok(()),
        };
        let mut kept = self.store.store_command(stored, bytes);
        if matches!(kept, Err(StorageError::Full)) {
            self.prepare(NotDrilling::Command, feed).map_err(refusal)?;
            kept = self.store.store_command(stored, bytes);
        }
        kept.map_err(refusal)
    }

    /// Ends what commands have set: the next start is with the factory's configuration.
    #[inline(never)]
    pub(super) fn forget_commands(&mut self) -> Result<(), CommandRefusal> {
        if self.store.is_writing() {
            return Err(CommandRefusal::Busy);
        }
        let mut is_set = |command| self.store.read_command(command).is_some_and(|(_, bytes)| !bytes.is_empty());
        if is_set(StoredCommand::Configure) || is_set(StoredCommand::ConfigureSurvey) {
            // One record, so that no cut leaves one of two settings.
            self.store.store_command(StoredCommand::Configure, &[]).map_err(refusal)?;
        }
        Ok(())
    }

    /// Puts what commands have set into a configuration, and takes the models for it.
    #[inline(never)]
    pub(super) fn apply_commands(&mut self, config: &mut Config) {
        let (mut newest, mut is_set) = (0, false);
        for command in [StoredCommand::Configure, StoredCommand::ConfigureSurvey] {
            let Some((number, bytes)) = self.store.read_command(command).filter(|(number, _)| *number > newest) else {
                continue;
            };
            newest = number;
            if bytes.is_empty() {
                // It ended what was set before it.
                continue;
            }
            // Checked as when it came, for the program may have other bounds than the one that stored it.
            match Command::of_bytes(bytes).filter(|command| command.check(0).is_ok()) {
                Some(Command::Configure(stored)) => *config = stored,
                Some(Command::ConfigureSurvey(survey)) => config.survey = survey,
                _ => continue,
            }
            is_set = true;
        }
        if is_set {
            self.configured(config);
            info!("what commands have set holds");
        }
    }

    /// Returns the tool's vibration dose when the power went, or up to half an hour before; `None` if none was
    /// stored.
    pub(super) fn dose(&mut self) -> Option<VibrationDose> {
        self.store.read_dose()
    }

    /// Begins to store the vibration dose. It is not stored where models need the room, or while one is being
    /// written: the dose of the next half hour includes it.
    pub(super) fn keep_dose(&mut self, dose: &VibrationDose) {
        let _ = self.store.begin_dose(dose);
    }

    /// Returns the number of the model restored at the start.
    #[must_use]
    pub const fn restored(&self) -> Option<u32> {
        self.restored
    }

    /// Seconds of motion that the estimator had learnt from and goes on from; `None`: it began anew.
    pub(super) const fn goes_on_after_s(&self) -> Option<f32> {
        self.goes_on_after_s
    }

    pub(super) fn sample(&mut self, sample: &Sample) {
        self.gate.sample(sample);
    }

    /// Begins to store the estimator's learnt state and the flown model, if this window makes that worthwhile.
    #[inline(never)]
    pub(super) fn window(&mut self, probe: &Probe, report: &WindowReport) {
        let worth_storing = probe.model_worth_storing(report, &mut self.gate);
        self.history.window(report, probe.gyro_model(), probe.effects(), self.gate.temperature_c());
        let Some(model) = worth_storing else { return };
        self.reason = Some(model.reason);
        if self.store.begin_learnt().is_err() {
            self.begin_model();
        }
    }

    /// Begins to store the model of the latest window, with or without a learnt state beside it.
    fn begin_model(&mut self) {
        let Some(reason) = self.reason.take() else { return };
        // The store counts models that are refused or cannot begin.
        let _ = self.store.begin_model(&StoredModel { reason, ..*self.history.latest() });
    }

    /// Programs the next piece. A failure is counted, and the next window offers its model again. Returns true if the
    /// estimator has to stay as it is until the next piece.
    #[inline(never)]
    pub(super) fn step(&mut self, probe: &Probe) -> bool {
        if !self.store.is_writing() {
            return false;
        }
        if self.store.is_writing_learnt() {
            match self.store.step_learnt(probe.learnt()) {
                Ok(LearntProgress::Whole) | Err(_) => self.begin_model(),
                Ok(_) => {}
            }
            return self.store.holds_filter();
        }
        match self.store.step() {
            Ok(Progress::DoseStored) => info!("the dose is stored"),
            Ok(Progress::Stored { number }) => {
                info!("model {=u32} is stored", number);
                // Writing took less than a second, in which no window ends: the latest model is the stored one.
                self.gate.stored(self.history.latest());
            }
            Ok(_) => {}
            Err(_) => error!("a model or the dose could not be stored"),
        }
        false
    }

    /// Retires all stored models; the factory's is about to fly.
    pub(super) fn retire(&mut self, config: &Config) -> Result<(), StorageError<F::Error>> {
        self.store.retire_models()?;
        self.configured(config);
        Ok(())
    }

    /// Retires all stored models and erases their sectors; the next stable model is stored as the first.
    pub(super) fn erase(&mut self, config: &Config, feed: &mut dyn FnMut()) -> Result<(), StorageError<F::Error>> {
        self.store.retire_models()?;
        self.gate = StabilityGate::new(&config.gyro, None);
        self.restored = None;
        self.prepare(NotDrilling::Command, feed)
    }

    /// Models stored, and models and counters that could not be.
    #[must_use]
    pub const fn stored_and_failed(&self) -> [u32; 2] {
        let counts = self.store.counts();
        let refused = counts.refused_full.saturating_add(counts.refused_implausible);
        [counts.stored, counts.failed.saturating_add(refused)]
    }
}

/// Makes the gate and the history of a probe that flies the factory's model.
fn afresh(config: &Config) -> (StabilityGate, ModelHistory) {
    (StabilityGate::new(&config.gyro, None), ModelHistory::of_factory(config, &LIBRARY))
}

/// Translates an error of the storage for the sender of a command.
pub(super) fn refusal<E>(error: StorageError<E>) -> CommandRefusal {
    match error {
        StorageError::Busy => CommandRefusal::Busy,
        StorageError::Implausible(_) => CommandRefusal::ModelImplausible,
        _ => CommandRefusal::StorageFailed,
    }
}

impl<F: NorFlash> CounterStore for Memory<F> {
    type Error = StorageError<F::Error>;

    fn read(&mut self) -> Result<u64, Self::Error> {
        Ok(self.store.read_counter())
    }

    fn store(&mut self, counter: u64) -> Result<(), Self::Error> {
        let stored = self.store.store_counter(counter);
        self.lacks_room = matches!(stored, Err(StorageError::Full));
        stored
    }
}
