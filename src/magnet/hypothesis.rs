//! Hypotheses about a jump of the field.

use super::{
    field_filter::{FieldFilter, Innovation},
    field_node::FieldNode,
};
use crate::statistics::chi_square::{IN_A_MILLION, IN_A_THOUSAND, IN_TWENTY};
use nalgebra::Matrix3;

/// Deviation of a jump on each axis, microtesla: of the order of the earth's own field.
pub(super) const JUMP_UT: f32 = 30.0;

/// Outcome of a node's update under one hypothesis.
pub(super) struct Outcome {
    /// Normalised innovation squared.
    pub squared: f32,
    pub log_likelihood: f32,
    /// Covariance of the prediction, microtesla squared.
    pub predicted: Matrix3<f32>,
    /// True if the states that may jump had to jump again.
    pub jumped: bool,
}

/// Updates a filter by a node, robustly. `jumping` is the first of three states that may jump: they are inflated again
/// by an innovation exceeded by chance less than once in a thousand. Each jump costs likelihood, about the logarithm of
/// the inflation over the former deviation, so that the hypothesis with fewer jumps wins.
pub(super) fn follow(filter: &mut FieldFilter, node: &FieldNode, noise: f32, jumping: Option<usize>) -> Outcome {
    let innovation = filter.innovation(node);
    follow_from(filter, innovation, node, noise, jumping)
}

/// Updates as [`follow`] does, with the filter's innovation of the node already computed.
pub(super) fn follow_from(
    filter: &mut FieldFilter,
    mut innovation: Innovation,
    node: &FieldNode,
    noise: f32,
    jumping: Option<usize>,
) -> Outcome {
    let mut squared = innovation.squared(noise);
    let mut jumped = false;
    if let Some(first) = jumping
        && squared.is_none_or(|(squared, _)| squared > IN_A_THOUSAND)
    {
        filter.inflate(first, JUMP_UT);
        innovation = filter.innovation(node);
        squared = innovation.squared(noise);
        jumped = true;
    }
    let (squared, log_determinant) = squared.unwrap_or((IN_A_MILLION, 0.0));
    let clipped = if squared > IN_TWENTY { squared / IN_TWENTY } else { 1.0 };
    filter.update(&innovation, noise * clipped);
    Outcome { squared, log_likelihood: -0.5 * (log_determinant + squared), predicted: innovation.predicted, jumped }
}
