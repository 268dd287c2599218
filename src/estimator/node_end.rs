//! End of a node: its increments become a rest to start from, a part of an alignment, or the rows of an update.

use super::{
    columns::HARD_IRON,
    field_norm::FieldNorm,
    filter::{Filter, Task},
    gate::attitude_variance,
    node::Kind,
    reading::{Readings, Taken},
    real::{Real, norm},
    walk,
};

/// Fate of a node when an increment has been added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NodeEnd {
    /// It goes on.
    NotYet,
    /// It has ended.
    Ended,
    /// It has ended, and the filter with it, which begins anew: the gyro is another than the one that was learnt.
    BegunAnew,
}

impl NodeEnd {
    /// Ends the node in progress.
    // Not inlined: its calls are counted (`cargo mwd bench --target`), as are those of elimination and absorption.
    #[inline(never)]
    pub fn of<T: Real, const NODES: usize, const E: usize>(filter: &mut Filter<T, NODES, E>) -> Self {
        let seconds = filter.pre.seconds;
        filter.kind = if filter.rests.judge(&filter.pre, &filter.settings) { Kind::Rest } else { Kind::Moving };
        if filter.kind == Kind::Rest && !filter.course.has_begun {
            filter.shares.unread.add(T::ZERO, seconds);
            start_at_rest(filter);
            return Self::Ended;
        }
        if !filter.course.is_aligned {
            filter.shares.unread.add(T::ZERO, seconds);
            filter.course.disagreements.gyro.passed(seconds);
            align(filter);
            return Self::Ended;
        }
        let (matrix, centre) = (filter.gyro_matrix(), filter.prior.p);
        filter.pre.by_unknowns(&matrix, &centre);
        let taken = Taken {
            pre: &filter.pre,
            parameters: &filter.parameters,
            globals: &filter.globals,
            settings: &filter.settings,
            field_unit: filter.course.field_unit,
            sigma: &filter.prior.sigma,
            unknown: filter.unknown_rotation(),
            kind: filter.kind,
        };
        let attitude = filter.node.attitude;
        let agreement = filter.update.assemble(&mut filter.node, &taken);
        if agreement.field == Readings::Used && filter.settings.noise.field_is_even {
            filter.course.pointing.add(&filter.node.linear_at, attitude_variance(&filter.node, &filter.globals));
        }
        let rows = &filter.update.rows;
        let inverse = (filter.kind == Kind::Rest).then(|| filter.parameters.inverse());
        filter.candidates.fill(&mut filter.further, rows, &filter.node.linear_at, &filter.pre, inverse.as_ref());
        if agreement.field == Readings::Contradicted {
            filter.remainder.contradict();
        }
        if let Some(innovation) = agreement.innovation.filter(|_| filter.kind == Kind::Moving) {
            let turn = filter.node.field.cross(&innovation) / norm(&filter.node.field);
            let both = [attitude.transpose() * turn, innovation];
            filter.remainder.add(seconds.narrow(), both.map(|v| v.map(|x| x.narrow())));
        }
        if filter.kind == Kind::Moving {
            filter.shares.turned.add(if agreement.is_turned { T::ONE } else { T::ZERO }, seconds);
        }
        filter.course.unwalked_s += seconds;
        if agreement.is_turned {
            filter.shares.unread.add(T::ONE, seconds);
            if filter.course.disagreements.gyro.contradicted(seconds) {
                filter.begin();
                return Self::BegunAnew;
            }
            filter.gap(T::ZERO);
            return Self::Ended;
        }
        filter.course.disagreements.gyro.agreed(seconds);
        filter.shares.unread.add(T::ZERO, seconds);
        let [by_field, by_force] = filter.course.disagreements.for_good(&agreement, seconds);
        let by_field = core::mem::take(&mut filter.course.iron_has_changed) || by_field;
        if by_field {
            forget_field(filter);
        }
        if by_field || by_force {
            filter.gap(T::ZERO);
            return Self::Ended;
        }
        if filter.kind == Kind::Moving {
            filter.course.motion_s += seconds;
            let fieldless = if agreement.field == Readings::Used { T::ZERO } else { T::ONE };
            filter.shares.fieldless.add(fieldless, seconds);
        }
        filter.task = Task::Eliminating;
        Self::Ended
    }
}

/// Forgets the earth's field and the hard iron, which a shock may have changed.
fn forget_field<T: Real, const NODES: usize, const E: usize>(filter: &mut Filter<T, NODES, E>) {
    filter.node.has_field = false;
    filter.node.referred = 0;
    filter.node.norms = FieldNorm::zero();
    for column in HARD_IRON.columns() {
        filter.candidates.add_process_noise(&mut filter.globals, column, T::ONE);
        // As wide as it is now, the old mean would still be evidence of iron.
        if let Some(x) = filter.globals.x.get_mut(column) {
            *x = T::ZERO;
        }
    }
    filter.linearise();
    filter.task = Task::Walking(0);
}

/// Starts at a rest before anything else: its mean rate is the first bias, its mean force gives the attitude.
fn start_at_rest<T: Real, const NODES: usize, const E: usize>(filter: &mut Filter<T, NODES, E>) {
    filter.bias = filter.rests.rate - filter.parameters.turned_back(&filter.pre.mean_taken_out());
    filter.has_measured_bias = true;
    filter.linearise();
    if filter.pre.forces > 0 {
        filter.node.start(&filter.pre.forces_read, &filter.settings.noise);
        (filter.course.is_aligned, filter.course.has_begun) = (true, true);
    }
    filter.course.gap_s = T::ZERO;
    filter.start_node();
}

/// Adds a node to an alignment: at a start in motion, or after a gap.
fn align<T: Real, const NODES: usize, const E: usize>(filter: &mut Filter<T, NODES, E>) {
    let is_enough = filter.course.alignment.add(&filter.pre, filter.course.has_begun);
    if filter.course.has_begun {
        filter.course.unwalked_s += filter.pre.seconds;
    }
    filter.start_node();
    if !is_enough {
        return;
    }
    let [force, field] = filter.course.alignment.vectors();
    if filter.course.has_begun {
        let kept = filter.node.realign(&force, &field, filter.course.gap_s, &filter.settings.noise);
        filter.candidates.forget_node(kept.unwrap_or(T::ZERO));
        // The frame turns with the heading that is found again.
        filter.course.pointing.turn_anew();
    } else {
        filter.node.start(&force, &filter.settings.noise);
    }
    (filter.course.is_aligned, filter.course.has_begun) = (true, true);
    filter.course.gap_s = T::ZERO;
    if filter.course.unwalked_s >= T::of(walk::EVERY_S) {
        // The globals walk before a node after the gap is judged.
        filter.task = Task::AddingNoise(0);
    }
}
