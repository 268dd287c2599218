//! Parquet.

use mwd::import::{ColumnMap, import};
use tempfile::TempDir;

use crate::files::{flies_as_the_original, imported, mag, original};

/// A Parquet file with a clock of its own, a gyro in deg/s and gaps in the field.
#[test]
fn a_parquet_file() {
    use std::sync::Arc;

    use parquet::{
        data_type::{DoubleType, FloatType, Int64Type},
        file::{properties::WriterProperties, writer::SerializedFileWriter},
        schema::parser::parse_message_type,
    };

    let schema = "message readings { required int64 time (TIMESTAMP(MICROS, true)); required double gyr_x_dps; \
                  required double gyr_y_dps; required double gyr_z_dps; required float acc_x; required float acc_y; \
                  required float acc_z; optional double mag_x; optional double mag_y; optional double mag_z; }";
    let samples = &original().samples;
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("readings.parquet");
    let properties = WriterProperties::builder().set_compression(parquet::basic::Compression::SNAPPY).build();
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let mut writer =
        SerializedFileWriter::new(std::fs::File::create(&path).unwrap(), schema, Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for index in 0..10_usize {
        let axis = index.wrapping_sub(1) % 3;
        let mut column = group.next_column().unwrap().unwrap();
        match index {
            0 => {
                let times: Vec<i64> = samples.iter().map(|sample| sample.t_us as i64).collect();
                column.typed::<Int64Type>().write_batch(&times, None, None).unwrap();
            }
            1..=3 => {
                let rates: Vec<f64> = samples.iter().map(|s| f64::from(s.gyro_rad_s[axis]).to_degrees()).collect();
                column.typed::<DoubleType>().write_batch(&rates, None, None).unwrap();
            }
            4..=6 => {
                let forces: Vec<f32> = samples.iter().map(|s| s.accel_m_s2[axis]).collect();
                column.typed::<FloatType>().write_batch(&forces, None, None).unwrap();
            }
            _ => {
                let fields: Vec<Option<f64>> = samples.iter().map(|sample| mag(sample, axis)).collect();
                let levels: Vec<i16> = fields.iter().map(|field| i16::from(field.is_some())).collect();
                let there: Vec<f64> = fields.into_iter().flatten().collect();
                column.typed::<DoubleType>().write_batch(&there, Some(&levels), None).unwrap();
            }
        }
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    let told = imported(std::slice::from_ref(&path));
    assert_eq!(told.map.gyro.unit.as_deref(), Some("deg/s"));
    flies_as_the_original(&told);
    std::fs::write(&path, b"PAR1 and then nothing").unwrap();
    let refused = import(&[path], &ColumnMap::default(), &[]).unwrap_err().to_string();
    assert!(refused.contains("the Parquet file cannot be read"), "{refused}");
}
