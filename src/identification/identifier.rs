#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Segments and groups are counted by loops over fixed arrays.

use super::{
    Decision, Prior, Refusal, WindowReport,
    acceptance::{self, Evidence},
    contest::{Contest, Known, MAX_GROUPS, MIN_GROUPS, Model, Outcome},
    least_squares::{self, Freedom, MagnetometerErrors, RowVariances},
    observability::Observability,
    prior::{model_of, theta_of},
    whitening::Whitened,
};
use crate::{
    algebra::{Cholesky, Packed, dot},
    compensation::GyroModel,
    config::{Config, IdentificationConfig, OptimizerKind},
    objective::{NoiseScales, TwoVector, noise_scales, turn},
    optimizer::{Cost, Imoa, ImoaSettings, LeastSquaresCost, LevenbergMarquardt, Progress},
    window::{
        Block, MAGNETIC, NodeVectors, Reading, RestBias, RestLimits, SampleStream, Scales, Segment, StreamSettings,
        VectorEffects, node_vectors, preintegrate,
    },
};
use heapless::{Deque, Vec};
use nalgebra::{Matrix3, Vector3};

/// Segments of one second in the longest window.
const SEGMENTS: usize = 50;

/// Members of the population: the fewest that never failed on simulated windows.
const POPULATION: usize = 12;

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

/// Reports waiting to be polled.
const PENDING: usize = 4;

/// The window being identified.
#[derive(Clone, Copy, Debug)]
struct Job {
    t_start_us: u64,
    t_end_us: u64,
    effect_us: u64,
    /// Increments of the window.
    from: u32,
    to: u32,
    rest: Option<RestBias>,
    rest_s: f32,
}

impl Job {
    const fn zero() -> Self {
        Self { t_start_us: 0, t_end_us: 0, effect_us: 0, from: 0, to: 0, rest: None, rest_s: 0.0 }
    }
}

/// Where the identification of a window stands; each step does a bounded piece of it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Idle,
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
    /// Observability and acceptance.
    Judge,
    Ready,
}

/// Windows of samples in, accepted models or reasoned refusals out.
pub(crate) struct Identifier {
    pub stream: SampleStream,
    config: IdentificationConfig,
    seed: u64,
    factory: GyroModel,
    flown: GyroModel,
    /// First sample and increment since the start or the last gap.
    stream_start_us: u64,
    stream_from: u32,
    next_close_us: u64,
    final_close_us: u64,
    phase: Phase,
    job: Job,
    prior: Prior,
    total: Block,
    solution: [f32; MAGNETIC],
    variances: RowVariances,
    contest: Contest,
    magnetometer: MagnetometerErrors,
    theta0: [f32; 12],
    last_node: NodeVectors,
    segments: [Segment; SEGMENTS],
    segment_count: usize,
    scales: NoiseScales,
    whitening: Option<Cholesky<12, 78>>,
    imoa: Imoa<12, POPULATION>,
    levenberg_marquardt: LevenbergMarquardt<12>,
    /// The result of the job, once it is judged.
    result: Vec<WindowReport, 1>,
    pending: Deque<WindowReport, PENDING>,
    /// Reports dropped because nobody polled them.
    pub reports_lost: u32,
    pub overruns: u32,
}

impl Identifier {
    pub const fn zero() -> Self {
        const NO_SEGMENT: Segment = Segment::zero();
        Self {
            stream: SampleStream::zero(),
            config: IdentificationConfig::UNSET,
            seed: 0,
            factory: GyroModel::UNSET,
            flown: GyroModel::UNSET,
            stream_start_us: 0,
            stream_from: 0,
            next_close_us: 0,
            final_close_us: 0,
            phase: Phase::Idle,
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
            imoa: Imoa::zero(),
            levenberg_marquardt: LevenbergMarquardt::zero(),
            result: Vec::new(),
            pending: Deque::new(),
            reports_lost: 0,
            overruns: 0,
        }
    }

    pub fn configure(&mut self, config: &Config) {
        let id = config.identification;
        self.config = id;
        self.seed = config.seed;
        self.factory = config.gyro;
        self.flown = config.gyro;
        self.final_close_us = config.freeze_at_us.map_or(u64::MAX, |t| t.saturating_sub(micros(id.latency_s)));
        // Ranges of the stored increments where the full scale is unknown: 4000 deg/s and 32 g, the widest of the parts in use,
        // and ten times the strongest field on earth.
        self.stream.configure(&StreamSettings {
            sample_period_us: config.sample_period_us,
            rest_limits: RestLimits { deviation_rad_s: id.rest_gyro_deviation_rad_s, bias_rad_s: id.max_bias_rad_s },
            bias_walk_rad_s_rts: config.attitude.gyro_bias_walk_rad_s_rts,
            gravity_m_s2: config.earth.gravity_m_s2,
            scales: Scales::new(
                config.full_scale.gyro_rad_s.unwrap_or(70.0),
                2.0 * config.full_scale.accel_m_s2.unwrap_or(160.0),
                2.0 * config.full_scale.mag_ut.unwrap_or(330.0),
            ),
        });
        self.phase = Phase::Idle;
        self.pending.clear();
    }

    pub const fn flown(&self) -> &GyroModel {
        &self.flown
    }

    /// Begins at the first sample of all.
    pub fn start(&mut self, t_us: u64) {
        let (p, c) = linear(&theta_of(&self.flown));
        self.stream.start(t_us, p, c);
        self.start_window(t_us);
    }

    /// A gap: the window in progress ends with the last sample before it, and another begins after it.
    pub fn gap(&mut self, last_us: u64, t_us: u64) {
        if self.next_close_us != u64::MAX {
            self.close(last_us, true);
        }
        self.stream.restart(t_us);
        self.start_window(t_us);
    }

    fn start_window(&mut self, t_us: u64) {
        self.stream_start_us = t_us;
        self.stream_from = self.stream.increments.count();
        self.schedule(t_us, t_us + micros(self.config.window_s));
    }

    /// Sets the next close: the regular one, or the last one before the freeze where that comes first or so soon after that
    /// the regular one's result would not have landed.
    fn schedule(&mut self, now_us: u64, regular_us: u64) {
        self.next_close_us = if now_us >= self.final_close_us {
            u64::MAX
        } else if regular_us.saturating_add(micros(self.config.latency_s)) > self.final_close_us {
            self.final_close_us
        } else {
            regular_us
        };
    }

    /// Before a sample is compensated: a result that is due takes effect. Returns whether the model changed.
    pub fn take_effect(&mut self, t_us: u64) -> bool {
        if self.phase == Phase::Idle || t_us < self.job.effect_us {
            return false;
        }
        let ready = self.phase == Phase::Ready;
        self.phase = Phase::Idle;
        let Some(mut report) = self.result.pop().filter(|_| ready) else {
            self.overruns += 1;
            let report = self.unidentified(&self.job, Refusal::Overrun);
            self.announce(report);
            return false;
        };
        report.t_effect_us = Some(t_us);
        let (old, new) = (theta_of(&self.flown), theta_of(&report.flown));
        let changed = report.flown != self.flown;
        if changed {
            let shift = core::array::from_fn(|i| new[i] - old[i]);
            let (p, c) = linear(&new);
            self.stream.change_model(p, c, &shift);
            self.flown = report.flown;
        }
        self.announce(report);
        changed
    }

    /// Takes one sample (raw rate, suspect when clipped or held; calibrated vectors).
    pub fn push(&mut self, t_us: u64, raw: Vector3<f32>, suspect: bool, gravity: Reading, field: Reading) {
        self.stream.push(t_us, raw, suspect, gravity, field);
        if t_us >= self.next_close_us {
            self.close(t_us, false);
            self.schedule(t_us, t_us + micros(self.config.step_s));
        }
    }

    /// Closes the window in progress: a job, or at once a report of why there is none.
    fn close(&mut self, t_us: u64, cut_by_gap: bool) {
        let count = self.stream.increments.count();
        let t_start_us = self.stream_start_us.max(t_us.saturating_sub(micros(self.config.window_s)));
        // A window is far shorter than the hour that 32 bits of microseconds hold.
        let length_us = (t_us - t_start_us) as u32;
        let kept = length_us.checked_div(self.stream.grid.interval_us).unwrap_or(0);
        let job = Job {
            t_start_us,
            t_end_us: t_us,
            effect_us: t_us.saturating_add(micros(self.config.latency_s)),
            from: self.stream_from.max(count.saturating_sub(kept)),
            to: count,
            rest: self.stream.rest_bias(t_us),
            rest_s: self.stream.rest_seconds(length_us / 1_000_000) as f32,
        };
        if u64::from(length_us) < micros(self.config.min_window_s) {
            let refusal = Refusal::WindowTooShort {
                length_s: length_us as f32 * 1e-6,
                needed_s: self.config.min_window_s,
                cut_by_gap,
            };
            let report = self.unidentified(&job, refusal);
            self.announce(report);
        } else if self.phase != Phase::Idle {
            self.overruns += 1;
            let report = self.unidentified(&job, Refusal::Overrun);
            self.announce(report);
        } else {
            self.job = job;
            self.result.clear();
            self.phase = Phase::LeastSquares;
        }
    }

    fn announce(&mut self, report: WindowReport) {
        if self.pending.push_back(report).is_err() {
            self.reports_lost += 1;
        }
    }

    /// The oldest report that nobody has taken.
    pub fn take_report(&mut self) -> Option<WindowReport> {
        self.pending.pop_front()
    }

    /// One bounded piece of work; returns its size in units (about one pre-integrated segment's evaluation each), 0 when
    /// there is nothing to do.
    pub fn step(&mut self) -> u32 {
        match self.phase {
            Phase::Idle | Phase::Ready => 0,
            Phase::LeastSquares => {
                self.phase = if self.least_squares().is_some() { Phase::Magnetometer(0) } else { self.give_up() };
                200
            }
            Phase::Magnetometer(group) => {
                self.phase = match self.play(group, &MAGNETOMETER_MODELS) {
                    Some(true) => Phase::Magnetometer(group + 1),
                    Some(false) if self.choose_magnetometer().is_some() => Phase::Gyro(0),
                    _ => self.give_up(),
                };
                200
            }
            Phase::Gyro(group) => {
                let models = [Freedom::Full, Freedom::Bias([0.0; 9]), Freedom::Nothing];
                self.phase = match self.play(group, &models.map(|freedom| (freedom, self.magnetometer))) {
                    Some(true) => Phase::Gyro(group + 1),
                    Some(false) => Phase::Segments(0),
                    None => self.give_up(),
                };
                200
            }
            Phase::Segments(index) => {
                self.phase = if self.build_segment(index) { Phase::Segments(index + 1) } else { Phase::Whiten };
                60
            }
            Phase::Whiten => {
                self.phase = if self.whiten().is_some() { Phase::Search } else { self.give_up() };
                150
            }
            Phase::Search => {
                let units = self.segment_count as u32 + 1;
                if self.search() == Progress::Done {
                    self.phase = Phase::Judge;
                }
                units
            }
            Phase::Judge => {
                let report = self.judge();
                self.phase = self.conclude(report.unwrap_or_else(|refusal| self.unidentified(&self.job, refusal)));
                300
            }
        }
    }

    /// Ends a job that could not be carried through.
    fn give_up(&mut self) -> Phase {
        let refusal = match self.fit_to_judge() {
            Ok(()) if self.total.is_empty() => Refusal::NotEnoughExcitation { rank: 0 },
            Ok(()) => Refusal::Degenerate,
            Err(refusal) => refusal,
        };
        self.conclude(self.unidentified(&self.job, refusal))
    }

    /// Keeps the result until it takes effect.
    fn conclude(&mut self, report: WindowReport) -> Phase {
        self.result.clear();
        // Just emptied, so there is room.
        let _ = self.result.push(report);
        Phase::Ready
    }

    fn fit_to_judge(&self) -> Result<(), Refusal> {
        acceptance::sensors_fit_to_judge(
            self.total.magnetic.rows,
            self.total.gravity.rows,
            self.stream.rest_norm_error_m_s2(),
        )
    }

    /// A report without a fit: only the bias may have moved, when there was a rest.
    fn unidentified(&self, job: &Job, refusal: Refusal) -> WindowReport {
        let (flown, bias_only) = self.with_rest_bias(job);
        let deviations = self.prior_sigma();
        WindowReport {
            t_start_us: job.t_start_us,
            t_end_us: job.t_end_us,
            t_effect_us: None,
            decision: Decision::Refused(refusal),
            optimizer: self.config.optimizer,
            evaluations: 0,
            cost_before: None,
            cost_after: None,
            fitted: flown,
            bias_only,
            flown,
            sigma: deviations,
            observable: [false; 12],
            rank: 0,
            rest_s: job.rest_s,
            explained: None,
            p_value: None,
        }
    }

    /// The flown and the factory's P, both with the bias from rest where there is one.
    fn with_rest_bias(&self, job: &Job) -> (GyroModel, GyroModel) {
        let bias = job.rest.map_or(self.flown.b_rad_s, |rest| rest.rate.into());
        (GyroModel { b_rad_s: bias, ..self.flown }, GyroModel { b_rad_s: bias, ..self.factory })
    }

    fn prior_sigma(&self) -> [f32; 12] {
        core::array::from_fn(|i| match i {
            0 | 4 | 8 => self.config.prior_sigma_diagonal,
            0..9 => self.config.prior_sigma_off_diagonal,
            _ => self.config.prior_sigma_bias_rad_s,
        })
    }

    fn least_squares(&mut self) -> Option<()> {
        self.prior = Prior::new(&self.config, &self.factory, self.job.rest.as_ref());
        self.total = Block::zero();
        for number in self.stream.blocks_within(self.job.from, self.job.to) {
            self.total.add(self.stream.block(number)?);
        }
        self.magnetometer = MagnetometerErrors::LagAndIron;
        self.solve()
    }

    /// Solves the weak form with the chosen errors of the magnetometer; a contest about that solution begins.
    fn solve(&mut self) -> Option<()> {
        let theta = theta_of(&self.flown);
        let (solution, variances) =
            least_squares::solve_with_variances(&self.total, &self.prior, &theta, self.magnetometer)?;
        self.solution = solution;
        self.variances = variances;
        self.theta0 = core::array::from_fn(|i| theta[i] + solution[i]);
        self.contest = Contest::zero();
        Some(())
    }

    /// Keeps those errors of the magnetometer that predict unseen blocks better, and solves again with them: an error that is
    /// there and left out bends P; one that is not there and kept only costs precision (a hard iron looks like a
    /// cross-coupling from the axis that turns).
    fn choose_magnetometer(&mut self) -> Option<()> {
        let shows = |outcome: Outcome| outcome.p_value <= MAGNETOMETER_P_VALUE;
        let enough = self.contest.groups() >= MIN_GROUPS;
        self.magnetometer = if !enough || shows(self.contest.first_against_second()) {
            MagnetometerErrors::LagAndIron
        } else if shows(self.contest.second_against_third()) {
            MagnetometerErrors::Lag
        } else {
            MagnetometerErrors::None
        };
        self.solve()
    }

    /// Plays group `group` of the contest; `Some(false)` when there is none left.
    fn play(&mut self, group: usize, models: &[Model; 3]) -> Option<bool> {
        let numbers = self.stream.blocks_within(self.job.from, self.job.to);
        let filled = numbers.clone().filter(|n| self.stream.block(*n).is_some_and(|b| !b.is_empty())).count();
        let groups = if filled < MAX_GROUPS { filled } else { MAX_GROUPS };
        if group >= groups {
            return Some(false);
        }
        // The filled blocks are dealt out evenly: group g holds numbers g * filled / groups up to the next group's.
        let share = |g: usize| (g * filled).checked_div(groups).unwrap_or(0);
        let (first, end) = (share(group), share(group + 1));
        let mut unseen = Block::zero();
        let mut position = 0;
        for number in numbers {
            let block = self.stream.block(number)?;
            if !block.is_empty() {
                if (first..end).contains(&position) {
                    unseen.add(block);
                }
                position += 1;
            }
        }
        let theta = theta_of(&self.flown);
        let everything = least_squares::gyro_part(&self.solution);
        let known = Known { variances: &self.variances, prior: &self.prior, theta: &theta };
        self.contest.play(&self.total, &unseen, models, &known, &everything)?;
        Some(true)
    }

    /// Builds node `index` and the segment that ends there; false when the window holds no such node.
    fn build_segment(&mut self, index: usize) -> bool {
        let grid = self.stream.grid;
        let (half, length) = (grid.increments_in(0.5) as u32, grid.increments_in(1.0) as u32);
        let node = self.job.from + half + index as u32 * length;
        let ring = &self.stream.increments;
        if index == 0 {
            self.segment_count = 0;
        }
        let overwritten = !ring.holds(node.saturating_sub(half + length));
        if self.segment_count >= SEGMENTS || node + half >= self.job.to || (index > 0 && overwritten) {
            return false;
        }
        let (p, c) = linear(&self.theta0);
        let [.., x, y, z] = self.solution;
        let effects = VectorEffects { mag_lag_s: self.solution[12], hard_iron_ut: Vector3::new(x, y, z) };
        let vectors = node_vectors(ring, grid, node, (&p, &c), &effects);
        let rotation = if index == 0 { None } else { preintegrate(ring, grid, (node - length, node), (&p, &c)) };
        if let (Some(slot), Some(rotation)) = (self.segments.get_mut(self.segment_count), rotation) {
            *slot = Segment::new(&rotation, &self.last_node, &vectors, self.config.max_bias_rad_s);
            self.segment_count += 1;
        }
        self.last_node = vectors;
        true
    }

    fn objective(&self) -> TwoVector<'_> {
        TwoVector {
            segments: self.segments.get(..self.segment_count).unwrap_or_default(),
            scales: &self.scales,
            prior: &self.prior,
            theta0: &self.theta0,
        }
    }

    fn whiten(&mut self) -> Option<()> {
        if self.segment_count == 0 {
            return None;
        }
        self.scales = noise_scales(self.segments.get(..self.segment_count).unwrap_or_default());
        let start = [0.0; 12];
        let mut normal = Packed::zero();
        let mut descent = [0.0; 12];
        self.objective().normal_equations(&start, &mut normal, &mut descent);
        self.whitening = Some(normal.cholesky()?);
        match self.config.optimizer {
            OptimizerKind::Imoa => {
                self.imoa.start(&ImoaSettings::new(self.config.max_evaluations), self.seed ^ self.job.t_end_us)
            }
            OptimizerKind::Lm => {
                let cost = self.objective().evaluate(&start);
                self.levenberg_marquardt.start(start, cost);
            }
            OptimizerKind::Ls => {}
        }
        Some(())
    }

    fn search(&mut self) -> Progress {
        let objective = TwoVector {
            segments: self.segments.get(..self.segment_count).unwrap_or_default(),
            scales: &self.scales,
            prior: &self.prior,
            theta0: &self.theta0,
        };
        match (self.config.optimizer, &self.whitening) {
            (OptimizerKind::Imoa, Some(factor)) => {
                let whitened = Whitened { cost: &objective, factor, radius: RADIUS };
                self.imoa.step(&whitened, &ImoaSettings::new(self.config.max_evaluations))
            }
            (OptimizerKind::Lm, _) => self.levenberg_marquardt.step(&objective, self.config.max_evaluations),
            _ => Progress::Done,
        }
    }

    /// The optimum found, about theta0, and the evaluations spent.
    fn optimum(&self) -> ([f32; 12], u32) {
        match (self.config.optimizer, &self.whitening) {
            (OptimizerKind::Imoa, Some(factor)) => {
                let (y, _) = self.imoa.best();
                (factor.solve_upper(&y.map(|y| RADIUS * y)), self.imoa.evaluations())
            }
            (OptimizerKind::Lm, _) => (*self.levenberg_marquardt.best().0, self.levenberg_marquardt.evaluations()),
            _ => ([0.0; 12], 0),
        }
    }

    /// Observability, uncertainty and the gate.
    fn judge(&self) -> Result<WindowReport, Refusal> {
        let objective = self.objective();
        let (delta, evaluations) = self.optimum();
        let theta: [f32; 12] = core::array::from_fn(|i| self.theta0[i] + delta[i]);
        let fitted = model_of(&theta).ok_or(Refusal::Degenerate)?;
        let flown_theta = theta_of(&self.flown);
        let flown_delta = core::array::from_fn(|i| flown_theta[i] - self.theta0[i]);

        let mut information = Packed::zero();
        objective.normal_equations(&delta, &mut information, &mut [0.0; 12]);
        let posterior = information.cholesky().ok_or(Refusal::Degenerate)?;
        let observability = Observability::new(&self.prior.information, &information).ok_or(Refusal::Degenerate)?;
        let jackknife = self.contest.covariance();
        let sigma = self.sigma(&posterior, &jackknife, &fitted);
        let prior_sigma = self.prior_sigma();

        let (base, mut bias_only) = self.with_rest_bias(&self.job);
        let base_theta = theta_of(&base);
        let change = observability.observed_part(&core::array::from_fn(|i| theta[i] - base_theta[i]));
        let candidate = model_of(&core::array::from_fn(|i| base_theta[i] + change[i]));

        let full = self.contest.first_against_second();
        let moving = self.segments.iter().take(self.segment_count).filter(|segment| segment.moving);
        let (mut square, mut variance, mut count) = (0.0, 0.0, 0.0);
        for segment in moving {
            square += turn(segment, &change).norm_squared();
            for row in &segment.jacobian {
                variance += jackknife.quadratic(row);
            }
            count += 1.0;
        }
        let verdict = self.fit_to_judge().and_then(|()| {
            if self.contest.groups() < MIN_GROUPS || count < 1.0 {
                return Err(Refusal::NotEnoughExcitation { rank: observability.rank });
            }
            let rms = |sum: f32| libm::sqrtf(sum / count);
            acceptance::judge(&Evidence { outcome: full, change_rad: rms(square), change_sigma_rad: rms(variance) })
        });
        let (cost_before, cost_after) = (objective.evaluate(&flown_delta), objective.evaluate(&delta));

        let mut flown = base;
        let decision = match (verdict, candidate) {
            (Ok(()), Some(candidate)) if cost_after < cost_before && self.is_plausible(&candidate) => {
                flown = candidate;
                Decision::Accepted
            }
            (Ok(()), _) => Decision::Refused(Refusal::Degenerate),
            (Err(refusal), _) => Decision::Refused(refusal),
        };
        if self.job.rest.is_none() {
            self.fitted_bias(&mut bias_only, decision, &mut flown)?;
        }
        let contested = self.contest.groups() > 0;
        Ok(WindowReport {
            t_start_us: self.job.t_start_us,
            t_end_us: self.job.t_end_us,
            t_effect_us: None,
            decision,
            optimizer: self.config.optimizer,
            evaluations,
            cost_before: finite(cost_before),
            cost_after: finite(cost_after),
            fitted,
            bias_only,
            flown,
            sigma,
            observable: core::array::from_fn(|i| sigma[i] < 0.5 * prior_sigma[i]),
            rank: observability.rank,
            rest_s: self.job.rest_s,
            explained: if contested { finite(full.explained) } else { None },
            p_value: if contested { finite(full.p_value) } else { None },
        })
    }

    /// Without a rest the bias comes from the window: bias-only is fitted with the factory's P; what flies takes a fitted bias
    /// only when that wins clearly too.
    fn fitted_bias(&self, bias_only: &mut GyroModel, decision: Decision, flown: &mut GyroModel) -> Result<(), Refusal> {
        let theta = theta_of(&self.flown);
        let fit = |p_change: [f32; 9]| {
            let x = least_squares::solve(
                &self.total,
                &self.variances,
                &self.prior,
                &theta,
                (&Freedom::Bias(p_change), self.magnetometer),
            )?;
            model_of(&core::array::from_fn(|i| theta[i] + x[i]))
        };
        let factory = theta_of(&self.factory);
        *bias_only = fit(core::array::from_fn(|i| factory[i] - theta[i])).ok_or(Refusal::Degenerate)?;
        let enough = self.contest.groups() >= MIN_GROUPS;
        if decision != Decision::Accepted
            && enough
            && acceptance::clear_win(&self.contest.second_against_third()).is_ok()
        {
            let moved = fit([0.0; 9]).ok_or(Refusal::Degenerate)?;
            if self.is_plausible(&moved) {
                *flown = moved;
            }
        }
        Ok(())
    }

    /// 1-sigma of P and b: the larger of the posterior's and the jackknife's.
    fn sigma(&self, posterior: &Cholesky<12, 78>, jackknife: &Packed<12, 78>, fitted: &GyroModel) -> [f32; 12] {
        core::array::from_fn(|i| {
            // b = P^-1 c, so with P near the identity db_i = dc_i - sum_j dP_ij b_j.
            let mut direction = [0.0; 12];
            direction[i] = 1.0;
            if i >= 9 {
                for j in 0..3 {
                    direction[3 * (i - 9) + j] = -fitted.b_rad_s[j];
                }
            }
            let by_posterior = dot(&posterior.solve(&direction), &direction);
            let by_jackknife = jackknife.quadratic(&direction);
            libm::sqrtf(if by_jackknife > by_posterior { by_jackknife } else { by_posterior })
        })
    }

    /// Whether every parameter lies within five prior deviations of the factory's.
    fn is_plausible(&self, model: &GyroModel) -> bool {
        let (theta, factory, sigma) = (theta_of(model), theta_of(&self.factory), self.prior_sigma());
        (0..12).all(|i| libm::fabsf(theta[i] - factory[i]) <= 5.0 * sigma[i])
    }
}

/// theta as the matrix P and the vector c.
fn linear(theta: &[f32; 12]) -> (Matrix3<f32>, Vector3<f32>) {
    (Matrix3::from_fn(|i, j| theta[3 * i + j]), Vector3::new(theta[9], theta[10], theta[11]))
}

fn micros(seconds: f32) -> u64 {
    (seconds * 1e6) as u64
}

fn finite(x: f32) -> Option<f32> {
    x.is_finite().then_some(x)
}
