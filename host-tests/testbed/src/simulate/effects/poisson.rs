//! Random instants.

use crate::simulate::random::Random;

/// Random (Poisson) instants, in order of time, seconds.
pub(super) fn instants(per_minute: f64, duration_s: f64, random: &mut Random) -> Vec<f64> {
    let mut found = Vec::new();
    if per_minute <= 0.0 {
        return found;
    }
    let mut t_s = 0.0;
    loop {
        t_s += 60.0 / per_minute * random.exponential();
        if t_s >= duration_s {
            return found;
        }
        found.push(t_s);
    }
}
