//! Sag of the bottom-hole assembly: the collar with the tool bends under its weight between its supports, and the tool
//! lies at another inclination than the hole. Off unless it is asked for.

use std::fmt;

/// Model by which the inclination is corrected for sag.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields, tag = "model", rename_all = "snake_case")]
pub enum Sag {
    /// A stated sag in a level hole, degrees, times the sine of the inclination: added to the measured inclination.
    Stated {
        /// Hole's less tool's inclination in a level hole, degrees.
        level_deg: f64,
    },
    /// A uniform collar on two supports without bending moments (stabilisers), submerged, straight without weight.
    Beam {
        /// Distance of the supports, metres.
        span_m: f64,
        /// Place of the tool, metres from the support nearer the bit.
        from_lower_support_m: f64,
        /// Outer diameter, metres.
        outer_m: f64,
        /// Inner diameter, metres.
        inner_m: f64,
        /// Density of the drilling fluid, kg/m^3.
        #[serde(default = "water")]
        mud_kg_m3: f64,
        /// Young's modulus of the collar, Pa. Default 1.93e11: non-magnetic austenitic steel (AISI 304).
        #[serde(default = "austenitic_pa")]
        young_pa: f64,
        /// Density of the collar, kg/m^3. Default 7,900 (the same steel).
        #[serde(default = "austenitic_kg_m3")]
        steel_kg_m3: f64,
    },
}

const fn water() -> f64 {
    1_000.0
}

const fn austenitic_pa() -> f64 {
    1.93e11
}

const fn austenitic_kg_m3() -> f64 {
    7_900.0
}

const GRAVITY_M_S2: f64 = 9.806_65;

impl Sag {
    /// Correction to add to a measured inclination, radians.
    ///
    /// The beam's slope at x from the lower support under the load w = weight a metre times sin(I) is w / (24 E J)
    /// (L^3 - 6 L x^2 + 4 x^3) (Euler and Bernoulli). Towards the lower support the tool points above the hole's axis
    /// and reads too large an inclination; towards the upper one, too small.
    #[must_use]
    pub fn correction_rad(&self, inclination_rad: f64) -> f64 {
        let sine = libm::sin(inclination_rad);
        match *self {
            Self::Stated { level_deg } => level_deg.to_radians() * sine,
            Self::Beam { span_m, from_lower_support_m, outer_m, inner_m, mud_kg_m3, young_pa, steel_kg_m3 } => {
                let area = std::f64::consts::FRAC_PI_4 * (outer_m * outer_m - inner_m * inner_m);
                let second_moment = std::f64::consts::PI / 64.0 * (outer_m.powi(4) - inner_m.powi(4));
                // Fluid inside and outside: the steel alone is lifted.
                let load = area * (steel_kg_m3 - mud_kg_m3) * GRAVITY_M_S2 * sine;
                let (l, x) = (span_m, from_lower_support_m);
                let shape = l * l * l - 6.0 * l * x * x + 4.0 * x * x * x;
                -load / (24.0 * young_pa * second_moment) * shape
            }
        }
    }
}

impl fmt::Display for Sag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let level_deg = self.correction_rad(std::f64::consts::FRAC_PI_2).to_degrees();
        match self {
            Self::Stated { .. } => write!(f, "stated: {level_deg:.3} deg in a level hole, by the sine of inclination"),
            Self::Beam { span_m, from_lower_support_m, .. } => write!(
                f,
                "of a beam of {span_m} m, the tool {from_lower_support_m} m above its lower support: {level_deg:.3} deg \
                 in a level hole"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPAN_M: f64 = 18.0;

    fn beam(from_lower_support_m: f64) -> Sag {
        Sag::Beam {
            span_m: SPAN_M,
            from_lower_support_m,
            outer_m: 0.17,
            inner_m: 0.08,
            mud_kg_m3: 1_200.0,
            young_pa: austenitic_pa(),
            steel_kg_m3: austenitic_kg_m3(),
        }
    }

    /// The slopes add up to the deflection in the middle, 5 w L^4 / (384 E J), and are opposite at the two supports.
    #[test]
    fn the_beam_bends_as_the_textbooks_does() {
        let level = std::f64::consts::FRAC_PI_2;
        let steps = 10_000;
        let step = SPAN_M / 2.0 / f64::from(steps);
        let middle: f64 = (0..steps).map(|k| -beam((f64::from(k) + 0.5) * step).correction_rad(level) * step).sum();
        let second_moment = std::f64::consts::PI / 64.0 * (0.17_f64.powi(4) - 0.08_f64.powi(4));
        let area = std::f64::consts::FRAC_PI_4 * (0.17 * 0.17 - 0.08 * 0.08);
        let load = area * (7_900.0 - 1_200.0) * GRAVITY_M_S2;
        let published = 5.0 * load * SPAN_M.powi(4) / (384.0 * 1.93e11 * second_moment);
        assert!((middle / published - 1.0).abs() < 1e-6, "{middle} {published}");
        let [lower, upper] = [0.0, SPAN_M].map(|x| beam(x).correction_rad(level));
        assert!(lower < 0.0 && (lower + upper).abs() < 1e-12);
        assert!(beam(SPAN_M / 2.0).correction_rad(level).abs() < 1e-12 && beam(3.0).correction_rad(0.0) == 0.0);
    }

    #[test]
    fn a_stated_sag_goes_with_the_sine_of_the_inclination() {
        let sag = Sag::Stated { level_deg: 0.3 };
        assert!((sag.correction_rad(30.0_f64.to_radians()).to_degrees() - 0.15).abs() < 1e-12);
    }
}
