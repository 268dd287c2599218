//! `mwd field`: the reference field and gravity of a place and a date, as a configuration for the probe.

use std::{io::Write, path::PathBuf};

use clap::Args;
use meerkat_mwd::config::Earth;
use world_magnetic_model::time::Date;

use crate::earth::{
    coefficient_file::CoefficientFile,
    field_at_depth::field_at,
    gravity_at_depth::{ROCK_KG_M3, gravity_m_s2},
    reference_field::day,
};
use testbed::{console, failure::Failure};

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
    /// Day, 2020 to 2029, or of the five years of --coefficients
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = day)]
    pub date: Date,
    /// Spherical harmonic coefficients to take instead of the World Magnetic Model, for instance WMMHR.COF
    #[arg(long, value_name = "FILE.COF")]
    pub coefficients: Option<PathBuf>,
}

/// A field, and the model that it is of.
struct Modelled {
    name: String,
    earth: Earth,
    /// 1-sigma uncertainties of total field (microtesla), dip and declination (radians), where the model states them.
    sigmas: Option<[f32; 3]>,
}

/// Prints a place's field and gravity as a configuration for `--config`.
///
/// # Errors
/// A place or a day outside the model, or a standard output that takes nothing.
pub fn run(args: &FieldArgs) -> anyhow::Result<()> {
    let configuration = configuration(&modelled(args)?, args);
    console::stdout().write_all(configuration.as_bytes()).map_err(Into::into)
}

fn modelled(args: &FieldArgs) -> Result<Modelled, Failure> {
    let FieldArgs { latitude, longitude, altitude, date, coefficients } = args;
    let gravity_m_s2 = gravity_m_s2(*latitude, *altitude, 0.0, ROCK_KG_M3) as f32;
    let earth = |total_ut, dip_rad, declination_rad| Earth {
        gravity_m_s2,
        magnetic_field_ut: Some(total_ut),
        dip_rad: Some(dip_rad),
        declination_rad: Some(declination_rad),
        latitude_rad: Some(latitude.to_radians() as f32),
    };
    if let Some(path) = coefficients {
        let model = CoefficientFile::read(path)?;
        let field = model.field_at(*latitude, *longitude, *altitude, *date)?;
        let rad = |deg: f64| deg.to_radians() as f32;
        let earth = earth((1e-3 * field.total_nt()) as f32, rad(field.dip_deg()), rad(field.declination_deg()));
        return Ok(Modelled { name: model.name, earth, sigmas: None });
    }
    let field = field_at(*latitude, *longitude, *altitude, *date)?;
    let earth = earth(field.total_ut, field.dip_rad, field.declination_rad);
    let sigmas = Some([field.total_sigma_ut, field.dip_sigma_rad, field.declination_sigma_rad]);
    Ok(Modelled { name: "World Magnetic Model".to_owned(), earth, sigmas })
}

fn configuration(modelled: &Modelled, args: &FieldArgs) -> String {
    let Modelled { name, earth, sigmas } = modelled;
    let value = |x: Option<f32>| x.map_or_else(String::new, |x| format!("{x:?}"));
    let degrees = |rad: Option<f32>| f64::from(rad.unwrap_or_default()).to_degrees();
    let [total, dip, declination] = match sigmas {
        Some([total_ut, dip_rad, declination_rad]) => [
            format!(" # +- {total_ut:.3}"),
            format!(" +- {:.2}", degrees(Some(*dip_rad))),
            format!(" +- {:.2}", degrees(Some(*declination_rad))),
        ],
        None => Default::default(),
    };
    format!(
        "# {name} at latitude {}, longitude {}, {} m, {}; gravity of WGS 84\n\
         [earth]\n\
         gravity_m_s2 = {:?}\n\
         magnetic_field_ut = {}{total}\n\
         dip_rad = {} # {:.3} deg{dip}\n\
         declination_rad = {} # {:.3} deg east{declination}\n\
         latitude_rad = {}\n",
        args.latitude,
        args.longitude,
        args.altitude,
        args.date,
        earth.gravity_m_s2,
        value(earth.magnetic_field_ut),
        value(earth.dip_rad),
        degrees(earth.dip_rad),
        value(earth.declination_rad),
        degrees(earth.declination_rad),
        value(earth.latitude_rad),
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_is_printed_is_a_configuration() {
        let date = day("2026-06-01").unwrap();
        let own = FieldArgs { latitude: 60.0, longitude: 2.0, altitude: -3_000.0, date, coefficients: None };
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/earth/coefficient_file/WMM2025.COF");
        let [built_in, file] = [None, Some(path.into())].map(|coefficients| {
            let args = FieldArgs { coefficients, ..own.clone() };
            let modelled = modelled(&args).unwrap();
            let text = configuration(&modelled, &args);
            let config: meerkat_mwd::Config = toml::from_str(&text).unwrap();
            assert_eq!(config.validate(), Ok(()));
            assert_eq!(config.earth, modelled.earth);
            (config.earth, text)
        });
        let field = field_at(own.latitude, own.longitude, own.altitude, date).unwrap();
        assert_eq!(built_in.0.dip_rad, Some(field.dip_rad));
        assert_eq!(built_in.0.declination_rad, Some(field.declination_rad));
        assert!((built_in.0.gravity_m_s2 - 9.822).abs() < 0.001, "{}", built_in.0.gravity_m_s2);
        assert!((file.0.magnetic_field_ut.unwrap() - field.total_ut).abs() < 3e-4);
        assert!((file.0.dip_rad.unwrap() - field.dip_rad).abs() < 1e-5);
        assert!((file.0.declination_rad.unwrap() - field.declination_rad).abs() < 2e-5);
        assert!(built_in.1.starts_with("# World Magnetic Model at") && built_in.1.contains("+-"), "{}", built_in.1);
        assert!(file.1.starts_with("# WMM-2025 at") && !file.1.contains("+-"), "{}", file.1);
    }
}
