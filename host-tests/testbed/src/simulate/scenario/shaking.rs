use serde::Deserialize;

/// Vibration while drilling.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Vibration {
    /// Broadband lateral acceleration, m/s^2 rms of each lateral axis's readings, aliasing included.
    /// Default 3.
    pub lateral_m_s2: f64,
    /// Broadband axial acceleration, m/s^2 rms of the readings. Default 2.
    pub axial_m_s2: f64,
    /// Frequency below which the broadband part falls off, Hz: a tool that stays in its hole has no slow
    /// acceleration. Default 2.
    pub lowest_hz: f64,
    /// Amplitude of the bit's chatter on every axis at the mean speed, m/s^2. It goes with the square of the
    /// speed (a constant stroke), so a stuck bit does not chatter. Default 1.
    pub chatter_m_s2: f64,
    /// Strokes of chatter per revolution (cutters of the bit). Default 15: 7.5 Hz at 30 rpm.
    pub chatter_order: u32,
    /// Angular vibration about each axis, deg/s rms. Default 1.
    pub angular_deg_s: f64,
    /// Band of the angular vibration, Hz. Default 5 to 20.
    pub angular_band_hz: [f64; 2],
}

impl Vibration {
    /// A tool that does not vibrate.
    #[must_use]
    pub fn none() -> Self {
        Self { lateral_m_s2: 0.0, axial_m_s2: 0.0, chatter_m_s2: 0.0, angular_deg_s: 0.0, ..Self::default() }
    }
}

impl Default for Vibration {
    fn default() -> Self {
        Self {
            lateral_m_s2: 3.0,
            axial_m_s2: 2.0,
            lowest_hz: 2.0,
            chatter_m_s2: 1.0,
            chatter_order: 15,
            angular_deg_s: 1.0,
            angular_band_hz: [5.0, 20.0],
        }
    }
}

/// Shocks while drilling: half-sine pulses at random (Poisson) instants, mostly lateral.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShockSettings {
    /// Mean number per minute. Default 20.
    pub per_minute: f64,
    /// Range of the peak, uniform, in g (9.80665 m/s^2). Default 5 to 20.
    pub peak_g: [f64; 2],
    /// Range of the length, uniform, milliseconds. Default 2 to 8.
    pub length_ms: [f64; 2],
    /// Length of the steady opposite acceleration after a pulse that takes its velocity out, milliseconds; 0
    /// for none: a tool in a hole goes nowhere. Default 50.
    pub rebound_ms: f64,
}

impl Default for ShockSettings {
    fn default() -> Self {
        Self { per_minute: 20.0, peak_g: [5.0, 20.0], length_ms: [2.0, 8.0], rebound_ms: 50.0 }
    }
}
