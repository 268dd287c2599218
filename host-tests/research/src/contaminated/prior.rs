use super::readings::{Matrix12, Theta, identity};

/// Prior of theta from the data sheet: independent normals.
#[derive(Clone, Debug)]
pub(super) struct Prior {
    pub mean: Theta,
    pub sigma: Theta,
}

impl Prior {
    /// The library's prior: 0.06 on the diagonal of P, 0.03 off it, 1.2 deg/s of bias.
    pub fn data_sheet() -> Self {
        let sigma = Theta::from_fn(|i, _| match i {
            0 | 4 | 8 => 0.06,
            0..9 => 0.03,
            _ => 0.021,
        });
        Self { mean: identity(), sigma }
    }

    pub fn information(&self) -> Matrix12 {
        Matrix12::from_diagonal(&self.sigma.map(|s| 1.0 / (s * s)))
    }

    /// Half the squared distance from the mean, in deviations.
    pub fn cost(&self, theta: &Theta) -> f64 {
        0.5 * (theta - self.mean).component_div(&self.sigma).norm_squared()
    }
}
