//! Innovations of a part's codes: a reading that no motion can produce is not believed, and a sensor without codes for
//! long is silent.

/// Largest believable innovation, in multiples of the usual (rms) one.
const SIGMAS: f32 = 6.0;
/// Averaging length of the usual innovation, frames.
const MEMORY: f32 = 16.0;
/// Frames after a start that only set the usual innovation, and are not believed.
const FIRST_FRAMES: f32 = 4.0;
/// Readings in a row at a new level from which it is believed, as no glitch, unless the sensor stands still there.
const JUMPED: u8 = 2;
/// Lost frames after which the next reading may have any code.
const MOST_LOST: u8 = 8;
/// Frames in a row without a sensor's codes from which it is silent: 0.25 s at 200 Hz. That is beyond what a sound part
/// leaves out (the BMI088's accelerometer single frames), beyond frames that a noisy bus spoils in a row, and two to
/// three times what a restart costs.
const CODELESS: u8 = 50;
/// Code changes after which an axis counts as alive.
const MOVES: u8 = 1;
/// Natural logarithm of the odds against chance at which a repeating axis is not believed: a false alarm in
/// some hundreds of millions of readings.
const DOUBTFUL: f32 = 20.0;
/// Odds, as a logarithm, at which zeros of an axis that moves by [`MOVING_CODES`] or more are not believed; a false
/// alarm in thousands does no harm there.
const DOUBTFUL_AT_ZERO: f32 = 8.0;
const MOVING_CODES: f32 = 8.0;
/// Odds, as a logarithm, at which a single exact zero, which is also what a dead axis reads, is not believed, nor a
/// jump with a single exact repeat: ln 25. An axis that passes zero loses at most one reading in twenty-five there.
const ZERO: f32 = 3.2;
/// Ratio of an axis's mean square code to its mean square step below which the axis hovers about zero and zeros are
/// common; steps of noise have twice the noise's mean square.
const HOVERING: f32 = 1.5;
/// Rms step by noise and motion, codes, below which zeros are common.
const LIVELY_CODES: f32 = 4.0;
/// Mean square that rounding adds to a step from code to code, codes squared.
const ROUNDING: f32 = 1.0 / 6.0;

/// Detector of codes of a vector sensor that no motion produces.
///
/// A part without a checksum cannot report a bit flipped on the wire; a reading that jumps and comes back
/// reveals it. A reading is expected on the straight line through the last two. Its innovation, the
/// difference from there, is limited to six times the usual one, and never to less than `sure`, which is
/// always believed. An axis that repeats itself, or reads exactly zero where another value is expected, while
/// it usually moves by many codes, is frozen or dead; the more codes it moves by, the sooner that shows.
/// After a start nothing is believed until every axis has moved and the usual innovation is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Innovation {
    axes: [Axis; 3],
    /// True if there is a last reading that was believed.
    begun: bool,
    /// Logarithm of the odds against chance that all axes repeat themselves.
    repeated: f32,
    jumps: u8,
    /// Frames lost or not believed before the next.
    skipped: u8,
    /// Frames without codes since the last with them, or since the part's start.
    codeless: u8,
    /// Number of frames in the means, at most [`MEMORY`].
    frames: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    last: i32,
    believed: i32,
    /// Change of the believed code from frame to frame.
    slope: i32,
    moves: u8,
    /// True if the last innovation was within the limit; a larger one does not set the slope.
    is_usual: bool,
    mean_square_code: f32,
    mean_square_step: f32,
    mean_square: f32,
    /// Logarithm of the odds against chance of the axis's repeats so far.
    repeated: f32,
}

impl Innovation {
    pub const NEW: Self = Self {
        axes: [Axis {
            last: 0,
            believed: 0,
            slope: 0,
            moves: 0,
            is_usual: false,
            mean_square_code: 0.0,
            mean_square_step: 0.0,
            mean_square: 0.0,
            repeated: 0.0,
        }; 3],
        begun: false,
        repeated: 0.0,
        jumps: 0,
        skipped: 0,
        codeless: 0,
        frames: 0.0,
    };

    /// Natural logarithm of the odds against chance that all axes repeat themselves since the last change.
    pub const fn repeated(&self) -> f32 {
        self.repeated
    }

    /// Accounts for frames lost before the next one.
    pub fn skip(&mut self, lost: u32) {
        let lost = u8::try_from(lost).unwrap_or(u8::MAX);
        self.skipped = self.skipped.saturating_add(lost);
        self.begun &= self.skipped < MOST_LOST;
    }

    /// Accounts for a frame without codes.
    pub fn misses(&mut self) {
        self.codeless = self.codeless.saturating_add(1);
        self.skip(1);
    }

    /// Returns true if the sensor is silent, while frames of its part may come.
    pub const fn is_silent(&self) -> bool {
        self.codeless >= CODELESS
    }

    /// Returns true if these raw codes are to be believed. What differs from the expected codes by at most `sure` per
    /// frame is no jump. A code of `clip_code` or more, either sign, is at the end of the range, where it may repeat.
    /// Else repeats of all axes are not believed beyond [odds](Self::repeated) of `repeats`.
    pub fn believes(&mut self, codes: [i32; 3], sure: f32, clip_code: i32, repeats: f32) -> bool {
        self.codeless = 0;
        let frames = i32::from(self.skipped) + 1;
        let first = self.frames == 0.0;
        self.frames = if self.frames < MEMORY { self.frames + 1.0 } else { MEMORY };
        let learning = self.frames <= FIRST_FRAMES;
        let (mut jumped, mut stuck, mut doubtful, mut stand, mut odds) = (false, false, false, true, 0.0);
        let mut repeats_one = false;
        for (axis, code) in self.axes.iter_mut().zip(codes) {
            if first {
                // The first frame has no frame before it to be compared with.
                axis.last = code;
                continue;
            }
            let stands = code == axis.last && code.abs() < clip_code;
            let (strange, zero) =
                if self.begun { axis.innovation(code, frames, sure, learning, self.frames) } else { (false, 0.0) };
            jumped |= strange;
            stuck |= strange && stands;
            let of_repeat = axis.repeats(code, stands, zero, clip_code);
            odds += of_repeat;
            repeats_one |= stands && of_repeat > ZERO;
            doubtful |= axis.repeated > DOUBTFUL;
            stand &= stands;
            axis.last = code;
        }
        self.repeated = if stand && !first { self.repeated + odds } else { 0.0 };
        // Codes that jump and then repeat an axis are those of a line that idles within a reading, whose first bytes
        // are still the part's.
        stuck |= repeats_one && (jumped || self.jumps > 0);
        self.jumps = if jumped || stuck { self.jumps.saturating_add(1) } else { 0 };
        let alive = self.axes.iter().all(|axis| axis.moves >= MOVES);
        if doubtful || self.repeated > repeats || stuck || (jumped && self.jumps < JUMPED) {
            self.skip(1);
            return false;
        }
        for (axis, code) in self.axes.iter_mut().zip(codes) {
            axis.slope = match (self.begun, axis.is_usual) {
                (true, true) => code.saturating_sub(axis.believed) / frames,
                (true, false) if jumped => 0,
                _ => axis.slope,
            };
            axis.believed = code;
        }
        (self.begun, self.jumps, self.skipped) = (true, 0, 0);
        alive && !learning
    }
}

impl Axis {
    /// Returns true if a code's innovation is beyond the limit, and the log odds against chance of the code if it is
    /// zero. Updates the usual innovation.
    fn innovation(&mut self, code: i32, frames: i32, sure: f32, learning: bool, memory: f32) -> (bool, f32) {
        let size =
            libm::fabsf(code.saturating_sub(self.believed).saturating_sub(self.slope.saturating_mul(frames)) as f32)
                / frames as f32;
        let usual = libm::sqrtf(if self.mean_square > 1.0 { self.mean_square } else { 1.0 });
        let limit = SIGMAS * usual;
        // A reading after one beyond the limit may be as far from it as that one was from the truth.
        let sure = if self.is_usual { sure } else { 2.0 * sure };
        self.is_usual = size <= limit;
        // The first frames set the usual innovation, however large theirs is.
        let within = if size > limit && !learning { limit } else { size };
        self.mean_square += (within * within - self.mean_square) / memory;
        self.mean_square_code += (code as f32 * code as f32 - self.mean_square_code) / memory;
        let step = code.saturating_sub(self.last) as f32;
        self.mean_square_step += (step * step - self.mean_square_step) / memory;
        (
            !learning && size > limit && (size > sure || code == 0),
            if code == 0 { odds_of_zero(size, usual * usual) } else { 0.0 },
        )
    }

    /// Adds the log odds that a code repeats by chance, or is a zero by chance (`zero`: log odds by its innovation).
    /// Returns the log odds of one repeat.
    fn repeats(&mut self, code: i32, stands: bool, zero: f32, clip_code: i32) -> f32 {
        let odds = odds_of_zero(0.0, self.mean_square_step - ROUNDING);
        self.repeated = if stands { self.repeated + odds } else { 0.0 };
        let zeros = || self.mean_square_step >= MOVING_CODES * MOVING_CODES && self.repeated + odds > DOUBTFUL_AT_ZERO;
        let lively = self.mean_square_step >= LIVELY_CODES * LIVELY_CODES;
        // A zero of an axis that hovers about zero is wrong by no more than its noise.
        let hovers = self.mean_square_code <= HOVERING * self.mean_square_step;
        let from_last = || !stands && odds_of_zero(self.last as f32, self.mean_square_step) > ZERO;
        if code == 0 && ((lively && !hovers && (zero > ZERO || from_last())) || zeros()) {
            // Doubt the axis until its code is no zero any more.
            self.repeated += 2.0 * DOUBTFUL;
        }
        if code != self.last || code.abs() >= clip_code {
            self.moves = self.moves.saturating_add(1);
        }
        odds
    }
}

/// Natural logarithm of the odds against a normal deviate rounding to zero, by its mean and variance in codes. With
/// mean zero the chance is 1 / sqrt(2 pi variance) for a large variance, and goes to one for a small: the formula is
/// within 6 % of the chance of a rounded difference of two, and never too small.
fn odds_of_zero(mean: f32, variance: f32) -> f32 {
    if variance <= 0.0 {
        return 0.0;
    }
    libm::logf(1.0 + core::f32::consts::TAU * variance) / 2.0 + mean * mean / (2.0 * variance)
}

#[cfg(test)]
mod tests;
