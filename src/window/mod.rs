//! From samples to what identification works on: 20 ms increments, weak-form equations, nodes.

mod equations;
mod increment;
mod node;
mod rest;
mod rest_bias;
mod stream;
mod surroundings;
mod weak_form;

pub(crate) use equations::{Equations, MAGNETIC, TestEquations, gyro_part};
pub(crate) use increment::{Accumulator, Grid, Increment, IncrementRing, Reading, Scales};
pub(crate) use node::{BodyMeans, Node, NodeWalk, VectorEffects};
pub(crate) use rest::{RestDetector, RestLimits};
pub(crate) use rest_bias::{RestBias, RestNorm};
pub(crate) use stream::{Rebuild, SampleStream, StreamSettings, TESTS};
pub(crate) use surroundings::SurroundingsRing;
pub(crate) use weak_form::{UNDER_WAY, WeakForm};
