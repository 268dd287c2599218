//! The root's rows of the effects: how they come about, and how they follow when the point of linearisation moves.

use super::{Candidates, Claim};
use crate::estimator::{
    columns::{BIAS, FIELD, GLOBALS, NODE, NUISANCES},
    globals::Globals,
    node::Node,
    real::{Real, zero3},
    rows::{CONSTANT, GLOBAL, NEW, ROWS, WIDTH},
    square_root::{Pivot, reflect, reflect_two},
    unrolled::add_times,
    update::SCRATCH,
};

impl<T: Real, const EFFECTS: usize> Candidates<T, EFFECTS> {
    /// Eliminates two columns of the node's states from the rows of an update.
    #[inline(never)]
    pub fn eliminate(&self, further: &mut [[T; EFFECTS]; SCRATCH], rows: &mut [[T; WIDTH]; SCRATCH], column: usize) {
        let used = self.used();
        // The states of the old node stand in their own rows; those of the new one are eliminated among the new rows.
        let (pivots, skipped) = if column < NODE { (column, NODE) } else { (NODE + column - NEW, 0) };
        let rows = rows.get_mut(pivots..).unwrap_or_default();
        let further = further.get_mut(pivots..).unwrap_or_default();
        let ([first, second, rest @ ..], [of_first, of_second, beside @ ..]) = (rows, further) else { return };
        let first = first.get_mut(column..).unwrap_or_default();
        let of_first = of_first.get_mut(..used).unwrap_or_default();
        let new = skipped.saturating_sub(pivots + 2);
        let count = NODE + ROWS - pivots - 2;
        let rest = rest.get_mut(new..count).unwrap_or_default();
        let beside = beside.get_mut(new..count).unwrap_or_default();
        if column >= NODE {
            let pivot = Pivot { own: &mut *first, at: column, further: &mut *of_first, from: 0 };
            reflect(pivot, core::array::from_mut(second), core::array::from_mut(of_second));
        }
        let second = second.get_mut(column + 1..).unwrap_or_default();
        let of_second = of_second.get_mut(..used).unwrap_or_default();
        let pivots = [
            Pivot { own: first, at: column, further: of_first, from: 0 },
            Pivot { own: second, at: column + 1, further: of_second, from: 0 },
        ];
        reflect_two(pivots, rest, beside);
    }

    /// Reflects two columns of the rows that a node left over into the globals' root, or one if the next is the gyro's:
    /// the nuisances are then done. Returns the next column.
    pub fn absorb(
        &mut self,
        further: &mut [[T; EFFECTS]; SCRATCH],
        globals: &mut Globals<T>,
        left: &mut [[T; WIDTH]],
        column: usize,
    ) -> usize {
        let used = self.used();
        let end = if column + 1 == NUISANCES { NUISANCES } else { column + 2 };
        let beside = further.get_mut(2 * NODE..NODE + ROWS).unwrap_or_default();
        let pivots = globals.root.iter_mut().zip(&mut self.globals).enumerate().take(end).skip(column);
        let mut pivots = pivots.map(|(column, (own, further))| Pivot {
            own: own.get_mut(column..).unwrap_or_default(),
            at: GLOBAL + column,
            further: further.get_mut(..used).unwrap_or_default(),
            from: 0,
        });
        match (pivots.next(), pivots.next()) {
            (Some(first), Some(second)) => reflect_two([first, second], left, beside),
            (Some(last), None) => reflect(last, left, beside),
            _ => {}
        }
        end
    }

    /// Reflects two columns of the rows that `absorb` left over into the effects' own rows; `false` when all are done.
    pub fn absorb_own(
        &mut self,
        further: &mut [[T; EFFECTS]; SCRATCH],
        left: &mut [[T; WIDTH]],
        column: usize,
    ) -> bool {
        let used = self.used();
        if column >= used {
            return false;
        }
        let own = further.get_mut(2 * NODE..NODE + ROWS).unwrap_or_default();
        let pivots = self.root.iter_mut().zip(&mut self.constants).enumerate().take(used).skip(column);
        let mut pivots = pivots.map(|(column, (own, constant))| Pivot {
            own: own.get_mut(column..used).unwrap_or_default(),
            at: column,
            further: core::slice::from_mut(constant),
            from: CONSTANT,
        });
        match (pivots.next(), pivots.next()) {
            (Some(first), Some(second)) => reflect_two([first, second], own, left),
            (Some(last), None) => reflect(last, own, left),
            _ => {}
        }
        true
    }

    /// Keeps the effects' columns of the new node's rows, once the old states have been eliminated.
    pub fn finish(&mut self, further: &[[T; EFFECTS]; SCRATCH]) {
        for (node, row) in self.node.iter_mut().zip(further.iter().skip(NODE)) {
            *node = *row;
        }
        self.start_node();
    }

    /// Begins the node's attitude, velocity and position anew, and scales the rows of its field by `kept`.
    pub fn forget_node(&mut self, kept: T) {
        for row in self.node.iter_mut().take(FIELD) {
            *row = [T::ZERO; EFFECTS];
        }
        self.node.iter_mut().skip(FIELD).flatten().for_each(|x| *x *= kept);
    }

    /// Adds process noise of this variance (in squared units of the prior's width) to one global, see
    /// [`Globals::widen`], and to the effects' columns of the globals.
    pub fn widen(&mut self, globals: &mut Globals<T>, global: usize, variance: T) {
        let Some((u, beta)) = globals.widening(global, variance) else { return };
        let used = self.used();
        let mut dots = [T::ZERO; EFFECTS];
        for (u, row) in u.iter().zip(&self.globals) {
            add_times(&mut dots, *u, row.get(..used).unwrap_or_default());
        }
        for (u, row) in u.iter().zip(&mut self.globals) {
            add_times(row.get_mut(..used).unwrap_or_default(), -(beta * *u), &dots);
        }
        globals.widen(&u, beta);
    }

    /// Makes one column of the globals' root triangular again.
    pub fn triangular(&mut self, globals: &mut Globals<T>, column: usize) {
        let used = self.used();
        let split = globals.root.split_at_mut_checked(column + 1);
        let own = self.globals.split_at_mut_checked(column + 1);
        if let (Some(([.., pivot], below)), Some(([.., further], rows))) = (split, own) {
            let own = pivot.get_mut(column..).unwrap_or_default();
            let further = further.get_mut(..used).unwrap_or_default();
            reflect(Pivot { own, at: column, further, from: 0 }, below, rows);
        }
    }

    /// Changes the sizes that are taken out: the rows' constants follow, and so do the means of globals and node.
    pub fn take_out(&mut self, x: &[T; EFFECTS], globals: &mut Globals<T>, node: &mut Node<T>) {
        let mut by = [T::ZERO; EFFECTS];
        for ((by, x), before) in by.iter_mut().zip(x).zip(&self.x) {
            *by = *x - *before;
        }
        self.x = *x;
        let dot = |row: &[T; EFFECTS]| row.iter().zip(&by).fold(T::ZERO, |sum, (a, b)| sum + *a * *b);
        for (constant, row) in self.constants.iter_mut().zip(&self.root) {
            *constant += dot(row);
        }
        for (row, own) in globals.root.iter_mut().zip(&self.globals) {
            if let Some(constant) = row.last_mut() {
                *constant += dot(own);
            }
        }
        let change = globals.solve();
        node.shift(&change, &core::array::from_fn(|i| self.node.get(i).map_or(T::ZERO, &dot)));
    }

    /// Makes a bias step part of the bias: its place is free for another step, and its uncertainty is added to that of
    /// the bias. The caller has to move the bias by the step.
    pub fn settle(&mut self, claim: &Claim, globals: &mut Globals<T>, sigma: &[T; GLOBALS]) {
        for (column, deviation) in BIAS.columns().zip(claim.sigma) {
            let Some(sigma) = sigma.get(column).filter(|sigma| **sigma > T::ZERO) else { continue };
            let share = T::of(deviation) / *sigma;
            self.widen(globals, column, share * share);
        }
        self.drop_step(claim.step);
    }

    /// Looks for a bias step from a shock on, see [`Shocks::begin_step`](super::shocks::Shocks::begin_step).
    pub fn begin_step(&mut self, at_us: u64, hard_m_s2: f32) {
        if let Some(step) = self.shocks.begin_step(at_us, hard_m_s2) {
            self.empty_step(step);
        }
    }

    /// Stops looking for a bias step, and frees its place for another.
    pub fn drop_step(&mut self, step: u8) {
        self.empty_step(step);
        self.shocks.drop_step(step);
    }

    fn empty_step(&mut self, step: u8) {
        for column in 0..self.used() {
            if self.is_step(column) && self.places[column].step == step {
                let all = self.root.iter_mut().chain(&mut self.globals).chain(&mut self.node);
                all.for_each(|row| row[column] = T::ZERO);
                self.x[column] = T::ZERO;
                let sums = [&mut self.rotation, &mut self.field, &mut self.velocity, &mut self.position];
                sums.into_iter().for_each(|sum| sum[column] = zero3());
                self.empty(column);
            }
        }
    }

    /// Turns all that a row without its own column says into the rows below it, and gives the column its prior.
    fn empty(&mut self, column: usize) {
        if column >= EFFECTS {
            return;
        }
        let mut row = [T::ZERO; EFFECTS];
        core::mem::swap(&mut row, &mut self.root[column]);
        let mut constant = core::mem::replace(&mut self.constants[column], T::ZERO);
        for c in column + 1..EFFECTS {
            let (a, b) = (self.root[c][c], row[c]);
            if b == T::ZERO {
                continue;
            }
            let norm = (a * a + b * b).root();
            let (cosine, sine) = (a / norm, b / norm);
            for (x, y) in self.root[c].iter_mut().zip(row.iter_mut()) {
                (*x, *y) = (cosine * *x + sine * *y, cosine * *y - sine * *x);
            }
            (self.constants[c], constant) =
                (cosine * self.constants[c] + sine * constant, cosine * constant - sine * self.constants[c]);
        }
        self.root[column][column] = T::ONE;
    }

    fn is_step(&self, column: usize) -> bool {
        let place = self.places.get(column);
        let effect = place.and_then(|place| self.library().get(usize::from(place.effect)));
        effect.is_some_and(|effect| effect.is_bias_step())
    }
}
