//! The root's rows of the effects: how they come about, and how they follow when the point of linearisation moves.

use crate::estimator::{
    columns::{FIELD, GLOBALS, NODE, NUISANCES},
    globals::Globals,
    node::Node,
    real::Real,
    rows::{CONSTANT, GLOBAL, NEW, ROWS, SCRATCH, WIDTH},
    square_root::{Pivot, reflect, reflect_two},
    unrolled::add_times,
};

/// Rows of the effects, behind those of node and globals.
pub(super) struct Root<T, const EFFECTS: usize> {
    /// Value of each column that is taken out, in units of its prior's deviation.
    pub x: [T; EFFECTS],
    /// Effects' columns of the node's rows and of the globals' rows.
    pub node: [[T; EFFECTS]; NODE],
    pub globals: [[T; EFFECTS]; GLOBALS],
    /// Effects' own rows, with their priors, and their constants.
    pub own: [[T; EFFECTS]; EFFECTS],
    pub constants: [T; EFFECTS],
}

/// Eliminates two columns of the node's states from the rows of an update.
#[inline(never)]
pub(super) fn eliminate<T: Real, const EFFECTS: usize>(
    used: usize,
    further: &mut [[T; EFFECTS]; SCRATCH],
    rows: &mut [[T; WIDTH]; SCRATCH],
    column: usize,
) {
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

impl<T: Real, const EFFECTS: usize> Root<T, EFFECTS> {
    pub const fn zero() -> Self {
        Self {
            x: [T::ZERO; EFFECTS],
            node: [[T::ZERO; EFFECTS]; NODE],
            globals: [[T::ZERO; EFFECTS]; GLOBALS],
            own: [[T::ZERO; EFFECTS]; EFFECTS],
            constants: [T::ZERO; EFFECTS],
        }
    }

    /// Forgets all that was learnt, and takes nothing out.
    pub fn begin(&mut self) {
        self.x = [T::ZERO; EFFECTS];
        self.node = [[T::ZERO; EFFECTS]; NODE];
        self.globals = [[T::ZERO; EFFECTS]; GLOBALS];
        self.own = [[T::ZERO; EFFECTS]; EFFECTS];
        self.own.iter_mut().enumerate().for_each(|(i, row)| row[i] = T::ONE);
        self.constants = [T::ZERO; EFFECTS];
    }

    /// Reflects two columns of the rows that a node left over into the globals' root, or one if the next is the gyro's:
    /// the nuisances are then done. Returns the next column.
    pub fn absorb(
        &mut self,
        used: usize,
        further: &mut [[T; EFFECTS]; SCRATCH],
        globals: &mut Globals<T>,
        left: &mut [[T; WIDTH]],
        column: usize,
    ) -> usize {
        let end = if column + 1 == NUISANCES { NUISANCES } else { column + 2 };
        let beside = further.get_mut(2 * NODE..NODE + ROWS).unwrap_or_default();
        let roots = globals.root.get_mut(column..end).unwrap_or_default();
        let pivots = (column..).zip(roots.iter_mut().zip(self.globals.iter_mut().skip(column)));
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
        used: usize,
        further: &mut [[T; EFFECTS]; SCRATCH],
        left: &mut [[T; WIDTH]],
        column: usize,
    ) -> bool {
        if column >= used {
            return false;
        }
        let own = further.get_mut(2 * NODE..NODE + ROWS).unwrap_or_default();
        let roots = self.own.get_mut(column..used).unwrap_or_default();
        let pivots = (column..).zip(roots.iter_mut().zip(self.constants.iter_mut().skip(column)));
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
    }

    /// Begins the node's attitude, velocity and position anew, and scales the rows of its field by `kept`.
    pub fn forget_node(&mut self, kept: T) {
        for row in self.node.iter_mut().take(FIELD) {
            *row = [T::ZERO; EFFECTS];
        }
        self.node.iter_mut().skip(FIELD).flatten().for_each(|x| *x *= kept);
    }

    /// Adds process noise of this variance (in squared units of the prior's width) to one global, see
    /// [`Globals::add_process_noise`], and to the effects' columns of the globals.
    pub fn add_process_noise(&mut self, used: usize, globals: &mut Globals<T>, global: usize, variance: T) {
        let Some((u, beta)) = globals.process_noise(global, variance) else { return };
        let mut dots = [T::ZERO; EFFECTS];
        for (u, row) in u.iter().zip(&self.globals) {
            add_times(&mut dots, *u, row.get(..used).unwrap_or_default());
        }
        for (u, row) in u.iter().zip(&mut self.globals) {
            add_times(row.get_mut(..used).unwrap_or_default(), -(beta * *u), &dots);
        }
        globals.add_process_noise(&u, beta);
    }

    /// Makes one column of the globals' root triangular again.
    pub fn triangular(&mut self, used: usize, globals: &mut Globals<T>, column: usize) {
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
        for (constant, row) in self.constants.iter_mut().zip(&self.own) {
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

    /// Forgets a column: all that the rows say of it, and its value.
    pub fn forget(&mut self, column: usize) {
        let all = self.own.iter_mut().chain(&mut self.globals).chain(&mut self.node);
        all.filter_map(|row| row.get_mut(column)).for_each(|x| *x = T::ZERO);
        if let Some(x) = self.x.get_mut(column) {
            *x = T::ZERO;
        }
        self.empty(column);
    }

    /// Turns all that a row without its own column says into the rows below it, and gives the column its prior.
    fn empty(&mut self, column: usize) {
        if column >= EFFECTS {
            return;
        }
        let mut row = [T::ZERO; EFFECTS];
        core::mem::swap(&mut row, &mut self.own[column]);
        let mut constant = core::mem::replace(&mut self.constants[column], T::ZERO);
        for c in column + 1..EFFECTS {
            let (a, b) = (self.own[c][c], row[c]);
            if b == T::ZERO {
                continue;
            }
            let norm = (a * a + b * b).root();
            let (cosine, sine) = (a / norm, b / norm);
            for (x, y) in self.own[c].iter_mut().zip(row.iter_mut()) {
                (*x, *y) = (cosine * *x + sine * *y, cosine * *y - sine * *x);
            }
            (self.constants[c], constant) =
                (cosine * self.constants[c] + sine * constant, cosine * constant - sine * self.constants[c]);
        }
        self.own[column][column] = T::ONE;
    }
}
