//! Drift of each probe's P over months: a line through its recordings' results, each weighted by its own deviation.

use std::collections::BTreeMap;

use chrono::NaiveDate;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use super::{Parameters, Recording};

/// Days of a month, on the mean.
pub const MONTH_DAYS: f64 = 30.44;

/// Chance at which the P of any probe of a fleet is said to move although none does.
const FALSE_ALARM: f64 = 0.01;

/// Dated results of a probe, in the order of their days.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Its serial number.
    pub serial: String,
    /// Day and result of each recording that has both.
    pub results: Vec<(NaiveDate, Parameters)>,
}

/// A change with its deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Per month.
    pub a_month: f64,
    /// Deviation of that.
    pub sigma: f64,
    /// Degrees of freedom of the scatter that the deviation comes from; `None` where it comes from the results' own.
    pub freedom: Option<f64>,
}

impl Change {
    /// In its own deviations.
    #[must_use]
    pub fn in_sigmas(&self) -> f64 {
        self.a_month.abs() / self.sigma.max(f64::MIN_POSITIVE)
    }

    /// Quantile of a change that is chance alone, in its own deviations.
    fn of_chance(&self, quantile: f64) -> Option<f64> {
        match self.freedom {
            Some(freedom) => Some(StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(quantile)),
            None => Some(Normal::standard().inverse_cdf(quantile)),
        }
    }
}

/// Probes with results of at least two days; the one whose P moves most clearly comes first.
#[must_use]
pub fn probes(recordings: &[Recording]) -> Vec<Probe> {
    let mut all: BTreeMap<&str, Vec<(NaiveDate, Parameters)>> = BTreeMap::new();
    for recording in recordings {
        if let (Some(serial), Some(date), Some(last)) = (&recording.serial, recording.date, recording.last) {
            all.entry(serial).or_default().push((date, last));
        }
    }
    let probes: Vec<Probe> = all
        .into_iter()
        .map(|(serial, mut results)| {
            results.sort_by_key(|(date, _)| *date);
            Probe { serial: serial.to_owned(), results }
        })
        .filter(|probe| probe.results.first().map(|(date, _)| date) != probe.results.last().map(|(date, _)| date))
        .collect();
    let count = probes.len();
    let over_chance = |probe: &Probe| probe.clearest(count).map_or(0.0, |(.., over_chance)| over_chance);
    let mut probes: Vec<(f64, Probe)> = probes.into_iter().map(|probe| (over_chance(&probe), probe)).collect();
    probes.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    probes.into_iter().map(|(_, probe)| probe).collect()
}

/// Days since 1970.
#[must_use]
pub fn day(date: NaiveDate) -> f64 {
    date.signed_duration_since(NaiveDate::default()).num_days() as f64
}

impl Probe {
    /// Change of an element of P in a month, percent.
    #[must_use]
    pub fn change_percent(&self, element: usize) -> Option<Change> {
        let points = self.results.iter().map(|(date, result)| {
            let [x, sigma] = result.percent(element);
            [day(*date) / MONTH_DAYS, x, sigma]
        });
        slope(&points.collect::<Vec<_>>())
    }
}

impl Probe {
    /// The element of P that moves most clearly, and its change, if that is more than chance among `probes` probes.
    #[must_use]
    pub fn moves(&self, probes: usize) -> Option<(usize, Change)> {
        let (element, change, over_chance) = self.clearest(probes)?;
        (over_chance > 1.0).then_some((element, change))
    }

    /// The element of P whose change is largest over what chance allows it among `probes` probes, its change, and that
    /// ratio.
    fn clearest(&self, probes: usize) -> Option<(usize, Change, f64)> {
        let quantile = 1.0 - 0.5 * FALSE_ALARM / (9 * probes.max(1)) as f64;
        let changes = (0..9).filter_map(|element| {
            let change = self.change_percent(element)?;
            Some((element, change, change.in_sigmas() / change.of_chance(quantile)?))
        });
        changes.max_by(|(.., a), (.., b)| a.total_cmp(b))
    }
}

/// Slope of the weighted line through points of time, value and deviation. Its own deviation grows with the scatter
/// about the line where that is more than the points' deviations account for.
fn slope(points: &[[f64; 3]]) -> Option<Change> {
    let weight = |sigma: f64| sigma.max(1e-12).powi(-2);
    let sum = |of: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(|point| weight(point[2]) * of(point)).sum::<f64>();
    let total = sum(&|_| 1.0);
    let (middle, mean) = (sum(&|[t, ..]| *t) / total, sum(&|[_, x, _]| *x) / total);
    let spread = sum(&|[t, ..]| (t - middle).powi(2));
    if spread.is_nan() || spread <= 0.0 {
        return None;
    }
    let a_month = sum(&|[t, x, _]| (t - middle) * (x - mean)) / spread;
    let scatter = sum(&|[t, x, _]| (x - mean - a_month * (t - middle)).powi(2));
    let free = points.len().saturating_sub(2) as f64;
    let excess = scatter / free.max(1.0);
    let (excess, freedom) = if excess > 1.0 && free > 0.0 { (excess, Some(free)) } else { (1.0, None) };
    Some(Change { a_month, sigma: (excess / spread).sqrt(), freedom })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A probe with a recording each month: x of an element, percent, and its deviation.
    fn probe(serial: &str, months: &[[f64; 9]], sigma: f64) -> Probe {
        let result = |(month, percent): (usize, &[f64; 9])| {
            let date = NaiveDate::default() + chrono::Days::new(30 * month as u64);
            let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
            let p = std::array::from_fn(|element| identity[element] + 0.01 * percent[element]);
            (date, Parameters { p, sigma: [0.01 * sigma; 12], ..Parameters::default() })
        };
        Probe { serial: serial.to_owned(), results: months.iter().enumerate().map(result).collect() }
    }

    /// Three recordings that scatter about their line leave one degree of freedom, and chance allows more than a
    /// hundred deviations.
    #[test]
    fn an_element_that_scatters_hides_none_that_moves() {
        let mut months = [[0.0; 9]; 3];
        for (month, percent) in months.iter_mut().enumerate() {
            percent[0] = [0.0, 1.1, 2.0][month];
            percent[8] = 0.05 * month as f64;
        }
        let moved = probe("1", &months, 0.01);
        let sigmas = [0, 8].map(|element| moved.change_percent(element).unwrap());
        assert!(sigmas[0].in_sigmas() > sigmas[1].in_sigmas() && sigmas[0].freedom == Some(1.0), "{sigmas:?}");
        assert!(sigmas[1].in_sigmas() > 6.0 && sigmas[1].freedom.is_none(), "{sigmas:?}");
        assert_eq!(moved.moves(1).map(|(element, _)| element), Some(8));
    }

    #[test]
    fn a_line_comes_back_and_scatter_widens_its_deviation() {
        let line = |scatter: f64| -> Vec<[f64; 3]> {
            (0..12)
                .map(|k| (f64::from(k), if k % 2 == 0 { scatter } else { -scatter }))
                .map(|(t, off)| [t, 1.0 - 0.02 * t + off, 0.01])
                .collect()
        };
        let exact = slope(&line(0.0)).unwrap();
        assert!((exact.a_month + 0.02).abs() < 1e-12, "{exact:?}");
        let scattered = slope(&line(0.1)).unwrap();
        assert!(scattered.sigma > 5.0 * exact.sigma, "{scattered:?}");
        assert!((scattered.a_month + 0.02).abs() < 2.0 * scattered.sigma, "{scattered:?}");
        assert_eq!(slope(&[[1.0, 2.0, 0.1]]), None);
        assert_eq!(slope(&[[1.0, 2.0, 0.1], [1.0, 3.0, 0.1]]), None);
    }
}
