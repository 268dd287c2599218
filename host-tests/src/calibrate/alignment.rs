//! Alignment of the magnetometer's axes with the accelerometer's: the angle between gravity and field is the
//! same at every rest.
//!
//! A small turn of the magnetometer's axes changes the cosine of that angle by its component along field x
//! gravity, the east-west direction in sensor axes. Once that direction has been all around, the turn is
//! fully determined. While the probe turns about one horizontal line only, a turn about the east-west part of
//! that line looks like another dip.

use nalgebra::{Matrix4, Rotation3, SVector, Vector3, Vector4};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::{model::Model, rests::Rest, verdict::LARGEST_HARMLESS_RAD};

/// The alignment that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// Number of rests with both sensors.
    pub rests: usize,
    /// Rotation vector from the magnetometer's axes to the accelerometer's, rad.
    pub turn_rad: [f64; 3],
    /// Deviation of each component.
    pub sigma_rad: [f64; 3],
    /// Number of deviations that the true value exceeds once in twenty.
    pub quantile: f64,
    /// Dip of the field below the horizontal, rad.
    pub dip_rad: f64,
    /// Deviation of the dip from rest to rest, rad: before and after.
    pub scatter_rad: (f64, f64),
    /// Reason why the alignment is not applied; `None` if it is.
    pub refused: Option<String>,
}

/// Limit of Gauss-Newton steps; three are needed.
const STEPS: usize = 20;

/// Finds the alignment; `None` without a rest that has both sensors.
#[must_use]
pub fn align(rests: &[Rest], accel: &Model, mag: &Model) -> Option<Alignment> {
    let both = |rest: &Rest| {
        Some((accel.calibrate(&rest.accel?.vector).normalize(), mag.calibrate(&rest.mag?.vector).normalize()))
    };
    let pairs: Vec<(Vector3<f64>, Vector3<f64>)> = rests.iter().filter_map(both).collect();
    if pairs.is_empty() {
        return None;
    }
    // The accelerometer reads upwards, so the cosine is minus the sine of the dip.
    let sine = |pair: &(Vector3<f64>, Vector3<f64>), turn: &Rotation3<f64>| -pair.0.dot(&(turn * pair.1));
    let mean = |turn: &Rotation3<f64>| pairs.iter().map(|pair| sine(pair, turn)).sum::<f64>() / pairs.len() as f64;
    let mut turn = Rotation3::identity();
    let mut dip_sine = mean(&turn);
    let before = scatter(&pairs, &turn, dip_sine, pairs.len() as f64 - 1.0);
    let mut information = Matrix4::zeros();
    for _ in 0..STEPS {
        let mut gradient = Vector4::zeros();
        information = Matrix4::zeros();
        for pair in &pairs {
            let field = turn * pair.1;
            // d(-g . (w x b)) = -w . (b x g)
            let east = field.cross(&pair.0);
            let row = Vector4::new(-east.x, -east.y, -east.z, -1.0);
            gradient += row * (sine(pair, &turn) - dip_sine);
            information += row * row.transpose();
        }
        let Some(cholesky) = information.cholesky() else { break };
        let step: SVector<f64, 4> = -cholesky.solve(&gradient);
        turn = Rotation3::new(step.fixed_rows::<3>(0).into_owned()) * turn;
        dip_sine += step[3];
        // A step that does not settle belongs to an angle that the rests hardly show; the deviations say so.
        if !(1e-12..1.0).contains(&step.amax()) {
            break;
        }
    }
    let freedom = pairs.len() as f64 - 4.0;
    let after = scatter(&pairs, &turn, dip_sine, freedom);
    let dip_cosine = (1.0 - dip_sine * dip_sine).max(1e-6).sqrt();
    let deviation = after * dip_cosine;
    let inverse = information.try_inverse();
    let sigma_rad =
        std::array::from_fn(|k| inverse.map_or(f64::INFINITY, |inverse| deviation * inverse[(k, k)].max(0.0).sqrt()));
    let quantile = StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975));
    let bound = quantile * sigma_rad.iter().fold(0.0, |largest: f64, sigma| largest.max(*sigma));
    let limit = LARGEST_HARMLESS_RAD.to_degrees();
    // Conditions are written for what passes, so that a NaN is refused.
    let refused = if freedom < 1.0 {
        Some(format!("{} rests for three angles and the dip leave nothing to check them by", pairs.len()))
    } else if bound < LARGEST_HARMLESS_RAD {
        None
    } else if bound < 1.0 {
        Some(format!("an angle can be off by {:.2} deg (95 %), {limit:.1} are allowed", bound.to_degrees()))
    } else {
        Some("east-west has not been seen all around by the probe: an angle looks like another dip".into())
    };
    let turn_rad = turn.scaled_axis();
    Some(Alignment {
        rests: pairs.len(),
        turn_rad: turn_rad.into(),
        sigma_rad,
        quantile,
        dip_rad: dip_sine.clamp(-1.0, 1.0).asin(),
        scatter_rad: (before, after),
        refused,
    })
}

/// Standard deviation of the dip, rad.
fn scatter(pairs: &[(Vector3<f64>, Vector3<f64>)], turn: &Rotation3<f64>, dip_sine: f64, freedom: f64) -> f64 {
    let square: f64 = pairs.iter().map(|pair| (-pair.0.dot(&(turn * pair.1)) - dip_sine).powi(2)).sum();
    (square / freedom.max(1.0)).sqrt() / (1.0 - dip_sine * dip_sine).max(1e-6).sqrt()
}

impl Alignment {
    /// The magnetometer's model with the alignment applied, if it is accepted.
    #[must_use]
    pub fn applied(&self, mag: &Model) -> Model {
        let turn = Rotation3::new(Vector3::from(self.turn_rad));
        if self.refused.is_some() { *mag } else { Model { matrix: turn.matrix() * mag.matrix, ..*mag } }
    }
}
