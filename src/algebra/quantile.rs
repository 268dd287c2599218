//! Quantile of a few values.

/// Value below which `share` (0 to 1) of the values lie: the upper of two neighbours; 0 for no values. Sorts the values
/// in place by insertion, because they are about a hundred and this sort cannot panic.
pub(crate) fn quantile(values: &mut [f32], share: f32) -> f32 {
    for sorted in 1..values.len() {
        let mut place = values.get_mut(..=sorted).unwrap_or_default();
        while let [.., before, last] = place {
            if *before > *last {
                core::mem::swap(before, last);
            } else {
                break;
            }
            let shorter = place.len() - 1;
            place = place.get_mut(..shorter).unwrap_or_default();
        }
    }
    let index = (values.len() as f32 * share) as usize;
    values.get(index).or(values.last()).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests;
