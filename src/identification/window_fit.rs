use super::{
    Carried, WindowCost, WindowReport,
    job::{Context, Job},
    least_squares::ROUNDS,
    observability::Observability,
    refinement::Refinement,
    robust_weights::Round,
    weak_fit::WeakFit,
};
use crate::{algebra::plus, optimizer::Progress, window::TestWindows};
use core::mem::ManuallyDrop;

/// Increments whose test windows are made in one piece of work.
const INCREMENTS_IN_A_STEP: u32 = 16;

/// Where the identification of a window stands; each step does a bounded piece of it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Begin with test windows of the present length.
    Begin,
    /// Make them, some increments at a time.
    Tests,
    /// Sum their equations, slice by slice.
    Sum(usize),
    /// Weigh those down that a disturbance bends, slice by slice.
    Weigh(usize),
    /// Solve them by themselves, round by round.
    LeastSquares(u8),
    /// Find out which of them are disturbed.
    Doubt,
    /// Cross-validate, half a group at a time, which errors of the magnetometer the window shows.
    Magnetometer(usize),
    /// Solve them with those.
    Solve(u8),
    /// Cross-validate P and bias.
    Gyro(usize),
    /// Make node by node at the least-squares solution.
    Nodes(usize),
    /// Noise scales and whitening.
    Whiten,
    Search,
    /// What the window sees; whether that has been begun.
    Observe(bool),
    /// Whether it contradicts the ones before.
    Compare,
    /// Uncertainty and acceptance.
    Judge,
}

/// The identification of one window, resumable: from its test windows to a report.
pub(crate) struct WindowFit {
    phase: Phase,
    pub job: Job,
    pub(super) weak: WeakFit,
    material: Material,
}

/// What a fit works on: first the test windows; then, in the same memory, what follows their solution.
#[expect(clippy::large_enum_variant, reason = "the variants share static memory")]
// As wide as what it stands before is aligned: with padding after it a variant is written by way of the stack.
#[repr(u32)]
enum Material {
    // Nothing in either has to be dropped; with drop glue an assignment goes by way of the stack.
    Tests(ManuallyDrop<TestWindows>),
    Refinement(ManuallyDrop<Refinement>),
}

impl Material {
    // Constants of all zeros, so that they are written where they belong: the values would go by way of the stack.

    #[inline(never)]
    fn begin_tests(&mut self) {
        const TESTS: ManuallyDrop<TestWindows> = ManuallyDrop::new(TestWindows::zero());
        if !matches!(self, Self::Tests(_)) {
            *self = Self::Tests(TESTS);
        }
    }

    #[inline(never)]
    fn begin_refinement(&mut self) {
        const REFINEMENT: ManuallyDrop<Refinement> = ManuallyDrop::new(Refinement::zero());
        if !matches!(self, Self::Refinement(_)) {
            *self = Self::Refinement(REFINEMENT);
        }
    }
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
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            phase: Phase::Begin,
            job: Job::zero(),
            weak: WeakFit::zero(),
            material: Material::Tests(ManuallyDrop::new(TestWindows::zero())),
        }
    }

    /// Begins with what earlier windows taught.
    pub fn start(&mut self, context: &Context, job: Job, carried: &Carried) {
        self.job = job;
        self.phase = Phase::Begin;
        let middle_us = job.t_start_us + (job.t_end_us - job.t_start_us) / 2;
        self.weak.start(context, &job, &carried.aged(middle_us, &context.forgetting()));
        self.material.begin_tests();
    }

    /// One bounded piece of work.
    pub fn step(&mut self, context: &Context) -> Step {
        let units = self.units();
        let next = match self.phase {
            Phase::Judge => return Step::Done(self.judged(context)),
            Phase::Tests => match self.make_tests(context) {
                Some(next) => Some(next),
                None => return Step::Overtaken,
            },
            Phase::Nodes(index) => match self.take_node(context, index) {
                Some(true) => Some(Phase::Nodes(index + 1)),
                Some(false) => Some(Phase::Whiten),
                None => return Step::Overtaken,
            },
            Phase::Whiten | Phase::Search | Phase::Observe(_) | Phase::Compare => self.refine(context),
            phase => self.solve(context, phase),
        };
        match next {
            Some(phase) => {
                self.phase = phase;
                Step::More(units)
            }
            None => Step::Done(self.without_fit(context)),
        }
    }

    // Functions of their own, so that only one of them has its variables on the stack at a time.

    /// `None`: the samples have been overwritten.
    #[inline(never)]
    fn make_tests(&mut self, context: &Context) -> Option<Phase> {
        let Material::Tests(tests) = &mut self.material else { return None };
        tests.make(context.stream, INCREMENTS_IN_A_STEP).map(|more| if more { Phase::Tests } else { Phase::Sum(0) })
    }

    /// A piece of the least-squares solution and the contests about it; `None` when there is none.
    #[inline(never)]
    fn solve(&mut self, context: &Context, phase: Phase) -> Option<Phase> {
        let Self { weak, job, material: Material::Tests(tests), .. } = self else { return None };
        Some(match phase {
            Phase::Sum(slice) if weak.sum(tests, slice) => Phase::Sum(slice + 1),
            Phase::Weigh(slice) if weak.weigh(tests, slice) => Phase::Weigh(slice + 1),
            Phase::Sum(_) | Phase::Weigh(_) => Phase::LeastSquares(0),
            Phase::LeastSquares(ROUNDS) => match weak.next_weights(tests) {
                Round::Next => Phase::Weigh(0),
                Round::Again if weak.begin_again() => Phase::Begin,
                Round::Again | Round::Done => Phase::Doubt,
            },
            Phase::LeastSquares(round) => match weak.solve_alone(round) {
                Some(()) => Phase::LeastSquares(round + 1),
                None if weak.begin_again() => Phase::Begin,
                None => return None,
            },
            Phase::Begin => {
                tests.start(context.stream, (job.from, job.to), &weak.theta, weak.quarters);
                Phase::Tests
            }
            Phase::Doubt => {
                weak.solve()?;
                weak.measure_doubt(context, tests)?;
                Phase::Magnetometer(0)
            }
            Phase::Magnetometer(piece) if weak.play_magnetometer(context, tests, piece)? => {
                Phase::Magnetometer(piece + 1)
            }
            Phase::Magnetometer(_) => {
                weak.choose_magnetometer(context.stream.magnet_moved_us > job.t_start_us);
                Phase::Solve(0)
            }
            Phase::Solve(ROUNDS) => {
                weak.solve()?;
                Phase::Gyro(0)
            }
            Phase::Solve(round) => {
                weak.solve_alone(round)?;
                Phase::Solve(round + 1)
            }
            Phase::Gyro(piece) if weak.play_gyro(context, job, tests, piece)? => Phase::Gyro(piece + 1),
            _ => {
                weak.learn_from_rests(context)?;
                self.material.begin_refinement();
                Phase::Nodes(0)
            }
        })
    }

    /// Whether there was another node; `None`: its samples have been overwritten.
    #[inline(never)]
    fn take_node(&mut self, context: &Context, index: usize) -> Option<bool> {
        let Self { weak, job, material: Material::Refinement(refinement), .. } = self else { return None };
        refinement.innovations.take_node(context, job, weak, index)
    }

    /// A piece of the search; `None` when there is nothing to search over.
    #[inline(never)]
    fn refine(&mut self, context: &Context) -> Option<Phase> {
        let Self { phase, weak, job, material: Material::Refinement(refinement) } = self else { return None };
        Some(match phase {
            Phase::Whiten => {
                refinement.whiten(&weak.prior, context.config, job.t_end_us)?;
                Phase::Search
            }
            Phase::Search if refinement.step(&weak.prior) == Progress::Running => Phase::Search,
            Phase::Search => Phase::Observe(false),
            Phase::Observe(false) => {
                refinement.observe(&weak.prior, context.config);
                Phase::Observe(true)
            }
            Phase::Observe(true) if refinement.observability.as_mut().is_some_and(Observability::work) => {
                Phase::Observe(true)
            }
            Phase::Observe(true) => Phase::Compare,
            _ => {
                refinement.compare(weak);
                Phase::Judge
            }
        })
    }

    /// Size of a step of the present phase, in work units: some 300 instructions each.
    const fn units(&self) -> u32 {
        match self.phase {
            Phase::Tests => 6 * INCREMENTS_IN_A_STEP,
            Phase::Sum(_) | Phase::Weigh(_) => 150,
            Phase::Doubt => 500,
            Phase::LeastSquares(_) | Phase::Solve(_) | Phase::Begin => 150,
            Phase::Magnetometer(_) | Phase::Gyro(_) => 250,
            Phase::Nodes(_) => 45,
            Phase::Whiten | Phase::Observe(_) | Phase::Compare => 200,
            Phase::Search => 40,
            Phase::Judge => 0,
        }
    }

    pub(super) fn refinement(&self) -> Option<&Refinement> {
        if let Material::Refinement(refinement) = &self.material { Some(refinement) } else { None }
    }

    /// The cost of the window that is being identified or was the last to be, once its innovations stand.
    pub fn cost(&self) -> Option<WindowCost<'_>> {
        self.refinement()?.cost(&self.weak.prior)
    }

    /// Carries on what the samples until `until_us` taught, which no later window will hold: the innovations of the stretches that
    /// lie before, which know of none that comes after.
    pub fn learn(&self, context: &Context, until_us: u64, carried: &mut Carried) {
        let Some(refinement) = self.refinement().filter(|_| self.phase == Phase::Judge) else { return };
        let Job { t_start_us, t_end_us, .. } = self.job;
        let learned_us = until_us.min(t_end_us).saturating_sub(t_start_us);
        let (delta, _) = refinement.optimum(&self.weak.prior);
        let (normal, descent) = refinement.innovations.lesson(learned_us, &delta);
        let theta = plus(&refinement.innovations.theta0, &delta);
        let middle_us = t_start_us + learned_us / 2;
        *carried = carried.aged(middle_us, &context.forgetting());
        carried.learn(middle_us, &theta, &normal, &descent);
    }
}
