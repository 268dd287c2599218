//! Queue of work: increments, gaps, and requests between them.

use super::{increment::Item, real::Real};
use heapless::Deque;

/// Capacity in items: a second of increments, and a request.
const ROOM: usize = 26;

pub(super) struct Waiting<T> {
    items: Deque<Item<T>, ROOM>,
    /// Number of items that found no room.
    pub lost: u32,
    /// Seconds of lost increments and gaps since the last item that found room.
    dropped_s: T,
}

impl<T: Real> Waiting<T> {
    pub const fn new() -> Self {
        Self { items: Deque::new(), lost: 0, dropped_s: T::ZERO }
    }

    /// Makes the queue as new.
    pub fn clear(&mut self) {
        self.items.clear();
        (self.lost, self.dropped_s) = (0, T::ZERO);
    }

    pub fn push(&mut self, item: Item<T>) {
        // The lost time counts as silent: it is not the gyro's fault.
        let dropped = Item::Gap { seconds: self.dropped_s, silent_s: self.dropped_s };
        if self.dropped_s > T::ZERO && self.items.push_back(dropped).is_ok() {
            self.dropped_s = T::ZERO;
        }
        if let Err(item) = self.items.push_back(item) {
            self.lost = self.lost.saturating_add(1);
            // A lost increment is a gap to those after it.
            self.dropped_s += match item {
                Item::Increment(increment) => increment.seconds,
                Item::Gap { seconds, .. } => seconds,
                Item::Look | Item::IronChanged | Item::Close { .. } => T::ZERO,
            };
        }
    }

    /// Returns true if there is room for an item, and for the lost time before it.
    pub fn has_room(&self) -> bool {
        self.items.len() + 1 < ROOM
    }

    pub fn pop(&mut self) -> Option<Item<T>> {
        self.items.pop_front()
    }
}
