//! Burst: the raw samples around the worst second.

use super::SurveyInput;

/// One sample of a burst.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BurstSample {
    /// Time of acquisition, microseconds.
    pub t_us: u64,
    /// Raw accelerometer reading, m/s^2.
    pub accel_m_s2: [f32; 3],
    /// Rate about the tool axis, rad/s; 0 if it is not usable.
    pub axial_rate_rad_s: f32,
}

const NO_SAMPLE: BurstSample = BurstSample { t_us: 0, accel_m_s2: [0.0; 3], axial_rate_rad_s: 0.0 };

/// Recorder of the `N` successive samples whose raw acceleration varied most since the start. For a burst of one second
/// `N` is the sample rate in hertz. It takes 48 bytes of RAM for each sample.
///
/// ```
/// # use meerkat_mwd::survey::{BurstRecorder, SurveyInput};
/// # let input = SurveyInput::default();
/// let mut recorder = BurstRecorder::<200>::new();
/// recorder.push(&input); // once a sample, beside `Surveyor::push`
/// for sample in recorder.worst() {
///     // to a file, or over the line when the tool is at the surface
/// #   let _ = sample.t_us;
/// }
/// ```
pub struct BurstRecorder<const N: usize> {
    latest: [BurstSample; N],
    worst: [BurstSample; N],
    /// Place of the next sample in `latest`.
    next: usize,
    /// Place of the oldest sample in `worst`.
    oldest: usize,
    taken: usize,
    since_compared: usize,
    worst_variance: f32,
    /// True once there is a worst burst.
    is_there: bool,
}

impl<const N: usize> BurstRecorder<N> {
    /// Returns an empty recorder, all zero bytes.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            latest: [NO_SAMPLE; N],
            worst: [NO_SAMPLE; N],
            next: 0,
            oldest: 0,
            taken: 0,
            since_compared: 0,
            worst_variance: 0.0,
            is_there: false,
        }
    }

    /// Takes a sample. Four times in `N` samples the latest `N` are compared with the worst burst, and copied if they
    /// vary more.
    pub fn push(&mut self, input: &SurveyInput) {
        let input = input.sanitised();
        if input.force_m_s2.is_none() && !input.accel_clipped {
            // A reading that is missing looks like a blow.
            return;
        }
        let Some(place) = self.latest.get_mut(self.next) else { return };
        *place = BurstSample {
            t_us: input.t_us,
            accel_m_s2: input.raw_accel_m_s2,
            axial_rate_rad_s: input.rate_rad_s.map_or(0.0, |[.., rate]| rate),
        };
        self.next = if self.next + 1 < N { self.next + 1 } else { 0 };
        self.taken = self.taken.saturating_add(1);
        self.since_compared += 1;
        if self.taken < N || (self.since_compared < N.div_ceil(4) && self.taken > N) {
            return;
        }
        self.since_compared = 0;
        let variance = variance(&self.latest);
        if !self.is_there || variance > self.worst_variance {
            // Not as one tuple: that would put the samples on the stack.
            self.worst = self.latest;
            (self.oldest, self.worst_variance, self.is_there) = (self.next, variance, true);
        }
    }

    /// Begins the latest samples anew, because the next one does not follow them. The worst burst stays.
    pub const fn begin_anew(&mut self) {
        (self.taken, self.since_compared) = (0, 0);
    }

    /// Samples of the worst burst, oldest first; none before `N` samples were taken.
    pub fn worst(&self) -> impl Iterator<Item = &BurstSample> {
        let (later, earlier) = self.worst.split_at_checked(self.oldest).unwrap_or_default();
        let there = if self.is_there { N } else { 0 };
        earlier.iter().chain(later).take(there)
    }

    /// Root mean square of the worst burst's raw acceleration about its mean, m/s^2.
    #[must_use]
    pub fn worst_rms_m_s2(&self) -> Option<f32> {
        self.is_there.then(|| libm::sqrtf(self.worst_variance))
    }
}

impl<const N: usize> Default for BurstRecorder<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Sum of the acceleration's variances on the three axes, (m/s^2)^2.
fn variance(samples: &[BurstSample]) -> f32 {
    let share = 1.0 / samples.len() as f32;
    let mut mean = [0.0; 3];
    for sample in samples {
        for (mean, x) in mean.iter_mut().zip(sample.accel_m_s2) {
            *mean += x * share;
        }
    }
    let squares = |sample: &BurstSample| -> f32 {
        sample.accel_m_s2.iter().zip(mean).map(|(x, mean)| (x - mean) * (x - mean)).sum()
    };
    samples.iter().map(squares).sum::<f32>() * share
}
