//! Whirl: the tool's axis goes around the hole's axis.
//!
//! A tool whose axis goes around the hole's has a lateral acceleration of constant size that turns with it. In tool
//! axes, which turn with the string, it turns at the difference of both speeds. Vibration to and fro does not turn. A
//! collar that rolls on the wall without sliding goes around against the string, d / (D - d) times as fast (collar d in
//! a hole D; Vandiver, Nicholson and Shyu, SPE Drilling Engineering 5, 282, 1990).

use core::f32::consts::TAU;

/// Time constant of the mean that is subtracted from lateral vibration, seconds: this removes forces that are constant
/// in tool axes, as the centrifugal force of an accelerometer off the axis, and also a whirl at the string's own speed
/// and direction.
const MEAN_S: f32 = 1.0;
/// Longest step between two readings in use, seconds.
const LONGEST_STEP_S: f32 = 0.05;

/// Turning of lateral vibration over a window, positive clockwise looking down-hole.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Whirl {
    /// Net share of the vibration that turns, in tool axes: 1 all clockwise, -1 all counter-clockwise, 0 to and fro, or
    /// without order.
    pub circularity: f32,
    /// Speed at which the vibration turns in space, revolutions per minute, weighted with its power. Vibration faster
    /// than half of the sample rate, in tool axes, appears slower (aliasing).
    pub rpm: f32,
}

/// Direction of a whirl.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum WhirlKind {
    /// The tool's axis goes around in the string's direction, and faster than the string.
    Forward,
    /// The tool's axis goes around against the string.
    Backward,
}

/// Sums of lateral vibration over one window.
pub(super) struct WhirlSums {
    last: Option<[f32; 2]>,
    mean: [f32; 2],
    /// Twice the area that the vibration sweeps, (m/s^2)^2.
    swept: f32,
    middle_square: f32,
    change_square: f32,
    angle_rad: f32,
    time_s: f32,
    steps: u32,
}

impl WhirlSums {
    pub(super) const fn new() -> Self {
        Self {
            last: None,
            mean: [0.0; 2],
            swept: 0.0,
            middle_square: 0.0,
            change_square: 0.0,
            angle_rad: 0.0,
            time_s: 0.0,
            steps: 0,
        }
    }

    /// Begins another window; the running mean of vibration is carried over.
    pub(super) const fn next(&self) -> Self {
        Self { last: self.last, mean: self.mean, ..Self::new() }
    }

    /// Takes lateral vibration, m/s^2, and the rate about the axis, rad/s.
    pub(super) fn add(&mut self, vibration: Option<[f32; 2]>, rate_rad_s: Option<f32>, step_s: f32) {
        let (Some([x, y]), Some(rate)) = (vibration, rate_rad_s) else {
            self.last = None;
            return;
        };
        if step_s > LONGEST_STEP_S {
            self.last = None;
        }
        let k = step_s / (MEAN_S + step_s);
        let [mean_x, mean_y] = self.mean;
        self.mean = [mean_x + k * (x - mean_x), mean_y + k * (y - mean_y)];
        let now = [x - mean_x, y - mean_y];
        let Some([x0, y0]) = self.last.replace(now) else { return };
        let [x, y] = now;
        let (middle, change) = ([0.5 * (x + x0), 0.5 * (y + y0)], [x - x0, y - y0]);
        self.swept += middle[0] * change[1] - middle[1] * change[0];
        self.middle_square += middle[0] * middle[0] + middle[1] * middle[1];
        self.change_square += change[0] * change[0] + change[1] * change[1];
        self.angle_rad += rate * step_s;
        self.time_s += step_s;
        self.steps = self.steps.saturating_add(1);
    }

    /// Returns circularity and speed of the whirl; `None` before two steps, or without vibration. A unit vector that
    /// turns by an angle a in each step changes by 2 sin(a / 2), and the middle of two is cos(a / 2) long.
    pub(super) fn whirl(&self) -> Option<Whirl> {
        let product = self.middle_square * self.change_square;
        let sound = self.steps >= 2 && product > 0.0 && self.time_s > 0.0;
        sound.then(|| {
            let step_s = self.time_s / self.steps as f32;
            let in_tool_rad_s = 2.0 * libm::atan2f(self.swept, 2.0 * self.middle_square) / step_s;
            Whirl {
                circularity: self.swept / libm::sqrtf(product),
                rpm: (in_tool_rad_s + self.angle_rad / self.time_s) * (60.0 / TAU),
            }
        })
    }
}
