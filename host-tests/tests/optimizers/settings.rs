use meerkat_mwd::{
    config::OptimizerKind,
    optimizer::{
        DifferentialEvolution, DifferentialEvolutionSettings, Imoa, ImoaLiteral, ImoaLiteralSettings, ImoaSettings,
        Moa, MoaSettings, OptimizerError, Pso, PsoSettings, RandomSearch, SearchSpace,
    },
};

#[test]
fn a_search_that_cannot_be_made_says_why() {
    let unit = SearchSpace::<2>::UNIT;
    let needed = |needed| OptimizerError::PopulationTooSmall { needed };
    assert_eq!(Imoa::<2, 0>::new(&unit, ImoaSettings::new(9), 1).err(), Some(needed(1)));
    assert_eq!(ImoaLiteral::<2, 0>::new(&unit, ImoaLiteralSettings::new(9), 1).err(), Some(needed(1)));
    assert_eq!(Moa::<2, 0>::new(&unit, MoaSettings::new(9), 1).err(), Some(needed(1)));
    assert_eq!(Pso::<2, 0>::new(&unit, PsoSettings::new(9), 1).err(), Some(needed(1)));
    let evolution = DifferentialEvolutionSettings::new(9);
    assert_eq!(DifferentialEvolution::<2, 3>::new(&unit, evolution, 1).err(), Some(needed(4)));
    let none = SearchSpace::<0>::UNIT;
    assert_eq!(Imoa::<0, 4>::new(&none, ImoaSettings::new(9), 1).err(), Some(OptimizerError::NoDimensions));
    assert_eq!(RandomSearch::<0>::new(&none, 9, 1).err(), Some(OptimizerError::NoDimensions));
    assert_eq!(SearchSpace::within([1.0], [0.0]), Err(OptimizerError::BoundsReversed { dimension: 0 }));
    let bad = PsoSettings { constriction: f32::NAN, ..PsoSettings::new(9) };
    assert!(matches!(Pso::<2, 4>::new(&unit, bad, 1).err(), Some(OptimizerError::Setting(_))));
    let imoa = |settings| Imoa::<2, 4>::new(&unit, settings, 1).err();
    for disturbance in [f32::NAN, f32::INFINITY, -0.1] {
        let bad = ImoaSettings { disturbance, ..ImoaSettings::new(9) };
        assert_eq!(imoa(bad), Some(OptimizerError::Setting("disturbance")));
    }
    let still = ImoaSettings { spiral: false, migration: false, ..ImoaSettings::new(9) };
    assert_eq!(imoa(still), Some(OptimizerError::Setting("spiral or migration")));
    let literal = |settings| ImoaLiteral::<2, 4>::new(&unit, settings, 1).err();
    for modulus_error in [f32::NAN, f32::INFINITY] {
        let bad = ImoaLiteralSettings { modulus_error, ..ImoaLiteralSettings::new(9) };
        assert!(matches!(literal(bad), Some(OptimizerError::Setting(_))));
    }
    for guide in [f32::NAN, -0.1, 1.1] {
        let bad = ImoaLiteralSettings { guide, ..ImoaLiteralSettings::new(9) };
        assert!(matches!(literal(bad), Some(OptimizerError::Setting(_))));
    }
    for probability in [f32::NAN, -0.1, 1.1] {
        for bad in [
            MoaSettings { hunting: probability, ..MoaSettings::new(9) },
            MoaSettings { sentry: probability, ..MoaSettings::new(9) },
        ] {
            assert!(matches!(Moa::<2, 4>::new(&unit, bad, 1).err(), Some(OptimizerError::Setting(_))));
        }
        let bad = DifferentialEvolutionSettings { crossover: probability, ..evolution };
        assert!(matches!(DifferentialEvolution::<2, 4>::new(&unit, bad, 1).err(), Some(OptimizerError::Setting(_))));
    }
}

#[test]
fn the_names_in_a_configuration_are_those_of_the_command_line() {
    let names = ["imoa", "imoa-literal", "moa", "pso", "de", "random", "lm", "ls"];
    let kinds = names.map(|name| serde_json::from_value::<OptimizerKind>(name.into()).unwrap());
    assert_eq!(kinds.map(|kind| serde_json::to_value(kind).unwrap()), names.map(serde_json::Value::from));
}
