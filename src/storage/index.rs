use super::{
    Implausible, Limits, StoredModel,
    granules::Place,
    little_endian::Reader,
    record::{Header, Kind},
    stored_model,
};

/// Models that are kept, of different temperatures.
pub(super) const KEPT: usize = 8;

/// Models whose temperatures are no farther apart are of the same temperature, kelvin: scale factors go by 0.03 % per kelvin (MPU-9250
/// product specification PS-MPU-9250A-01, section 3.1: 4 % over 125 K), so over this they go by less than they are known.
pub(super) const BAND_K: f32 = 10.0;

/// A model that is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slot {
    pub number: u32,
    pub place: Place,
    pub temperature_c: Option<[f32; 2]>,
}

/// A single value and the sector of its latest copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Single {
    pub value: u64,
    pub sector: u8,
}

/// What was found when the storage was read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScanCounts {
    /// Records that are whole, copies included.
    pub records: u32,
    /// Places where a record was cut off or has rotted.
    pub damaged: u32,
    /// Whole records of a layout that this firmware does not know: a later one wrote them.
    pub from_the_future: u32,
    /// Whole records that are not laid out as they say.
    pub malformed: u32,
    /// Models that may not fly.
    pub implausible: u32,
    /// Number of the first of them, and why.
    pub first_implausible: Option<(u32, Implausible)>,
    /// Models that were found and retired.
    pub retired: u32,
}

/// What of the records counts: the newest model of each temperature, the counter, and what has been retired.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Index {
    pub kept: [Option<Slot>; KEPT],
    pub counter: Option<Single>,
    /// Models up to this number are retired.
    pub retired: Option<Single>,
    pub last_number: u32,
    pub counts: ScanCounts,
}

impl Slot {
    fn band(&self) -> Option<i16> {
        self.temperature_c.map(|[low, high]| libm::floorf((0.5 * low + 0.5 * high) / BAND_K) as i16)
    }

    /// How far a temperature is from those of the model, kelvin; `None` where one is not known.
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
        Self { kept: [None; KEPT], counter: None, retired: None, last_number: 0, counts }
    }

    /// Takes note of a whole record. In whatever order they come, the same is kept.
    pub fn note(&mut self, header: &Header, payload: &[u8], place: Place, limits: &Limits) {
        let counts = &mut self.counts;
        counts.records = counts.records.saturating_add(1);
        if header.number > self.last_number {
            self.last_number = header.number;
        }
        let latest = if header.kind == Kind::MODEL { stored_model::VERSION } else { 1 };
        if !(1..=latest).contains(&header.version) {
            counts.from_the_future = counts.from_the_future.saturating_add(1);
            return;
        }
        match header.kind {
            Kind::MODEL => {
                match StoredModel::decode(header.version, payload).map(|model| (limits.check(&model), model)) {
                    Some((Ok(()), model)) => self.keep(header.number, place, model.temperature_c),
                    Some((Err(reason), _)) => {
                        counts.implausible = counts.implausible.saturating_add(1);
                        counts.first_implausible = counts.first_implausible.or(Some((header.number, reason)));
                    }
                    None => counts.malformed = counts.malformed.saturating_add(1),
                }
            }
            Kind::COUNTER | Kind::RETIREMENT => match Reader(payload).u64() {
                Some(value) if header.kind == Kind::COUNTER => raise(&mut self.counter, value, place.sector),
                Some(value) => raise(&mut self.retired, value, place.sector),
                None => counts.malformed = counts.malformed.saturating_add(1),
            },
            // They are looked for when their model is chosen.
            Kind::LEARNT => {}
            _ => counts.malformed = counts.malformed.saturating_add(1),
        }
    }

    /// Takes a model in; the one before of its temperature goes, or the oldest when there are too many.
    pub fn keep(&mut self, number: u32, place: Place, temperature_c: Option<[f32; 2]>) {
        let new = Slot { number, place, temperature_c };
        let same_band = |slot: &&mut Option<Slot>| slot.is_some_and(|slot| slot.band() == new.band());
        let slot = match self.kept.iter_mut().find(same_band) {
            Some(slot) => Some(slot),
            None => self.kept.iter_mut().min_by_key(|slot| slot.map_or(0, |slot| slot.number)),
        };
        // The same number is a later copy.
        if let Some(slot) = slot.filter(|slot| slot.is_none_or(|old| old.number <= number)) {
            *slot = Some(new);
        }
    }

    /// Drops what has been retired.
    pub fn retire(&mut self) {
        let Some(last) = self.retired else { return };
        for slot in &mut self.kept {
            if slot.take_if(|slot| u64::from(slot.number) <= last.value).is_some() {
                self.counts.retired = self.counts.retired.saturating_add(1);
            }
        }
    }

    /// Whether all that counts in `other` is here, too.
    pub fn holds_all_of(&self, other: &Self) -> bool {
        let value = |single: Option<Single>| single.map(|single| single.value);
        let held = |slot: &Slot| self.kept.iter().flatten().any(|own| own.number == slot.number);
        other.kept.iter().flatten().all(held)
            && value(self.counter) == value(other.counter)
            && value(self.retired) == value(other.retired)
    }

    /// The model for a temperature: the nearest, of those as near the newest.
    pub fn nearest(&self, temperature_c: Option<f32>, not: &[Option<u32>]) -> Option<Slot> {
        // Where a temperature is not known, beyond all that are, unless none is.
        let rank = |slot: &Slot| {
            let bands = slot.distance_k(temperature_c).map_or(i16::MAX, |k| (k / BAND_K) as i16);
            (core::cmp::Reverse(bands), slot.number)
        };
        let left = self.kept.iter().flatten().filter(|slot| !not.contains(&Some(slot.number)));
        left.max_by_key(|slot| rank(slot)).copied()
    }
}

/// A value that only rises; of equal ones the last copy counts.
fn raise(single: &mut Option<Single>, value: u64, sector: u8) {
    if single.is_none_or(|old| value >= old.value) {
        *single = Some(Single { value, sector });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACE: Place = Place { sector: 0, granule: 1 };

    #[test]
    fn the_nearest_temperature_is_chosen_and_of_equals_the_newest() {
        let mut index = Index::empty();
        for (number, t) in [(1, 20.0), (2, 60.0), (3, 100.0), (4, 62.0)] {
            index.keep(number, PLACE, Some([t, t + 5.0]));
        }
        index.keep(5, PLACE, None);
        let chosen = |t: Option<f32>| index.nearest(t, &[]).map(|slot| slot.number);
        assert_eq!(chosen(Some(21.0)), Some(1));
        assert_eq!(chosen(Some(-40.0)), Some(1));
        assert_eq!(chosen(Some(64.0)), Some(4), "2 is of the same band and older");
        assert_eq!(chosen(Some(170.0)), Some(3));
        assert_eq!(chosen(None), Some(5));
        assert_eq!(index.nearest(Some(170.0), &[Some(3)]).map(|slot| slot.number), Some(4));
        // 105 is in no range; 100 to 105 is no farther than a band.
        assert_eq!(chosen(Some(114.0)), Some(3));
    }

    #[test]
    fn what_is_kept_does_not_depend_on_the_order() {
        let models: [(u32, f32); 14] = core::array::from_fn(|i| (i as u32 + 1, ((i * 7) % 11) as f32 * 11.0));
        let kept = |order: &dyn Fn(usize) -> usize| {
            let mut index = Index::empty();
            for i in 0..models.len() {
                let (number, t) = models[order(i)];
                index.keep(number, PLACE, Some([t, t]));
            }
            let mut numbers = index.kept.map(|slot| slot.map(|slot| slot.number));
            numbers.sort_unstable();
            numbers
        };
        let forwards = kept(&|i| i);
        assert_eq!(forwards, kept(&|i| 13 - i));
        assert_eq!(forwards, kept(&|i| (i * 5 + 3) % 14));
    }
}
