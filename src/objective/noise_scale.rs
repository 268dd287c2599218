use super::{NoiseScales, two_vector::residual};
use crate::window::{Segment, Sighting};
use nalgebra::Vector3;

/// Median of the norm of a two-dimensional normal vector, in standard deviations of a component (Rayleigh: sqrt(2 ln 2)).
const RAYLEIGH_MEDIAN: f32 = 1.177_41;

/// Smallest believed deviation of a unit vector's mean over a second, rad: 0.03 deg, what a 16-bit magnetometer resolves.
const FLOOR: f32 = 5e-4;

/// Deviation of a class that has too few segments to show its own, rad: 1 deg.
const DEFAULT: f32 = 0.017;

/// Fewest sightings from which a median is taken.
const FEWEST: usize = 5;

const CAPACITY: usize = 64;

/// Noise scales of each sensor, at rest and in motion, from the median residual where the segments were pre-integrated.
pub(crate) fn noise_scales(segments: &[Segment]) -> NoiseScales {
    let class = |moving: bool, sighting: fn(&Segment) -> &Option<Sighting>| {
        let mut norms = [0.0; CAPACITY];
        let mut count = 0;
        for segment in segments.iter().filter(|segment| segment.moving == moving) {
            if let (Some(sighting), Some(norm)) = (sighting(segment), norms.get_mut(count)) {
                *norm = residual(sighting, &Vector3::zeros()).norm();
                count += 1;
            }
        }
        if count < FEWEST {
            return DEFAULT;
        }
        let sigma = median(norms.get_mut(..count).unwrap_or_default()) / RAYLEIGH_MEDIAN;
        if sigma > FLOOR { sigma } else { FLOOR }
    };
    NoiseScales {
        gravity: [false, true].map(|moving| class(moving, |s| &s.gravity)),
        field: [false, true].map(|moving| class(moving, |s| &s.field)),
    }
}

/// Upper median, by insertion sort: at most 50 numbers, and no way to panic.
fn median(values: &mut [f32]) -> f32 {
    for sorted in 1..values.len() {
        let mut place = values.get_mut(..=sorted).unwrap_or_default();
        while let [.., before, last] = place {
            if *before > *last {
                core::mem::swap(before, last);
            }
            let shorter = place.len() - 1;
            place = place.get_mut(..shorter).unwrap_or_default();
        }
    }
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_of_known_numbers() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), 3.0);
    }
}
