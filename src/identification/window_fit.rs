use super::{
    Carried, Forgetting, WindowCost, WindowReport, innovation_fit::InnovationFit, robust_weights::Round,
    search::Search, weak_fit::WeakFit,
};
use crate::{
    algebra::{Cholesky, Packed, dot, minus, plus},
    compensation::{GyroModel, VectorModel},
    config::Config,
    objective::Innovations,
    optimizer::{LeastSquaresCost, Progress},
    window::{RestBias, SampleStream},
};

/// The window being identified.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job {
    pub t_start_us: u64,
    pub t_end_us: u64,
    pub effect_us: u64,
    /// Increments of the window.
    pub from: u32,
    pub to: u32,
    /// The bias from rests until the close.
    pub rest: Option<RestBias>,
    /// The same with what the effects that are taken out added to it.
    pub rest_as_read: Option<RestBias>,
    /// Whether a rest came after what the flown bias was learnt from.
    pub rest_is_news: bool,
    pub rest_s: f32,
    /// Largest error of the norm of specific force at a rest until the close, m/s^2.
    pub rest_norm_error_m_s2: Option<f32>,
}

impl Job {
    pub const fn zero() -> Self {
        Self {
            t_start_us: 0,
            t_end_us: 0,
            effect_us: 0,
            from: 0,
            to: 0,
            rest: None,
            rest_as_read: None,
            rest_is_news: false,
            rest_s: 0.0,
            rest_norm_error_m_s2: None,
        }
    }
}

/// Where the identification of a window stands; each step does a bounded piece of it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Sum the test windows' equations, slice by slice.
    Sum(usize),
    /// Weigh those down that a disturbance bends, slice by slice.
    Weigh(usize),
    /// Solve them.
    LeastSquares,
    /// Cross-validate, group by group, which errors of the magnetometer the window shows.
    Magnetometer(usize),
    /// Cross-validate P and bias.
    Gyro(usize),
    /// Make node by node at the least-squares solution.
    Nodes(usize),
    /// Noise scales and whitening.
    Whiten,
    Search,
    /// Observability, uncertainty and acceptance.
    Judge,
}

/// What a fit needs to know beside its window.
pub(crate) struct Context<'a> {
    pub stream: &'a SampleStream,
    pub config: &'a Config,
    pub flown: &'a GyroModel,
}

impl Context<'_> {
    /// How fast what earlier windows taught goes stale.
    pub const fn forgetting(&self) -> Forgetting {
        Forgetting {
            bias_walk_rad_s_rts: self.config.attitude.gyro_bias_walk_rad_s_rts,
            forgetting_s: self.config.identification.forgetting_s,
        }
    }

    /// Whether the configuration holds a calibration of the accelerometer.
    pub fn accelerometer_on_record(&self) -> bool {
        self.config.accel != VectorModel::IDENTITY
    }
}

/// The identification of one window, resumable: from its test windows' equations to a report.
pub(crate) struct WindowFit {
    phase: Phase,
    pub job: Job,
    pub(super) weak: WeakFit,
    pub(super) innovations: InnovationFit,
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
        Self {
            phase: Phase::Sum(0),
            job: Job::zero(),
            weak: WeakFit::zero(),
            innovations: InnovationFit::zero(),
            whitening: None,
            search: Search::None,
        }
    }

    /// Begins with what earlier windows taught.
    pub fn start(&mut self, context: &Context, job: Job, carried: &Carried) {
        self.job = job;
        self.phase = Phase::Sum(0);
        let middle_us = job.t_start_us + (job.t_end_us - job.t_start_us) / 2;
        self.weak.start(context, &job, &carried.aged(middle_us, &context.forgetting()));
    }

    /// One bounded piece of work.
    pub fn step(&mut self, context: &Context) -> Step {
        let Self { weak, job, .. } = self;
        let next = match self.phase {
            Phase::Sum(slice) => weak.sum(context.stream, job, slice).map(|more| match more {
                true => Phase::Sum(slice + 1),
                false => Phase::LeastSquares,
            }),
            Phase::Weigh(slice) => Some(match weak.weigh(context.stream, job, slice) {
                true => Phase::Weigh(slice + 1),
                false => Phase::LeastSquares,
            }),
            Phase::LeastSquares => match weak.solve_alone(context.stream, job) {
                Some(Round::Next) => Some(Phase::Weigh(0)),
                Some(Round::Again) => Some(Phase::Sum(0)),
                Some(Round::Done) => {
                    weak.solve().and_then(|()| weak.measure_doubt(context.stream, job)).map(|()| Phase::Magnetometer(0))
                }
                None => None,
            },
            Phase::Magnetometer(group) => match weak.play_magnetometer(context.stream, job, group) {
                Some(true) => Some(Phase::Magnetometer(group + 1)),
                Some(false) => weak.choose_magnetometer().map(|()| Phase::Gyro(0)),
                None => None,
            },
            Phase::Gyro(group) => weak.play_gyro(context, job, group).map(|more| match more {
                true => Phase::Gyro(group + 1),
                false => Phase::Nodes(0),
            }),
            Phase::Nodes(index) => match self.innovations.take_node(context, job, weak, index) {
                Some(true) => Some(Phase::Nodes(index + 1)),
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

    /// Size of a step of the present phase, in work units: some 300 instructions each.
    fn units(&self) -> u32 {
        match self.phase {
            Phase::Sum(_) | Phase::Weigh(_) => 150,
            Phase::LeastSquares => 500,
            Phase::Magnetometer(_) | Phase::Gyro(_) => 200,
            Phase::Nodes(_) => 30,
            Phase::Whiten => 150,
            Phase::Search => 40,
            Phase::Judge => 0,
        }
    }

    /// The cost of the window that is being identified or was the last to be, once its innovations stand.
    pub fn cost(&self) -> Option<WindowCost<'_>> {
        let stands = matches!(self.phase, Phase::Search | Phase::Judge);
        self.whitening.as_ref().filter(|_| stands).map(|factor| WindowCost { objective: self.objective(), factor })
    }

    pub(super) fn objective(&self) -> Innovations<'_> {
        self.innovations.objective(&self.weak.prior)
    }

    fn whiten(&mut self, context: &Context) -> Option<()> {
        self.innovations.rescale()?;
        let start = [0.0; 12];
        let mut normal = Packed::zero();
        self.objective().normal_equations(&start, &mut normal, &mut [0.0; 12]);
        self.whitening = Some(normal.cholesky()?);
        let Config { seed, identification, .. } = context.config;
        self.search = Search::new(identification.optimizer, identification.max_evaluations, seed ^ self.job.t_end_us);
        Some(())
    }

    fn search(&mut self) -> Progress {
        let Some(factor) = &self.whitening else { return Progress::Done };
        let objective = self.innovations.objective(&self.weak.prior);
        self.search.step(&WindowCost { objective, factor })
    }

    /// The optimum found, about theta0, and the evaluations spent.
    pub(super) fn optimum(&self) -> ([f32; 12], u32) {
        (self.cost().map_or([0.0; 12], |cost| self.search.best(&cost)), self.search.evaluations())
    }

    /// Carries on what the samples until `until_us` taught, which no later window will hold: the innovations of the stretches that
    /// lie before, which know of none that comes after.
    pub fn learn(&self, context: &Context, until_us: u64, carried: &mut Carried) {
        if self.phase != Phase::Judge {
            return;
        }
        let Job { t_start_us, t_end_us, .. } = self.job;
        let learned_us = until_us.min(t_end_us).saturating_sub(t_start_us);
        let (delta, _) = self.optimum();
        let (normal, descent) = self.innovations.lesson(learned_us, &delta);
        let theta = plus(&self.innovations.theta0, &delta);
        let middle_us = t_start_us + learned_us / 2;
        *carried = carried.aged(middle_us, &context.forgetting());
        carried.learn(middle_us, &theta, &normal, &descent);
    }

    /// Squared distance between what the window says by itself and what was carried into it, in their deviations: chi-square with 12
    /// degrees of freedom when nothing has changed.
    ///
    /// At the optimum the carried information pulls with u = L (m - x), L its matrix and m its mean, and all else holds against it.
    /// Without it the optimum would lie W^-1 u farther from m, W being the information of all else, so the two are
    /// (W^-1 + L^-1) u apart and the distance is u' (W^-1 + L^-1) u.
    pub(super) fn contradiction(&self) -> f32 {
        let carried = self.weak.carried();
        let (delta, _) = self.optimum();
        let theta = plus(&self.innovations.theta0, &delta);
        let (mut normal, mut descent) = (Packed::zero(), [0.0; 12]);
        self.objective().normal_equations(&delta, &mut normal, &mut descent);
        normal.add_scaled(&carried.information, -1.0);
        let pull = carried.information.times(&minus(&carried.mean, &theta));
        normal.cholesky().map_or(0.0, |alone| dot(&alone.solve(&pull), &pull)) + carried.distance(&theta)
    }
}
