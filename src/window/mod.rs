//! From samples to what identification works on: 20 ms increments, weak-form sums, node vectors, pre-integrated segments.

mod block;
mod increment;
mod node;
mod preintegration;
mod rest;
mod rest_bias;
mod segment;
mod stream;
mod weak_form;

pub(crate) use block::{Block, MAGNETIC};
pub(crate) use increment::{Accumulator, Grid, Increment, IncrementRing, Reading, Scales};
pub(crate) use node::{NodeVectors, VectorEffects, node_vectors};
pub(crate) use preintegration::{Preintegrated, preintegrate};
pub(crate) use rest::{RestDetector, RestLimits};
pub(crate) use rest_bias::{RestBias, RestNorm};
pub(crate) use segment::{Segment, Sighting};
pub(crate) use stream::{SampleStream, StreamSettings};
pub(crate) use weak_form::WeakForm;
