use serde::Deserialize;

/// Vibration while drilling.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Vibration {
    /// Broadband lateral acceleration, m/s^2 rms of each of the two axes' readings (what aliases into them included). Default 3.
    pub lateral_m_s2: f64,
    /// Broadband axial acceleration, m/s^2 rms of the readings. Default 2.
    pub axial_m_s2: f64,
    /// The broadband part falls off below this frequency, Hz: a tool that stays in its hole has no slow acceleration. Default 2.
    pub lowest_hz: f64,
    /// Acceleration of the bit's chatter on every axis, amplitude at the mean speed, m/s^2; it goes with the square of the speed
    /// (a constant stroke, so that nothing is left of it where the bit sticks). Default 1.
    pub chatter_m_s2: f64,
    /// Strokes of the chatter in one revolution (cutters of the bit). Default 15: 7.5 Hz at 30 rpm.
    pub chatter_order: u32,
    /// Angular vibration about each axis, deg/s rms. Default 1.
    pub angular_deg_s: f64,
    /// Band of the angular vibration, Hz. Default 5 to 20.
    pub angular_band_hz: [f64; 2],
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
    /// Mean number in a minute. Default 20.
    pub per_minute: f64,
    /// Peak, uniform between these, in g (9.80665 m/s^2). Default 5 to 20.
    pub peak_g: [f64; 2],
    /// Length, uniform between these, milliseconds. Default 2 to 8.
    pub length_ms: [f64; 2],
    /// After a pulse a steady opposite acceleration of this length takes its velocity out again, milliseconds: a tool in a hole
    /// goes nowhere. 0: none. Default 50.
    pub rebound_ms: f64,
}

impl Default for ShockSettings {
    fn default() -> Self {
        Self { per_minute: 20.0, peak_g: [5.0, 20.0], length_ms: [2.0, 8.0], rebound_ms: 50.0 }
    }
}
