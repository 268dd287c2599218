//! From samples to what identification works on: 20 ms increments; and from them weak-form equations and nodes.

mod accumulator;
mod equations;
mod bias_steps;
mod grid;
mod increment;
mod increment_ring;
mod motion_sum;
mod node;
mod node_walk;
mod rest;
mod rest_bias;
mod rest_pairs;
mod rows;
mod stream;
mod surroundings;
mod test_windows;
mod weak_form;

pub(crate) use accumulator::Accumulator;
pub use accumulator::Reading;
pub(crate) use equations::{Equations, TestEquations};
pub(crate) use grid::Grid;
pub(crate) use increment::Increment;
pub(crate) use increment_ring::{IncrementRing, Scales};
pub(crate) use node::{BodyMeans, Node, VectorEffects};
pub(crate) use node_walk::NodeWalk;
pub use rest::{Rest, RestDetector, RestLimits};
pub(crate) use rest_bias::{RestBias, RestNorm};
pub(crate) use rest_pairs::{RestPair, RestPairs};
pub(crate) use rows::{MAGNETIC, gyro_part};
pub(crate) use stream::{SampleStream, StreamSettings};
pub(crate) use surroundings::{SHARED, SurroundingsRing, halved, whole};
pub(crate) use test_windows::{TESTS, TestWindows};
pub(crate) use weak_form::{TestFunction, UNDER_WAY, WeakForm};
