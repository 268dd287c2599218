//! Frozen sensors of a part, told by codes that do not change.

/// Factor on the frozen-frame threshold for a single axis, which by chance repeats itself more easily than three.
const AXIS: u16 = 3;
/// Limit of the counted frames, in thresholds of a whole sensor: a few changes make an axis believable again.
const MOST: u16 = 4 * AXIS;

/// Detector of a vector sensor whose codes do not change any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) struct Frozen {
    last: [i32; 3],
    same: [u16; 3],
}

impl Frozen {
    /// Returns true if these are the codes of the last frame.
    pub fn saw(&self, codes: [i32; 3]) -> bool {
        self.last == codes
    }

    /// Takes codes. Returns true if the sensor is frozen: all axes unchanged for `frames` frames, or one for three
    /// times as many. An axis may stand still at the end of its range (`clip_code`).
    pub fn sees(&mut self, codes: [i32; 3], clip_code: i32, frames: u16) -> bool {
        let axes = self.same.iter_mut().zip(self.last).zip(codes);
        for ((same, last), code) in axes {
            let stands = code == last && code.abs() < clip_code;
            *same = if stands { (*same + 1).min(frames.saturating_mul(MOST)) } else { *same / 2 };
        }
        self.last = codes;
        self.same.iter().all(|same| *same >= frames)
            || self.same.iter().any(|same| *same >= frames.saturating_mul(AXIS))
    }
}
