//! Index of the records that count: the newest model of each temperature, the counter, the retirements, the dose, and
//! what commands have set.
//! Models of another configuration count, too: they do not fly, but they are not lost.
//! It is built by reading every record once; the order does not matter.

use super::{
    Implausible, Limits, StoredModel,
    granules::Place,
    little_endian::Reader,
    newest::Newest,
    record::{COMMANDS, Header, Kind},
    single_values::Rising,
    stored_model,
};

/// Largest number of models in the index, each of another temperature band.
pub(super) const KEPT: usize = 8;

/// Largest distance of two temperatures that count as the same, kelvin. Scale factors change by 0.03 % per kelvin
/// (MPU-9250 product specification PS-MPU-9250A-01, section 3.1: 4 % over 125 K), so over this distance by less than
/// they are known.
pub(super) const BAND_K: f32 = 10.0;

/// Model in the index: the newest of its temperature band among those that may fly, or among the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slot {
    pub number: u32,
    pub place: Place,
    pub temperature_c: Option<[f32; 2]>,
    /// False for a model of another configuration. It is not restored, but it is copied before its sector is erased:
    /// the probe may start with that configuration again.
    pub may_fly: bool,
}

/// Findings when the storage was read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScanCounts {
    /// Whole records, copies included.
    pub records: u32,
    /// Places where a record was cut off or has rotted.
    pub damaged: u32,
    /// Whole records of an unknown layout: a later firmware wrote them.
    pub from_the_future: u32,
    /// Whole records whose payload contradicts their layout.
    pub malformed: u32,
    /// Models that may not fly.
    pub implausible: u32,
    /// Number of the first implausible model, and the reason.
    pub first_implausible: Option<(u32, Implausible)>,
    /// Models that were found and retired.
    pub retired: u32,
}

/// Records that count: the newest model of each temperature, the counter, the retirements, and the newest of other
/// records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Index {
    pub kept: [Option<Slot>; KEPT],
    pub counter: Rising,
    /// Models up to this number are retired.
    pub retired: Rising,
    /// Records of which only the newest of its kind counts.
    pub newest: Newest,
    pub last_number: u32,
    /// Record that was noted last, and the granule behind it.
    pub last: Option<(Place, u16)>,
    pub counts: ScanCounts,
}

impl Slot {
    fn band(&self) -> Option<i16> {
        self.temperature_c.map(|[low, high]| libm::floorf((0.5 * low + 0.5 * high) / BAND_K) as i16)
    }

    /// Returns the distance of a temperature from those of the model, kelvin; `None` if one is not known.
    pub fn distance_k(&self, temperature_c: Option<f32>) -> Option<f32> {
        let (t, [low, high]) = (temperature_c?, self.temperature_c?);
        Some(if t < low {
            low - t
        } else if t > high {
            t - high
        } else {
            0.0
        })
    }
}

impl Index {
    pub const fn empty() -> Self {
        let counts = ScanCounts {
            records: 0,
            damaged: 0,
            from_the_future: 0,
            malformed: 0,
            implausible: 0,
            first_implausible: None,
            retired: 0,
        };
        let (counter, retired) = (Rising::NONE, Rising::NONE);
        Self { kept: [None; KEPT], counter, retired, newest: Newest::NONE, last_number: 0, last: None, counts }
    }

    /// Notes a whole record. The order of the records does not matter.
    pub fn note(&mut self, header: &Header, payload: &[u8], place: Place, limits: &Limits) {
        let counts = &mut self.counts;
        counts.records = counts.records.saturating_add(1);
        self.last = Some((place, place.granule + header.granules()));
        if header.number > self.last_number {
            self.last_number = header.number;
        }
        let latest = match header.kind {
            Kind::MODEL => stored_model::VERSION,
            Kind::CONFIGURE | Kind::CONFIGURE_SURVEY => COMMANDS,
            _ => 1,
        };
        if !(1..=latest).contains(&header.version) {
            counts.from_the_future = counts.from_the_future.saturating_add(1);
            return;
        }
        match header.kind {
            Kind::MODEL => {
                match StoredModel::decode(header.version, payload).map(|model| (limits.check(&model), model)) {
                    Some((Ok(()), model)) => self.keep(header.number, place, model.temperature_c, true),
                    Some((Err(reason), model)) => {
                        counts.implausible = counts.implausible.saturating_add(1);
                        counts.first_implausible = counts.first_implausible.or(Some((header.number, reason)));
                        if reason.is_of_the_configuration() {
                            self.keep(header.number, place, model.temperature_c, false);
                        }
                    }
                    None => counts.malformed = counts.malformed.saturating_add(1),
                }
            }
            Kind::COUNTER | Kind::RETIREMENT => match Reader(payload).u64() {
                Some(value) if header.kind == Kind::COUNTER => self.counter.note(value, place.sector),
                Some(value) => self.retired.note(value, place.sector),
                None => counts.malformed = counts.malformed.saturating_add(1),
            },
            // Parts are looked up when their model is chosen.
            Kind::LEARNT => {}
            kind if self.newest.note(kind, header.number, place) => {}
            _ => counts.malformed = counts.malformed.saturating_add(1),
        }
    }

    /// Adds a model in place of the earlier one of its temperature band or, when the index is full, of the oldest; a
    /// model that may not fly takes no place from one that may.
    pub fn keep(&mut self, number: u32, place: Place, temperature_c: Option<[f32; 2]>, may_fly: bool) {
        let new = Slot { number, place, temperature_c, may_fly };
        let rank = |slot: Option<&Slot>| slot.map(|slot| (slot.may_fly, slot.number));
        let replaced = |slot: &&mut Option<Slot>| {
            slot.is_some_and(|slot| slot.band() == new.band() && slot.may_fly == new.may_fly)
        };
        let slot = match self.kept.iter_mut().find(replaced) {
            Some(slot) => Some(slot),
            None => self.kept.iter_mut().min_by_key(|slot| rank(slot.as_ref())),
        };
        // A record with an equal number is a later copy of the same model.
        if let Some(slot) = slot.filter(|slot| rank(slot.as_ref()) <= rank(Some(&new))) {
            *slot = Some(new);
        }
    }

    /// Drops retired models.
    pub fn retire(&mut self) {
        let Some(last) = self.retired.value() else { return };
        for slot in &mut self.kept {
            if slot.take_if(|slot| u64::from(slot.number) <= last).is_some() {
                self.counts.retired = self.counts.retired.saturating_add(1);
            }
        }
    }

    /// Returns true if every record that counts in `other` counts here, too.
    pub fn holds_all_of(&self, other: &Self) -> bool {
        let held = |slot: &Slot| self.kept.iter().flatten().any(|own| own.number == slot.number);
        other.kept.iter().flatten().all(held)
            && self.counter.says_the_same_as(&other.counter)
            && self.retired.says_the_same_as(&other.retired)
            && self.newest.are_those_of(&other.newest)
    }

    /// Returns the models that may fly.
    pub fn flyable(&self) -> impl Iterator<Item = &Slot> {
        self.kept.iter().flatten().filter(|slot| slot.may_fly)
    }

    /// Returns the model for a temperature: the one with the nearest range, and of equally near ones the newest.
    pub fn nearest(&self, temperature_c: Option<f32>) -> Option<Slot> {
        // A model of unknown temperature ranks below all others, unless no temperature is known.
        let rank = |slot: &Slot| {
            let bands = slot.distance_k(temperature_c).map_or(i16::MAX, |k| (k / BAND_K) as i16);
            (core::cmp::Reverse(bands), slot.number)
        };
        self.flyable().max_by_key(|slot| rank(slot)).copied()
    }
}

#[cfg(test)]
mod tests;
