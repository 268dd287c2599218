//! Closing of an update or a window: the globals become a posterior, piece by piece. The covariance is gathered,
//! averaged over the widths of the priors, and inflated by the effects that are taken out; where a search follows, its
//! cost is bounded.

use super::{Posterior, Refusal, averaging::Averaging, filter::Filter, real::Real, window_cost::Centre};
use heapless::Vec;

/// Work units of the pieces: the largest cost of each kind that a flight has shown, in cycles, over
/// [`UNIT_CYCLES`](super::UNIT_CYCLES).
const START_UNITS: u32 = 320;
const GATHERING_UNITS: u32 = 70;
// A vector of 300, and its narrowing: both levels of a set of widths less what is averaged at them.
const INFLATING_UNITS: u32 = 500;
const CENTRE_UNITS: u32 = 420;
const BOUND_UNITS: u32 = 160;
const CONCLUDING_UNITS: u32 = 260;
/// Columns of the root's inverse that are gathered in one piece.
const GATHERED: usize = 4;

/// Piece of the closing in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    /// No posterior is being made.
    Idle,
    /// One is asked for, once the filter has no work in progress.
    Asked,
    /// Gathers the globals' covariance, from this column of the root's inverse on.
    Gathering(usize),
    /// Averages the posterior.
    Averaging,
    /// Adds the uncertainty of the effects that are taken out to the covariance, one after the other.
    Inflating(usize),
    /// Gathers the bound of the search's cost, from this node on.
    Bounding(usize),
}

/// A posterior in the making, and the latest one. The scratch memory of the filter's update holds the numbers between
/// the pieces.
pub(super) struct Closing<T> {
    task: Task,
    averaging: Averaging<T>,
    /// True if a search follows.
    is_searched: bool,
    /// Numbers of the request in progress and of the latest one: only the latest one's posterior counts.
    number: u8,
    latest: u8,
    // Not `Option`s: these would not be all zero bytes.
    centre: Vec<Centre, 1>,
    posterior: Vec<Posterior, 1>,
    /// See [`Estimator::nis_of_claims`](super::Estimator::nis_of_claims).
    nis_of_claims: [f32; 2],
}

impl<T: Real> Closing<T> {
    /// Without a posterior.
    pub const fn zero() -> Self {
        Self {
            task: Task::Idle,
            averaging: Averaging::zero(),
            is_searched: false,
            number: 0,
            latest: 0,
            centre: Vec::new(),
            posterior: Vec::new(),
            nis_of_claims: [0.0; 2],
        }
    }

    /// Forgets what belongs to a filter that has begun anew; the latest posterior stays.
    pub fn begin(&mut self) {
        self.task = Task::Idle;
        self.averaging = Averaging::zero();
        self.centre.clear();
    }

    /// Drops the latest posterior, and the one in the making when it is done. Returns the number of the next request.
    pub fn expect_another(&mut self) -> u8 {
        self.posterior.clear();
        self.nis_of_claims = [0.0; 2];
        self.latest = self.latest.wrapping_add(1);
        self.latest
    }

    /// The latest posterior, once it is done.
    pub fn posterior(&self) -> Option<&Posterior> {
        self.posterior.first()
    }

    /// NIS beside the latest posterior: that of the filter that it is of, also where this has begun anew since.
    pub const fn nis_of_claims(&self) -> [f32; 2] {
        self.nis_of_claims
    }

    /// Centre of the search about the latest posterior; `None` before one that a search follows.
    pub fn centre(&self) -> Option<&Centre> {
        self.centre.first().filter(|_| !self.posterior.is_empty())
    }

    /// The average, when it is about to begin.
    #[cfg(feature = "explanation")]
    pub fn fresh_average(&self) -> Option<&Averaging<T>> {
        (self.task == Task::Averaging && self.averaging.is_fresh()).then_some(&self.averaging)
    }

    /// Returns true if a posterior is being made.
    pub fn is_busy(&self) -> bool {
        self.task != Task::Idle
    }

    /// Asks for a posterior.
    pub fn ask(&mut self, is_searched: bool, number: u8) {
        (self.is_searched, self.number) = (is_searched, number);
        self.centre.clear();
        self.task = Task::Asked;
    }

    /// Begins to make a posterior of a filter that has no work in progress.
    // Not inlined, nor are the pieces below: the cost of each kind of work is counted by its function's calls.
    #[inline(never)]
    fn start<const NODES: usize, const E: usize>(&mut self, filter: &mut Filter<T, NODES, E>) {
        self.averaging.start(&filter.globals, &filter.settings.widths, &mut filter.update.rows);
        self.task = Task::Gathering(0);
    }

    /// Does one bounded piece of work; returns its size in units, 0 if there is none.
    pub fn step<const NODES: usize, const E: usize>(&mut self, filter: &mut Filter<T, NODES, E>) -> u32 {
        match self.task {
            Task::Idle => 0,
            Task::Asked => {
                self.start(filter);
                START_UNITS
            }
            Task::Gathering(from) => {
                self.gather(filter, from);
                GATHERING_UNITS
            }
            Task::Averaging => {
                let units = self.averaging.units();
                if self.mix(filter) {
                    return units;
                }
                self.task = Task::Inflating(0);
                self.put_centre(filter);
                CENTRE_UNITS
            }
            Task::Inflating(of) => {
                if self.inflate(filter, of) {
                    return INFLATING_UNITS;
                }
                if self.is_searched {
                    self.task = Task::Bounding(0);
                    return INFLATING_UNITS;
                }
                self.conclude(filter);
                CONCLUDING_UNITS
            }
            Task::Bounding(from) => {
                if self.bound(filter, from) {
                    self.conclude(filter);
                    return BOUND_UNITS + CONCLUDING_UNITS;
                }
                BOUND_UNITS
            }
        }
    }

    /// Gathers the covariance from some columns of the root's inverse.
    #[inline(never)]
    fn gather<const NODES: usize, const E: usize>(&mut self, filter: &mut Filter<T, NODES, E>, from: usize) {
        let more = self.averaging.gather(from..from + GATHERED, &mut filter.update.rows);
        self.task = if more { Task::Gathering(from + GATHERED) } else { Task::Averaging };
    }

    /// Adds one set of widths to the average; `false` when all are in.
    #[inline(never)]
    fn mix<const NODES: usize, const E: usize>(&mut self, filter: &mut Filter<T, NODES, E>) -> bool {
        self.averaging.step(&mut filter.update.rows)
    }

    /// Ends the average, and puts the centre of a search there.
    #[inline(never)]
    fn put_centre<const NODES: usize, const E: usize>(&mut self, filter: &Filter<T, NODES, E>) {
        self.averaging.finish(filter.has_measured_bias);
        self.centre.clear();
        if !self.is_searched {
            return;
        }
        let averaged = self.averaging.result();
        let inflations = filter.settings.widths.inflations;
        let inflation = inflations.iter().fold(1.0_f32, |most, x| if *x > most { *x } else { most });
        let (mean, covariance) = (averaged.mean.map(|x| x.narrow()), averaged.covariance.map(|x| x.narrow()));
        if let Some(centre) = Centre::new(&filter.left_over, &mean, &covariance, inflation) {
            // Just emptied, so there is room.
            let _ = self.centre.push(centre);
        }
    }

    /// Inflates the gyro's covariance by the uncertainty of the effects that are taken out, one vector a call; `false`
    /// after the last.
    #[inline(never)]
    fn inflate<const NODES: usize, const E: usize>(&mut self, filter: &mut Filter<T, NODES, E>, of: usize) -> bool {
        let account = &filter.evidence.account;
        if of >= account.taken.len() {
            return false;
        }
        let taken = (account.taken.as_slice(), account.covariance.as_slice());
        let as_flown = (&filter.parameters.inverse(), &filter.prior.sigma);
        let by = filter.candidates.inflation(of, taken, &filter.globals, as_flown);
        self.averaging.inflate(&by, &mut filter.update.rows);
        self.task = Task::Inflating(of + 1);
        true
    }

    /// Bounds the search's cost by some nodes' rows; `true` when the bound is set.
    fn bound<const NODES: usize, const E: usize>(&mut self, filter: &mut Filter<T, NODES, E>, from: usize) -> bool {
        let Some(centre) = self.centre.first_mut() else { return true };
        let next = centre.bound_by_rows(&filter.left_over, from, filter.update.rows.as_flattened_mut());
        if let Some(next) = next {
            self.task = Task::Bounding(next);
        }
        next.is_none()
    }

    #[inline(never)]
    fn conclude<const NODES: usize, const E: usize>(&mut self, filter: &mut Filter<T, NODES, E>) {
        let posterior = filter.posterior_of(self.averaging.result());
        // The stored model is then that of another gyro.
        let is_forsaken = filter.prior.is_restored && matches!(posterior.fitness, Err(Refusal::Implausible { .. }));
        if self.number == self.latest {
            self.posterior.clear();
            let _ = self.posterior.push(posterior);
            self.nis_of_claims = filter.nis_of_claims();
        }
        self.task = Task::Idle;
        if filter.course.consistency.has_diverged() || is_forsaken {
            filter.begin();
            self.begin();
        } else if let Some(claim) =
            filter.candidates.old_step(&filter.evidence.account.claims, filter.course.weighed_us.unwrap_or_default())
        {
            filter.settle(&claim);
        }
    }
}
