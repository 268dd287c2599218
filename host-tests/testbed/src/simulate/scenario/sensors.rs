use serde::Deserialize;

/// The gyro: `raw = P^-1 w + b + noise`. Its 12 parameters are drawn, or given.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gyro {
    /// Standard deviation of P's diagonal about 1; no draw is nearer to 1 than half of it. Default 0.04.
    pub diagonal_sigma: f64,
    /// Standard deviation of P's off-diagonal; no draw is nearer to 0 than half of it. Default 0.02.
    pub off_diagonal_sigma: f64,
    /// Standard deviation of each axis of b, deg/s; no draw is nearer to 0 than half of it. Default 1.
    pub bias_sigma_deg_s: f64,
    /// P, row by row, instead of a draw.
    pub p: Option<[[f64; 3]; 3]>,
    /// b, deg/s, instead of a draw.
    pub bias_deg_s: Option<[f64; 3]>,
    /// White noise, deg/s per root hertz (angle random walk, deg per root second). Default 0.01.
    pub noise_deg_s_rthz: f64,
    /// Random walk of the bias, deg/s per root second. Default 0.001.
    pub bias_walk_deg_s_rts: f64,
    /// Resolution of the reading, deg/s. Default: unlimited.
    pub resolution_deg_s: Option<f64>,
    /// Full scale, deg/s. Default 2,000.
    pub full_scale_deg_s: Option<f64>,
}

impl Default for Gyro {
    fn default() -> Self {
        Self {
            diagonal_sigma: 0.04,
            off_diagonal_sigma: 0.02,
            bias_sigma_deg_s: 1.0,
            p: None,
            bias_deg_s: None,
            noise_deg_s_rthz: 0.01,
            bias_walk_deg_s_rts: 0.001,
            resolution_deg_s: None,
            full_scale_deg_s: Some(2000.0),
        }
    }
}

/// The accelerometer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Accelerometer {
    /// White noise, micro-g per root hertz. Default 200.
    pub noise_ug_rthz: f64,
    /// Resolution of the reading, m/s^2. Default: unlimited.
    pub resolution_m_s2: Option<f64>,
    /// Full scale, g. Default 16.
    pub full_scale_g: Option<f64>,
}

impl Default for Accelerometer {
    fn default() -> Self {
        Self { noise_ug_rthz: 200.0, resolution_m_s2: None, full_scale_g: Some(16.0) }
    }
}

/// The magnetometer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Magnetometer {
    /// White noise, microtesla rms of each reading. Default 0.2.
    pub noise_ut: f64,
    /// Resolution of the reading, microtesla. Default: unlimited.
    pub resolution_ut: Option<f64>,
    /// Full scale, microtesla. Default: unlimited.
    pub full_scale_ut: Option<f64>,
}

impl Default for Magnetometer {
    fn default() -> Self {
        Self { noise_ut: 0.2, resolution_ut: None, full_scale_ut: None }
    }
}
