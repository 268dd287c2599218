use super::*;
use crate::compensation::effects::LIBRARY;

#[test]
fn an_error_of_a_vector_sensor_has_a_column_for_each_parameter() {
    for effect in LIBRARY {
        if let Some(error) = effect.vector_error() {
            let columns = Columns::of_error(error);
            assert_eq!(columns.len(), effect.parameters().len(), "{}", effect.name());
            assert!(columns.are_nuisances() && columns.are_within(Columns::NUISANCES), "{}", effect.name());
            assert!(columns.iter().all(|column| column.place().is_none()), "{}", effect.name());
        }
    }
    assert!(Columns::of_error(VectorError::AxialIron).are_within(Columns::of_error(VectorError::HardIron)));
    let own = Columns::of_effect(3, 2);
    assert!(!own.are_nuisances() && own.iter().map(|column| column.place()).eq([Some(3), Some(4)]));
}
