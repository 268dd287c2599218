//! `mwd field`: the reference field and gravity of a place and a date, as a configuration for the probe.

use clap::Args;
use meerkat_mwd::config::Earth;
use world_magnetic_model::time::Date;

use crate::earth::{
    field_at_depth::field_at,
    gravity_at_depth::{ROCK_KG_M3, gravity_m_s2},
    reference_field::{ReferenceField, day},
};

/// Options of `field`.
#[derive(Debug, Clone, Args)]
pub struct FieldArgs {
    /// Geodetic latitude, degrees north
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub latitude: f64,
    /// Longitude, degrees east, any convention: 358 is -2
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub longitude: f64,
    /// Height above the WGS 84 ellipsoid, metres; negative below it, down to -12000, in rock of 2670 kg/m^3
    #[arg(long, value_name = "M", allow_negative_numbers = true, default_value_t = 0.0)]
    pub altitude: f64,
    /// Day, 2020 to 2029
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = day)]
    pub date: Date,
}

/// Prints a place's field and gravity as a configuration for `--config`.
///
/// # Errors
/// A place or a day outside the model.
pub fn run(args: &FieldArgs) -> anyhow::Result<()> {
    let field = field_at(args.latitude, args.longitude, args.altitude, args.date)?;
    print!("{}", configuration(&field, args));
    Ok(())
}

fn configuration(field: &ReferenceField, args: &FieldArgs) -> String {
    let earth = Earth {
        gravity_m_s2: gravity_m_s2(args.latitude, args.altitude, 0.0, ROCK_KG_M3) as f32,
        magnetic_field_ut: Some(field.total_ut),
        dip_rad: Some(field.dip_rad),
        declination_rad: Some(field.declination_rad),
        latitude_rad: Some(args.latitude.to_radians() as f32),
    };
    let value = |x: Option<f32>| x.map_or_else(String::new, |x| format!("{x:?}"));
    let degrees = |rad: f32| f64::from(rad).to_degrees();
    format!(
        "# World Magnetic Model at latitude {}, longitude {}, {} m, {}; gravity of WGS 84\n\
         [earth]\n\
         gravity_m_s2 = {:?}\n\
         magnetic_field_ut = {} # +- {:.3}\n\
         dip_rad = {} # {:.3} deg +- {:.2}\n\
         declination_rad = {} # {:.3} deg east +- {:.2}\n\
         latitude_rad = {}\n",
        args.latitude,
        args.longitude,
        args.altitude,
        args.date,
        earth.gravity_m_s2,
        value(earth.magnetic_field_ut),
        field.total_sigma_ut,
        value(earth.dip_rad),
        degrees(field.dip_rad),
        degrees(field.dip_sigma_rad),
        value(earth.declination_rad),
        degrees(field.declination_rad),
        degrees(field.declination_sigma_rad),
        value(earth.latitude_rad),
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_is_printed_is_a_configuration() {
        let args = FieldArgs { latitude: 60.0, longitude: 2.0, altitude: 0.0, date: day("2026-06-01").unwrap() };
        let field = field_at(args.latitude, args.longitude, args.altitude, args.date).unwrap();
        let config: meerkat_mwd::Config = toml::from_str(&configuration(&field, &args)).unwrap();
        assert_eq!(config.validate(), Ok(()));
        assert_eq!(config.earth.dip_rad, Some(field.dip_rad));
        assert_eq!(config.earth.declination_rad, Some(field.declination_rad));
        assert!((config.earth.gravity_m_s2 - 9.819).abs() < 0.001);
    }
}
