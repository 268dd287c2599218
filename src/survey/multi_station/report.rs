//! The analysis: fit, doubted stations, decision, corrected angles.

use super::{
    Decision, LEAST_STATIONS, MAX_STATIONS, MultiStationSettings, PARAMETERS, Parameter, Refusal, Station,
    fit::{Fit, dot, fitted},
    left_out::{LeftOut, left_out},
    parameters::{AXIAL, GROWTH, REFERENCES},
    rows::{Freed, Scales, Whitened},
};
use crate::{
    attitude::positive_angle,
    config::SurveyErrors,
    statistics::chi_square,
    survey::{
        Uncertain,
        station_axes::{Axes, Gradient},
    },
};
use core::f32::consts::{PI, TAU};

/// Estimate of one common error, in the unit that its name ends with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Estimate {
    /// The error.
    pub parameter: Parameter,
    /// Value and standard deviation of the error after the analysis.
    pub estimate: Uncertain,
    /// Standard deviation of the error before the analysis; inflated where the stations show an error beyond three
    /// configured deviations.
    pub prior_sigma: f32,
    /// True if the stations determine it: the standard deviation is below the configured share of the prior's.
    pub observable: bool,
}

/// Result of a multi-station analysis.
pub struct MultiStationReport {
    scales: Scales,
    fit: Fit,
    /// Stations left out because the others contradict them, a bit each, the first station in bit 0.
    pub left_out: u64,
    /// Number of stations that the estimate rests on.
    pub counted: usize,
    /// Variance of the residuals over that of the configured noise; where above 1 beyond chance, it inflated the noise.
    pub noise_ratio: f32,
    /// Root mean square of the residuals of |G|, |B| and dip without correction, in units of the noise.
    pub residual_uncorrected: f32,
    /// Root mean square of the residuals of stations as the others predict them, in units of the noise.
    pub residual_left_out: f32,
    /// Decision on azimuths.
    pub azimuth: Decision,
    /// Decision on inclinations.
    pub inclination: Decision,
}

/// Angles of a station by an analysis. The sigmas include what the analysis left of the stations' common errors, and
/// the noise; not the declination's error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CorrectedStation {
    /// Inclination, radians.
    pub inclination_rad: Uncertain,
    /// Azimuth from magnetic north, radians, 0 to 2 pi.
    pub magnetic_azimuth_rad: Uncertain,
    /// Azimuth as measured, radians.
    pub measured_azimuth_rad: Uncertain,
    /// Inclination as measured, radians.
    pub measured_inclination_rad: Uncertain,
    /// Horizontal field, microtesla: the declination's error grows with its inverse.
    pub horizontal_ut: f32,
}

/// Largest number of times that priors are inflated: the second time for errors that show after the first.
const INFLATIONS: usize = 2;

/// One of the two angles that are corrected.
#[derive(Clone, Copy)]
enum Angle {
    Azimuth,
    Inclination,
}

impl Angle {
    fn value(self, axes: &Axes) -> f32 {
        match self {
            Self::Azimuth => axes.azimuth_rad(),
            Self::Inclination => axes.inclination_rad(),
        }
    }

    fn gradient(self, axes: &Axes) -> Gradient {
        match self {
            Self::Azimuth => axes.azimuth_gradient(),
            Self::Inclination => axes.inclination_gradient(),
        }
    }

    /// Factor from an error of the angle to one of the hole's direction.
    fn weight(self, axes: &Axes) -> f32 {
        match self {
            Self::Azimuth => axes.sine(),
            Self::Inclination => 1.0,
        }
    }
}

impl MultiStationReport {
    /// Estimates of all errors, in the order of [`Parameter::ALL`].
    #[must_use]
    pub fn estimates(&self) -> [Estimate; PARAMETERS] {
        let mut index = 0;
        Parameter::ALL.map(|parameter| {
            let (sigma, value) = (at(&self.scales.prior, index), at(&self.fit.x, index));
            let width = libm::sqrtf(self.fit.information.variance(&unit(index)));
            index += 1;
            Estimate {
                parameter,
                estimate: Uncertain { value: value * sigma, sigma: width * sigma },
                prior_sigma: sigma,
                observable: width < self.scales.settings.observable_below,
            }
        })
    }

    /// Correlation of two errors, by their places in [`Parameter::ALL`], -1 to 1.
    #[must_use]
    pub fn correlation(&self, i: usize, j: usize) -> f32 {
        let (a, b) = (unit(i), unit(j));
        let information = &self.fit.information;
        let norm = libm::sqrtf(information.variance(&a) * information.variance(&b));
        if norm > 0.0 { information.covariance(&a, &b) / norm } else { 0.0 }
    }

    /// Returns true if the drill string's field grew over the run beyond two standard deviations.
    #[must_use]
    pub fn axial_field_grows(&self) -> bool {
        let growth = unit(GROWTH);
        let (value, variance) = (dot(&growth, &self.fit.x), self.fit.information.variance(&growth));
        value * value > 4.0 * variance
    }

    /// Angles of a station, one of the analysis or a later one of the same run; `None` if the station is not usable.
    #[must_use]
    pub fn corrected(&self, station: &Station) -> Option<CorrectedStation> {
        let [measured, best] = [[0.0; PARAMETERS], self.fit.x].map(|x| self.scales.freed(station, &x));
        let (measured, best) = (measured?, best?);
        let angle = |angle, decision| {
            let [before, after] = [&measured, &best].map(|freed| angle_of(angle, freed));
            let noise = self.scales.noise_variance(&angle_gradient(angle, &best));
            let by_errors = self.scales.by_errors(&best, &angle_gradient(angle, &best));
            let posterior = self.fit.information.variance(&by_errors) + noise;
            let prior = dot(&by_errors, &by_errors) + noise;
            let change = libm::remainderf(after - before, TAU);
            match decision {
                Decision::Corrected => [sure(after, posterior), sure(before, posterior + change * change)],
                Decision::Refused(Refusal::NotCertain) => [sure(before, posterior + change * change); 2],
                Decision::Refused(_) => [sure(before, prior); 2],
            }
        };
        let [azimuth, measured_azimuth] = angle(Angle::Azimuth, self.azimuth)
            .map(|x| Uncertain { value: positive_angle(libm::remainderf(x.value, TAU)), sigma: x.sigma });
        let [inclination_rad, measured_inclination_rad] = angle(Angle::Inclination, self.inclination);
        Some(CorrectedStation {
            inclination_rad,
            magnetic_azimuth_rad: azimuth,
            measured_azimuth_rad: measured_azimuth,
            measured_inclination_rad,
            horizontal_ut: best.axes.horizontal_ut,
        })
    }

    /// Decides whether to correct an angle: only if that raises its squared error, summed over the counted stations (an
    /// azimuth's times the sine of the inclination), with at most the configured probability. For corrections m and
    /// true errors a, with the posterior's mean m and covariance C, |a - m|^2 exceeds |a|^2 where m.a < m.m / 2; m.a
    /// has mean m.m and variance m^T C m.
    fn decide(&self, stations: &[Station], angle: Angle, sums: &LeftOut) -> Option<Decision> {
        let (mut square, mut noise, mut together) = (0.0, 0.0, [0.0; PARAMETERS]);
        for (_, station) in stations.iter().enumerate().filter(|(k, _)| self.left_out & bit(*k) == 0) {
            let measured = self.scales.freed(station, &[0.0; PARAMETERS])?;
            let best = self.scales.freed(station, &self.fit.x)?;
            let weight = angle.weight(&best.axes);
            let change = libm::remainderf(angle_of(angle, &best) - angle_of(angle, &measured), TAU) * weight;
            let gradient = angle_gradient(angle, &best);
            square += change * change;
            noise += change * change * weight * weight * self.scales.noise_variance(&gradient);
            for (sum, by) in together.iter_mut().zip(self.scales.by_errors(&best, &gradient)) {
                *sum += change * weight * by;
            }
        }
        let spread = libm::sqrtf(self.fit.information.variance(&together) + noise);
        let certain = 0.5 * square > self.scales.settings.harm_deviations * spread;
        Some(match certain {
            false => Decision::Refused(Refusal::NotCertain),
            true if sums.predicted > sums.uncorrected => Decision::Refused(Refusal::PredictsWorse),
            true => Decision::Corrected,
        })
    }
}

/// Runs the analysis. Stations that the others contradict (once in a thousand by chance) are left out one after the
/// other, up to a quarter of them; then priors that are too narrow for the errors found are inflated, and the noise to
/// the size of the residuals.
pub(super) fn analysed(
    stations: &[Station],
    errors: &SurveyErrors,
    settings: &MultiStationSettings,
) -> Option<MultiStationReport> {
    if stations.len() < LEAST_STATIONS || stations.len() > MAX_STATIONS {
        return None;
    }
    let prior = Parameter::ALL.map(|parameter| parameter.prior_sigma(errors, settings));
    let run = [stations.first()?.depth_m, stations.last()?.depth_m - stations.first()?.depth_m];
    let mut scales = Scales { prior, settings: *settings, noise: 1.0, run };
    if !prior.iter().all(|sigma| sigma.is_finite() && *sigma > 0.0) {
        return None;
    }
    let most_left_out = stations.len() / 4;
    let (mut mask, mut count) = (0_u64, 0);
    let (mut fit, mut sums) = judged(stations, mask, &scales)?;
    while count < most_left_out
        && let Some((worst, surprise)) = sums.worst
        && surprise > chi_square::IN_A_THOUSAND
    {
        mask |= bit(worst);
        count += 1;
        (fit, sums) = judged(stations, mask, &scales)?;
    }
    for _ in 0..INFLATIONS {
        if !inflate_priors(&mut scales.prior, &fit.x) {
            break;
        }
        (fit, sums) = judged(stations, mask, &scales)?;
    }
    let mut noise_ratio = 1.0;
    // Chance alone spreads the ratio by sqrt(2 / freedom).
    let by_chance = 1.0 + 3.0 * libm::sqrtf(2.0 / sums.freedom);
    if sums.variance_ratio > by_chance {
        noise_ratio = sums.variance_ratio;
        scales.noise = libm::sqrtf(noise_ratio);
        (fit, sums) = judged(stations, mask, &scales)?;
    }
    let counted = stations.len() - count;
    let of_all = |sum: f32| libm::sqrtf(sum / (3.0 * counted as f32));
    let (residual_uncorrected, residual_left_out) = (of_all(sums.uncorrected), of_all(sums.predicted));
    let undecided = Decision::Refused(Refusal::Contradiction);
    let mut report = MultiStationReport {
        scales,
        fit,
        left_out: mask,
        counted,
        noise_ratio,
        residual_uncorrected,
        residual_left_out,
        azimuth: undecided,
        inclination: undecided,
    };
    if noise_ratio <= settings.largest_noise_ratio {
        report.azimuth = report.decide(stations, Angle::Azimuth, &sums)?;
        report.inclination = report.decide(stations, Angle::Inclination, &sums)?;
    }
    Some(report)
}

/// Inflates the prior of a sensor's error, or of the drill string's field, to what was found where that is beyond three
/// standard deviations (once in 400 by chance): a sensor out of its specification, or a collar more magnetic than
/// usual. Such a collar widens both the field at the first station and its growth: one was found, but in a level hole
/// to the east each passes for the other. Returns true if it inflated one. References keep their priors: an error there
/// is not the tool's.
fn inflate_priors(prior: &mut Whitened, x: &Whitened) -> bool {
    let before = *prior;
    let found = |k: usize| {
        let size = libm::fabsf(at(x, k));
        if size > 3.0 { size * at(&before, k) } else { 0.0 }
    };
    let [axial, growth] = [AXIAL, GROWTH].map(found);
    let string = if axial > growth { axial } else { growth };
    for (k, sigma) in prior.iter_mut().enumerate().take(REFERENCES) {
        let least = if k == AXIAL || k == GROWTH { string } else { found(k) };
        if least > *sigma {
            *sigma = least;
        }
    }
    *prior != before
}

fn judged(stations: &[Station], mask: u64, scales: &Scales) -> Option<(Fit, LeftOut)> {
    let counts = |k: usize| mask & bit(k) == 0;
    let fit = fitted(stations, counts, scales)?;
    let sums = left_out(stations, counts, scales, &fit)?;
    Some((fit, sums))
}

fn angle_of(angle: Angle, freed: &Freed) -> f32 {
    angle.value(&freed.axes)
}

fn angle_gradient(angle: Angle, freed: &Freed) -> Gradient {
    angle.gradient(&freed.axes)
}

/// Angle with a sigma of at most pi, radians.
fn sure(value: f32, variance: f32) -> Uncertain {
    Uncertain { value, sigma: if variance < PI * PI { libm::sqrtf(variance) } else { PI } }
}

const fn bit(k: usize) -> u64 {
    if k < MAX_STATIONS { 1 << k } else { 0 }
}

fn unit(k: usize) -> Whitened {
    let mut unit = [0.0; PARAMETERS];
    if let Some(one) = unit.get_mut(k) {
        *one = 1.0;
    }
    unit
}

fn at(values: &Whitened, k: usize) -> f32 {
    values.get(k).copied().unwrap_or(0.0)
}
