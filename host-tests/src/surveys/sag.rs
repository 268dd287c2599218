//! Sag of the bottom-hole assembly: the collar with the tool bends under its weight between its supports, and the tool
//! lies at another inclination than the hole. Off unless it is asked for.

/// How the inclination is corrected for sag.
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
    /// (L^3 - 6 L x^2 + 4 x^3) (Euler and Bernoulli). Towards the lower support the tool points above the hole's axis and
    /// reads too large an inclination; towards the upper one, too small.
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
