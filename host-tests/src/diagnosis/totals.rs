//! Size and dip of what the vector sensors read at the end of a recording.

use nalgebra::Vector3;

/// Time before the end that is looked at, seconds.
const LAST_S: f64 = 1.0;

/// |G|, |B| and dip of a recording's last second: mean readings as they flew, turned to one attitude by the gyro;
/// `None` without a usable reading. Vibration averages out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Size of the specific force.
    pub gravity_m_s2: Option<f64>,
    /// Size of the field.
    pub field_ut: Option<f64>,
    /// Angle of the field below the horizon.
    pub dip_deg: Option<f64>,
}

/// Gathers them from the readings of a recording.
#[derive(Default)]
pub(super) struct Gathered {
    from_s: f64,
    gaps: u32,
    /// Sum and number of the readings of force and of field.
    sums: [(Vector3<f64>, u32); 2],
}

impl Gathered {
    /// Before the first reading of a recording that ends at `end_s`.
    pub fn until(end_s: f64) -> Self {
        Self { from_s: end_s - LAST_S, ..Self::default() }
    }

    /// Takes in force and field at a time, turned to one attitude. `gaps`: number of gaps until then, across which the
    /// gyro does not turn.
    pub fn push(&mut self, t_s: f64, gaps: u32, vectors: &[Option<Vector3<f64>>; 2]) {
        if t_s < self.from_s {
            return;
        }
        if gaps != self.gaps {
            *self = Self { from_s: self.from_s, gaps, ..Self::default() };
        }
        for ((sum, count), vector) in self.sums.iter_mut().zip(vectors) {
            if let Some(vector) = vector {
                *sum += vector;
                *count += 1;
            }
        }
    }

    /// Those of the means.
    pub fn totals(&self) -> Totals {
        let [force, field] = self.sums.map(|(sum, count)| (count > 0).then(|| sum / f64::from(count)));
        let sine = |(force, field): (Vector3<f64>, Vector3<f64>)| -force.dot(&field) / (force.norm() * field.norm());
        let dip = force.zip(field).map(|both| sine(both).asin().to_degrees());
        Totals {
            gravity_m_s2: force.map(|mean| mean.norm()),
            field_ut: field.map(|mean| mean.norm()),
            dip_deg: dip.filter(|dip| dip.is_finite()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_second_counts_without_its_vibration_and_without_what_is_before_a_gap() {
        let mut gathered = Gathered::until(5.0);
        let dip = 0.7_f64;
        for k in 0..=50_u32 {
            let (t_s, gaps) = (0.1 * f64::from(k), u32::from(k > 43));
            let vibration = if k % 2 == 0 { 3.0 } else { -3.0 };
            let force = Vector3::new(vibration, 0.0, -9.8);
            let scale = if gaps == 0 { 30.0 } else { 50.0 };
            let field = Vector3::new(dip.cos(), 0.0, dip.sin()) * scale;
            // Seven readings are behind the gap, four of them with the vibration up; the field lacks in the last.
            gathered.push(t_s, gaps, &[Some(force).filter(|_| k > 42), Some(field).filter(|_| k < 50)]);
        }
        let Totals { gravity_m_s2, field_ut, dip_deg } = gathered.totals();
        let near = |x: Option<f64>, expected: f64| x.is_some_and(|x| (x - expected).abs() < 1e-9);
        let mean = Vector3::new(3.0 / 7.0, 0.0, -9.8);
        assert!(near(gravity_m_s2, mean.norm()), "{gravity_m_s2:?}");
        assert!(near(field_ut, 50.0), "{field_ut:?}");
        let sine = (9.8 * dip.sin() - 3.0 / 7.0 * dip.cos()) / mean.norm();
        assert!(near(dip_deg, sine.asin().to_degrees()), "{dip_deg:?}");
        assert_eq!(Gathered::until(0.0).totals(), Totals::default());
    }
}
