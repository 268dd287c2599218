use nalgebra::Vector3;

/// Smoothing of what readings vary by, seconds. Of what is doubted the gate counts, so that a turn by a radian is in doubt until it is some ten
/// thousand times: for two seconds, in which the filter finds out.
const SMOOTHING_S: f32 = 1.0;
/// By how much they vary before any was seen: beyond the earth's field.
const UNKNOWN_UT: f32 = 100.0;
/// What is so many times the mean square is no noise: of three axes one reading in a thousand (chi-square).
const GATE: f32 = 16.27 / 3.0;

/// By how far the earth's field seems to have turned since it last agreed with the attitude, reading by reading.
///
/// The field stands still, so that it is the attitude that turned, if it is no disturbance that came: until the filter has found out which,
/// the attitude may be off by as much. A gyro that fails while the probe turns is off by degrees within a hundredth of a second.
pub(super) struct TurnedField {
    /// As it agreed last, NED; zero before.
    agreed_ut: Vector3<f32>,
    /// Mean square of what readings differ from it by.
    noise_ut2: f32,
    /// By how much more the last one did.
    doubt_ut2: f32,
}

impl TurnedField {
    /// All zero, for a static.
    pub(super) const fn new() -> Self {
        Self { agreed_ut: Vector3::new(0.0, 0.0, 0.0), noise_ut2: 0.0, doubt_ut2: 0.0 }
    }

    /// Begins with no reading in doubt.
    pub(super) const fn start(&mut self) {
        self.noise_ut2 = UNKNOWN_UT * UNKNOWN_UT;
    }

    /// The mean field of a step, NED, that agreed with the attitude: it counts if there is no doubt at its end.
    pub(super) fn agree(&mut self, field_ut: &Vector3<f32>) {
        if self.doubt_ut2 <= 0.0 {
            self.agreed_ut = *field_ut;
        }
    }

    /// Takes in a reading, NED; whether it is in doubt.
    pub(super) fn observe(&mut self, field_ut: &Vector3<f32>, step_s: f32) -> bool {
        let square = (field_ut - self.agreed_ut).norm_squared();
        let beyond = square - GATE * self.noise_ut2;
        self.doubt_ut2 = if beyond > 0.0 { beyond } else { 0.0 };
        self.noise_ut2 += (square - self.doubt_ut2 - self.noise_ut2) * (step_s / SMOOTHING_S);
        self.doubt_ut2 > 0.0
    }

    /// What is in doubt already is so by no less than this, rad^2.
    pub(super) fn doubt_at_least(&mut self, square: f32) {
        let square_ut2 = square * self.agreed_ut.norm_squared();
        if self.doubt_ut2 > 0.0 && square_ut2 > self.doubt_ut2 {
            self.doubt_ut2 = square_ut2;
        }
    }

    /// Square of the angle in doubt, rad^2: the chord's.
    pub(super) fn doubt(&self) -> f32 {
        if self.doubt_ut2 > 0.0 { self.doubt_ut2 / self.agreed_ut.norm_squared() } else { 0.0 }
    }
}
