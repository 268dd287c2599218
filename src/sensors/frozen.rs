/// One axis counts as frozen after this many times the frames of a whole sensor: one axis may read the same by chance more easily than three.
const AXIS: u16 = 3;
/// Counted frames end here: it takes some changes to be believed again.
const MOST: u16 = 4 * AXIS;

/// Watches a vector sensor's codes for an output that does not change any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) struct Frozen {
    last: [i32; 3],
    same: [u16; 3],
}

impl Frozen {
    /// Whether these are the codes of the last frame.
    pub fn saw(&self, codes: [i32; 3]) -> bool {
        self.last == codes
    }

    /// Whether the sensor is frozen, with these codes. At the end of its range (`clip_code`) an axis may stand still.
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
