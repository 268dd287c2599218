use super::{
    Prior, WindowReport,
    contest::{Contest, Known, MAX_GROUPS, MIN_GROUPS, Model, Outcome},
    least_squares::{self, Freedom, MagnetometerErrors, RowVariances},
    prior::{linear, theta_of},
    search::Search,
    whitening::Whitened,
};
use crate::{
    algebra::{Cholesky, Packed},
    compensation::GyroModel,
    config::IdentificationConfig,
    objective::{NoiseScales, TwoVector, noise_scales},
    optimizer::{LeastSquaresCost, Progress},
    window::{
        Block, MAGNETIC, NodeVectors, RestBias, SampleStream, Segment, VectorEffects, node_vectors, preintegrate,
    },
};
use nalgebra::Vector3;

/// Segments of one second in the longest window.
const SEGMENTS: usize = 50;

/// Half width of the search box in posterior deviations: the least-squares point is within a few of the optimum.
const RADIUS: f32 = 10.0;

/// Models of the magnetometer that compete before P is judged.
const MAGNETOMETER_MODELS: [Model; 3] = [
    (Freedom::Full, MagnetometerErrors::LagAndIron),
    (Freedom::Full, MagnetometerErrors::Lag),
    (Freedom::Full, MagnetometerErrors::None),
];

/// Most probable chance win from which an error of the magnetometer is kept: the usual 5 %, since keeping one too many costs
/// little.
const MAGNETOMETER_P_VALUE: f32 = 0.05;

/// The window being identified.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job {
    pub t_start_us: u64,
    pub t_end_us: u64,
    pub effect_us: u64,
    /// Increments of the window.
    pub from: u32,
    pub to: u32,
    pub rest: Option<RestBias>,
    pub rest_s: f32,
    /// Largest error of the norm of specific force at a rest until the close, m/s^2.
    pub rest_norm_error_m_s2: Option<f32>,
}

impl Job {
    const fn zero() -> Self {
        Self {
            t_start_us: 0,
            t_end_us: 0,
            effect_us: 0,
            from: 0,
            to: 0,
            rest: None,
            rest_s: 0.0,
            rest_norm_error_m_s2: None,
        }
    }
}

/// Where the identification of a window stands; each step does a bounded piece of it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Sum the blocks and solve the weak form.
    LeastSquares,
    /// Cross-validate, group by group, which errors of the magnetometer the window shows.
    Magnetometer(usize),
    /// Cross-validate P and bias.
    Gyro(usize),
    /// Build segment by segment at the least-squares solution.
    Segments(usize),
    /// Noise scales and whitening.
    Whiten,
    Search,
    /// Observability, uncertainty and acceptance.
    Judge,
}

/// What a fit needs to know beside its window.
pub(crate) struct Context<'a> {
    pub stream: &'a SampleStream,
    pub config: &'a IdentificationConfig,
    pub factory: &'a GyroModel,
    pub flown: &'a GyroModel,
    /// Whether the configuration holds a calibration of the accelerometer.
    pub accelerometer_on_record: bool,
    pub seed: u64,
}

/// The identification of one window, resumable: from blocks of weak-form equations to a report.
pub(crate) struct WindowFit {
    phase: Phase,
    pub job: Job,
    pub(super) prior: Prior,
    pub(super) total: Block,
    solution: [f32; MAGNETIC],
    pub(super) variances: RowVariances,
    pub(super) contest: Contest,
    pub(super) magnetometer: MagnetometerErrors,
    pub(super) theta0: [f32; 12],
    last_node: NodeVectors,
    segments: [Segment; SEGMENTS],
    segment_count: usize,
    scales: NoiseScales,
    whitening: Option<Cholesky<12, 78>>,
    search: Search,
}

/// What one step of a fit came to.
#[expect(clippy::large_enum_variant, reason = "nothing here can be boxed, and a step is taken apart at once")]
pub(crate) enum Step {
    /// A piece of this many work units is done, and there is more.
    More(u32),
    /// The report stands.
    Done(WindowReport),
    /// The window's samples were overwritten before the fit came to them.
    Overtaken,
}

impl WindowFit {
    pub const fn zero() -> Self {
        const NO_SEGMENT: Segment = Segment::zero();
        Self {
            phase: Phase::LeastSquares,
            job: Job::zero(),
            prior: Prior::zero(),
            total: Block::zero(),
            solution: [0.0; MAGNETIC],
            variances: RowVariances { gravity: 0.0, field: 0.0 },
            contest: Contest::zero(),
            magnetometer: MagnetometerErrors::None,
            theta0: [0.0; 12],
            last_node: NodeVectors { gravity: None, field: None },
            segments: [NO_SEGMENT; SEGMENTS],
            segment_count: 0,
            scales: NoiseScales::zero(),
            whitening: None,
            search: Search::None,
        }
    }

    pub fn start(&mut self, job: Job) {
        self.job = job;
        self.phase = Phase::LeastSquares;
        self.segment_count = 0;
        self.total = Block::zero();
        self.contest = Contest::zero();
    }

    /// One bounded piece of work.
    pub fn step(&mut self, context: &Context) -> Step {
        let next = match self.phase {
            Phase::LeastSquares => self.least_squares(context).map(|()| Phase::Magnetometer(0)),
            Phase::Magnetometer(group) => match self.play(context, group, &MAGNETOMETER_MODELS) {
                Some(true) => Some(Phase::Magnetometer(group + 1)),
                Some(false) => self.choose_magnetometer(context).map(|()| Phase::Gyro(0)),
                None => None,
            },
            Phase::Gyro(group) => {
                let freedoms = [Freedom::Full, Freedom::Bias([0.0; 9]), Freedom::Nothing];
                let models = freedoms.map(|freedom| (freedom, self.magnetometer));
                let more = self.play(context, group, &models);
                more.map(|more| if more { Phase::Gyro(group + 1) } else { Phase::Segments(0) })
            }
            Phase::Segments(index) => match self.build_segment(context, index) {
                Some(true) => Some(Phase::Segments(index + 1)),
                Some(false) => Some(Phase::Whiten),
                None => return Step::Overtaken,
            },
            Phase::Whiten => self.whiten(context).map(|()| Phase::Search),
            Phase::Search => Some(if self.search() == Progress::Done { Phase::Judge } else { Phase::Search }),
            Phase::Judge => return Step::Done(self.judged(context)),
        };
        let units = self.units();
        match next {
            Some(phase) => {
                self.phase = phase;
                Step::More(units)
            }
            None => Step::Done(self.without_fit(context)),
        }
    }

    /// Size of a step of the present phase, in work units: evaluations of one segment, some 300 instructions each.
    fn units(&self) -> u32 {
        match self.phase {
            Phase::LeastSquares => 500,
            Phase::Magnetometer(_) | Phase::Gyro(_) => 200,
            Phase::Segments(_) => 60,
            Phase::Whiten => 150,
            Phase::Search => self.segment_count as u32 + 1,
            Phase::Judge => 0,
        }
    }

    fn least_squares(&mut self, context: &Context) -> Option<()> {
        self.prior = Prior::new(context.config, context.factory, self.job.rest.as_ref());
        for number in context.stream.blocks_within(self.job.from, self.job.to) {
            self.total.add(context.stream.block(number)?);
        }
        self.magnetometer = MagnetometerErrors::LagAndIron;
        self.solve(context)
    }

    /// Solves the weak form with the chosen errors of the magnetometer; a contest about that solution begins.
    fn solve(&mut self, context: &Context) -> Option<()> {
        let theta = theta_of(context.flown);
        let (solution, variances) =
            least_squares::solve_with_variances(&self.total, &self.prior, &theta, self.magnetometer)?;
        self.solution = solution;
        self.variances = variances;
        let change = least_squares::gyro_part(&solution);
        for ((theta0, theta), change) in self.theta0.iter_mut().zip(&theta).zip(&change) {
            *theta0 = theta + change;
        }
        self.contest = Contest::zero();
        Some(())
    }

    /// Keeps those errors of the magnetometer that predict unseen blocks better, and solves again with them: an error that is
    /// there and left out bends P; one that is not there and kept only costs precision (a hard iron looks like a
    /// cross-coupling from the axis that turns).
    fn choose_magnetometer(&mut self, context: &Context) -> Option<()> {
        let shows = |outcome: Outcome| outcome.p_value <= MAGNETOMETER_P_VALUE;
        let enough = self.contest.groups() >= MIN_GROUPS;
        self.magnetometer = if !enough || shows(self.contest.first_against_second()) {
            MagnetometerErrors::LagAndIron
        } else if shows(self.contest.second_against_third()) {
            MagnetometerErrors::Lag
        } else {
            MagnetometerErrors::None
        };
        self.solve(context)
    }

    /// Plays group `group` of the contest; `Some(false)` when there is none left.
    fn play(&mut self, context: &Context, group: usize, models: &[Model; 3]) -> Option<bool> {
        let stream = context.stream;
        let numbers = stream.blocks_within(self.job.from, self.job.to);
        let is_filled = |number: &u32| stream.block(*number).is_some_and(|block| !block.is_empty());
        let filled = numbers.clone().filter(is_filled).count();
        let groups = if filled < MAX_GROUPS { filled } else { MAX_GROUPS };
        if group >= groups {
            return Some(false);
        }
        // The filled blocks are dealt out evenly, contiguous ones to a group.
        let share = |g: usize| (g * filled).checked_div(groups).unwrap_or(0);
        let mut unseen = Block::zero();
        let mine = share(group)..share(group + 1);
        for number in numbers.filter(is_filled).skip(mine.start).take(mine.len()) {
            unseen.add(stream.block(number)?);
        }
        let theta = theta_of(context.flown);
        let everything = least_squares::gyro_part(&self.solution);
        let known = Known { variances: &self.variances, prior: &self.prior, theta: &theta };
        self.contest.play(&self.total, &unseen, models, &known, &everything)?;
        Some(true)
    }

    /// Builds node `index` and the segment that ends there; false when the window holds no such node, `None` when its samples
    /// have been overwritten.
    fn build_segment(&mut self, context: &Context, index: usize) -> Option<bool> {
        let grid = context.stream.grid;
        let ring = &context.stream.increments;
        let (half, length) = (grid.increments_in(0.5) as u32, grid.increments_in(1.0) as u32);
        let node = self.job.from + half + index as u32 * length;
        if node + half >= self.job.to {
            return Some(false);
        }
        if !ring.holds(node - if index == 0 { half } else { length }) {
            return None;
        }
        let (p, c) = linear(&self.theta0);
        let [.., lag, x, y, z] = self.solution;
        let effects = VectorEffects { mag_lag_s: lag, hard_iron_ut: Vector3::new(x, y, z) };
        let vectors = node_vectors(ring, grid, node, (&p, &c), &effects);
        let rotation = if index == 0 { None } else { preintegrate(ring, grid, (node - length, node), (&p, &c)) };
        if let (Some(slot), Some(rotation)) = (self.segments.get_mut(self.segment_count), rotation) {
            *slot = Segment::new(&rotation, &self.last_node, &vectors, context.config.max_bias_rad_s);
            self.segment_count += 1;
        }
        self.last_node = vectors;
        Some(true)
    }

    pub(super) fn segments(&self) -> &[Segment] {
        self.segments.get(..self.segment_count).unwrap_or_default()
    }

    pub(super) fn objective(&self) -> TwoVector<'_> {
        TwoVector { segments: self.segments(), scales: &self.scales, prior: &self.prior, theta0: &self.theta0 }
    }

    fn whiten(&mut self, context: &Context) -> Option<()> {
        if self.segment_count == 0 {
            return None;
        }
        self.scales = noise_scales(self.segments());
        let start = [0.0; 12];
        let mut normal = Packed::zero();
        self.objective().normal_equations(&start, &mut normal, &mut [0.0; 12]);
        self.whitening = Some(normal.cholesky()?);
        let config = context.config;
        self.search = Search::new(config.optimizer, config.max_evaluations, context.seed ^ self.job.t_end_us);
        Some(())
    }

    fn search(&mut self) -> Progress {
        let Some(factor) = &self.whitening else { return Progress::Done };
        let objective = TwoVector {
            segments: self.segments.get(..self.segment_count).unwrap_or_default(),
            scales: &self.scales,
            prior: &self.prior,
            theta0: &self.theta0,
        };
        self.search.step(&Whitened { cost: &objective, factor, radius: RADIUS })
    }

    /// The optimum found, about theta0, and the evaluations spent.
    pub(super) fn optimum(&self) -> ([f32; 12], u32) {
        let (x, whitened) = self.search.best();
        let x = match &self.whitening {
            Some(factor) if whitened => factor.solve_upper(&x.map(|y| RADIUS * y)),
            _ => x,
        };
        (x, self.search.evaluations())
    }
}
