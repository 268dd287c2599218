//! Proportions of a run: how long it lasts, how long the tool drills and stops, and how often something goes wrong.

/// Durations of what happens in a run, from and to, seconds, and how often it does.
#[derive(Clone, Copy, Debug)]
pub struct Proportions {
    /// Length of the run.
    pub length_s: f64,
    /// Rest before the first stretch of drilling.
    pub first_rest_s: [f64; 2],
    /// A stretch of drilling.
    pub drilling_s: [f64; 2],
    /// Rest after a stretch.
    pub rest_s: [f64; 2],
    /// Mean time from one trouble to the next; a run draws one of these.
    pub pauses_s: &'static [f64],
    /// Mean time from one wish of the owner to the next.
    pub owner_s: f64,
    /// Share of the stretches before which the inertial part falls silent.
    pub silent_starts: f64,
    /// Time without power after a cut.
    pub unpowered_s: [f64; 2],
    /// True if windows are 10 s long and not as they fly, so that there are some between two troubles.
    pub short_windows: bool,
    /// True if surveys settle and average in 2 s and not as they fly, so that a short stop gives one.
    pub short_surveys: bool,
    /// True if the hole has another direction at the end.
    pub hole_curves: bool,
    /// Share of runs in which no power cut and no hang is planned, so that counters go on from the first to the last
    /// second.
    pub goes_through: f64,
    /// Time after a step of the clock in which a survey's age is not judged.
    pub clock_settles_s: f64,
    /// Sequence number of the host's first command.
    pub first_sequence: u16,
}

/// Length of a whole day, seconds.
pub const DAY_S: f64 = 86_400.0;

/// A day in three minutes, with a trouble every few seconds.
pub const ATTACK: Proportions = Proportions {
    length_s: 180.0,
    first_rest_s: [4.0, 9.0],
    drilling_s: [5.0, 16.0],
    rest_s: [4.0, 8.0],
    pauses_s: &[1.5, 4.0, 12.0],
    owner_s: 2.5,
    silent_starts: 0.15,
    unpowered_s: [0.01, 1.5],
    short_windows: true,
    short_surveys: true,
    hole_curves: false,
    goes_through: 0.0,
    clock_settles_s: 60.0,
    first_sequence: 0,
};

/// Fewer troubles and windows of the length that flies, so that what is learnt is what would be.
pub const CALM: Proportions = Proportions {
    length_s: 600.0,
    pauses_s: &[45.0],
    // A change by the owner starts the pipeline afresh.
    owner_s: 60.0,
    silent_starts: 0.01,
    short_windows: false,
    ..ATTACK
};

/// A day of 24 hours, with stops a few times an hour, everything as it flies, and a trouble every few minutes. A
/// quarter of these days is without a restart.
pub const WHOLE_DAY: Proportions = Proportions {
    length_s: DAY_S,
    first_rest_s: [20.0, 120.0],
    drilling_s: [300.0, 1_500.0],
    rest_s: [60.0, 300.0],
    pauses_s: &[100.0, 200.0, 400.0],
    owner_s: 600.0,
    silent_starts: 0.05,
    unpowered_s: [0.01, 60.0],
    short_windows: false,
    short_surveys: false,
    hole_curves: true,
    goes_through: 0.25,
    clock_settles_s: 60.0,
    // It wraps within the day.
    first_sequence: u16::MAX - 100,
};
