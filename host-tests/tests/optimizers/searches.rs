//! Every search, and costs to search: a bowl, one with a hole that is not finite, and one that is finite
//! nowhere.

use meerkat_mwd::optimizer::{
    Cost, DifferentialEvolution, DifferentialEvolutionSettings, Imoa, ImoaLiteral, ImoaLiteralSettings, ImoaSettings,
    LeastSquaresCost, Moa, MoaSettings, Optimizer, Packed, Pso, PsoSettings, RandomSearch, Reward, SearchSpace,
};

pub const D: usize = 4;
pub const N: usize = 12;
pub const SEEDS: u64 = 20;

pub type Made<'a, C> = Vec<(&'static str, Box<dyn Optimizer<C, D> + 'a>)>;

/// Every optimiser that takes any cost.
pub fn all<'a, C: Cost<D> + 'a>(space: &SearchSpace<D>, most: u32, seed: u64) -> Made<'a, C> {
    let optional = ImoaSettings { refraction: true, ..ImoaSettings::new(most) };
    let free = ImoaSettings { reward: Reward::Free, ..optional };
    let points = ImoaSettings { reward: Reward::Points, adaptive_step: false, ..optional };
    let evolution = DifferentialEvolutionSettings::new(most);
    vec![
        ("imoa", Box::new(Imoa::<D, N>::new(space, ImoaSettings::new(most), seed).unwrap())),
        ("imoa, all operators", Box::new(Imoa::<D, N>::new(space, optional, seed).unwrap())),
        ("imoa, free reward", Box::new(Imoa::<D, N>::new(space, free, seed).unwrap())),
        ("imoa, points", Box::new(Imoa::<D, N>::new(space, points, seed).unwrap())),
        ("imoa-literal", Box::new(ImoaLiteral::<D, N>::new(space, ImoaLiteralSettings::new(most), seed).unwrap())),
        ("moa", Box::new(Moa::<D, N>::new(space, MoaSettings::new(most), seed).unwrap())),
        ("pso", Box::new(Pso::<D, N>::new(space, PsoSettings::new(most), seed).unwrap())),
        // With 12 members the differences die out before the bottom is reached.
        ("de", Box::new(DifferentialEvolution::<D, { 2 * N }>::new(space, evolution, seed).unwrap())),
        ("random", Box::new(RandomSearch::<D>::new(space, most, seed).unwrap())),
    ]
}

/// A bowl whose lowest point, of cost 1, is given.
pub struct Bowl(pub [f32; D]);

impl Cost<D> for Bowl {
    fn evaluate(&self, x: &[f32; D]) -> f32 {
        1.0 + x.iter().zip(&self.0).map(|(x, lowest)| (x - lowest) * (x - lowest)).sum::<f32>()
    }
}

impl LeastSquaresCost<D, 10> for Bowl {
    fn normal_equations(&self, x: &[f32; D], normal: &mut Packed<D, 10>, descent: &mut [f32; D]) {
        *normal = Packed::zero();
        for (k, d) in descent.iter_mut().enumerate() {
            normal.add(k, k, 1.0);
            *d = self.0[k] - x[k];
        }
    }
}

/// Lowest points well off the start, none the same.
pub fn lowest(seed: u64) -> [f32; D] {
    [0.31, -0.42, 0.17, 0.55].map(|x: f32| x * (1.0 - 0.09 * seed as f32))
}

/// Not finite beyond a radius about the start, in each of its ways.
pub struct Hole;

impl Cost<D> for Hole {
    fn evaluate(&self, x: &[f32; D]) -> f32 {
        assert!(x.iter().all(|x| (-1.0..=1.0).contains(x)), "{x:?} is outside the box");
        let square: f32 = x.iter().map(|x| x * x).sum();
        // Falls towards the edge of what is allowed, so that every search goes there.
        match x[0] {
            _ if square < 0.09 => 2.0 - x[1] - x[2],
            x if x < -0.2 => f32::INFINITY,
            x if x < 0.2 => f32::NEG_INFINITY,
            _ => f32::NAN,
        }
    }
}

pub struct Nowhere(pub f32);

impl Cost<D> for Nowhere {
    fn evaluate(&self, _: &[f32; D]) -> f32 {
        self.0
    }
}

impl LeastSquaresCost<D, 10> for Nowhere {
    fn normal_equations(&self, _: &[f32; D], normal: &mut Packed<D, 10>, descent: &mut [f32; D]) {
        *normal = Packed::zero();
        *descent = [self.0; D];
    }
}
