/// A step within so many times the usual one is believed.
const SIGMAS: f32 = 6.0;
/// The usual step is the root mean square over about so many frames.
const MEMORY: f32 = 16.0;
/// A reading of a sensor that has jumped is believed from the third on: it was no glitch.
const JUMPED: u8 = 3;
/// Natural logarithm of the odds against chance from which a repeated output, or an exact zero, is not believed. What is lost by one wrong
/// alarm in 150 such frames is one frame.
const DOUBTFUL: f32 = 5.0;
/// Chance that a normally distributed step is zero, times its deviation in codes.
const DENSITY_AT_ZERO: f32 = 0.4;

/// Watches the steps from frame to frame of a vector sensor's codes for what no motion makes.
///
/// A part without a checksum cannot say that a bit was flipped on the wire; a reading that jumps and comes back says it. The limit of a step is
/// six times the usual one, and never less than `sure`: a step so small is always believed. An axis that repeats itself, or reads exactly
/// zero, while it usually moves by many codes, is frozen or dead; the more codes it usually moves by, the sooner that shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Innovation {
    /// The last codes that were believed, and the last ones.
    believed: [i32; 3],
    last: [i32; 3],
    mean_square: [f32; 3],
    /// Odds against chance of the repeats so far, of each axis and of all.
    repeated: [f32; 3],
    all_repeated: f32,
    jumps: u8,
    begun: bool,
}

impl Innovation {
    pub const NEW: Self = Self {
        believed: [0; 3],
        last: [0; 3],
        mean_square: [0.0; 3],
        repeated: [0.0; 3],
        all_repeated: 0.0,
        jumps: 0,
        begun: false,
    };

    /// The next codes do not follow upon the last: frames were lost between them.
    pub const fn interrupt(&mut self) {
        self.begun = false;
    }

    /// Whether these codes are to be believed. `sure`: a step of so many codes always is. A code of `clip_code` or more, either sign, is at the
    /// end of the range, where it may stand still.
    pub fn believes(&mut self, codes: [i32; 3], sure: f32, clip_code: i32) -> bool {
        if !self.begun {
            *self = Self { believed: codes, last: codes, jumps: 0, begun: true, ..*self };
            return true;
        }
        let (mut jumped, mut doubtful, mut all) = (false, false, 0.0_f32);
        let mut repeats = true;
        let axes =
            self.mean_square.iter_mut().zip(&mut self.repeated).zip(self.believed.iter().zip(self.last).zip(codes));
        for ((mean_square, repeated), ((believed, last), code)) in axes {
            let step = (code - believed) as f32;
            let usual = SIGMAS * libm::sqrtf(if *mean_square > 1.0 { *mean_square } else { 1.0 });
            let size = libm::fabsf(step);
            let limit = if sure > usual { sure } else { usual };
            jumped |= size > limit || (code == 0 && size > usual);
            let within = if size > usual { usual } else { size };
            *mean_square += (within * within - *mean_square) / MEMORY;
            let odds = libm::logf(usual / (SIGMAS * DENSITY_AT_ZERO));
            let stands = (code == last || code == 0) && code.abs() < clip_code;
            *repeated = if stands { *repeated + odds } else { 0.0 };
            doubtful |= *repeated > DOUBTFUL;
            repeats &= code == last && code.abs() < clip_code;
            all += odds;
        }
        self.all_repeated = if repeats { self.all_repeated + all } else { 0.0 };
        self.last = codes;
        doubtful |= self.all_repeated > DOUBTFUL;
        self.jumps = if jumped { self.jumps.saturating_add(1) } else { 0 };
        if doubtful || (jumped && self.jumps < JUMPED) {
            return false;
        }
        self.jumps = 0;
        self.believed = codes;
        true
    }
}
