//! Tool codes: which errors a survey's position has after what was done to it, by name and with their sizes.
//!
//! The values are those of the Operators Wellbore Survey Group's sets A and B, revision 5.1 of 8 October 2020, which
//! the ISCWSA publishes; the weights are those of its MWD error model, revision 5 (Williamson, SPE 67616, 2000;
//! Codling, SPE 187249, 2017, for XCLA and XCLH).

use meerkat_mwd::config::SurveyErrors;
use serde::{Deserialize, Serialize};

use super::term_weights::{self as weigh, Weigh};

/// Where the reference field comes from, best last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FieldClass {
    /// A model that is renewed less often than every year: WMM, IGRF, EMM.
    Lrgm,
    /// A model of standard resolution, renewed every year: BGGM to 2018, MVSD.
    Srgm,
    /// A model of degree 720 or more, renewed every year: BGGM from 2019, HDGM, MVHD.
    Hrgm,
    /// In-field referencing: the crust's field measured at the place.
    Ifr1,
    /// The same with the field's changes in time.
    Ifr2,
}

impl FieldClass {
    const fn name(self) -> &'static str {
        match self {
            Self::Lrgm => "LRGM",
            Self::Srgm => "SRGM",
            Self::Hrgm => "HRGM",
            Self::Ifr1 => "IFR1",
            Self::Ifr2 => "IFR2",
        }
    }
}

/// Tool code of a run; stations with the short-collar correction have its `+AX` form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToolCode {
    /// Reference field.
    pub field: FieldClass,
    /// Inclinations are corrected for sag.
    pub sag: bool,
    /// Azimuths are corrected by a multi-station analysis.
    pub multi_station: bool,
}

/// Correlation of a term between stations of one well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Propagation {
    /// Every station has its own.
    Random,
    /// The same at all stations: of one run, of one well, everywhere.
    Systematic,
}

/// One error: its standard deviation in radians, metres, microtesla and their products, and how it enters.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// Name in the model; that of the `+AX` form has an I after its first two letters.
    pub name: &'static str,
    /// Standard deviation.
    pub sigma: f64,
    /// Correlation.
    pub propagation: Propagation,
    /// Weights at a station.
    pub weigh: Weigh,
}

impl ToolCode {
    /// Name, in the order in which the group writes it.
    #[must_use]
    pub fn name(&self, axial: bool) -> String {
        let part = |is: bool, name: &'static str| if is { name } else { "" };
        let (field, axial) = (self.field.name(), part(axial, "+AX"));
        format!("MWD+{field}{axial}{}{}", part(self.sag, "+SAG"), part(self.multi_station, "+MS"))
    }

    /// The published code that claims the most and no more than this one. Multi-station analysis has codes with a field
    /// of high resolution only, and IFR2 (and HRGM with that analysis) with sag correction only.
    #[must_use]
    pub fn published(self) -> Self {
        let field = if self.field == FieldClass::Ifr2 && !self.sag { FieldClass::Ifr1 } else { self.field };
        let multi_station = self.multi_station && (field >= FieldClass::Ifr1 || field == FieldClass::Hrgm && self.sag);
        Self { field, multi_station, ..self }
    }

    /// Its terms. Where the sensors' errors are configured to other sizes than the model's, the terms of that sensor
    /// grow or shrink with them.
    #[must_use]
    pub fn terms(&self, sensors: &SurveyErrors) -> Vec<Term> {
        use Propagation::{Random, Systematic};
        let usual = SurveyErrors::default();
        let ratio = |configured: f32, usual: f32| f64::from(configured) / f64::from(usual);
        let accel_bias = 0.004 * ratio(sensors.accel_bias_m_s2, usual.accel_bias_m_s2);
        let accel_scale = 0.000_5 * ratio(sensors.accel_scale, usual.accel_scale);
        // Multi-station analysis leaves half of the magnetometer's errors.
        let left = if self.multi_station { 0.5 } else { 1.0 };
        let mag_bias = nanotesla(70.0) * left * ratio(sensors.mag_bias_ut, usual.mag_bias_ut);
        let mag_scale = 0.001_6 * left * ratio(sensors.mag_scale, usual.mag_scale);
        let string = nanotesla(if self.multi_station { 100.0 } else { 220.0 })
            * ratio(sensors.axial_interference_ut, usual.axial_interference_ut);
        let sag = degrees(if self.sag { 0.08 } else { 0.2 });
        let term = |name, sigma, propagation, weigh| Term { name, sigma, propagation, weigh };
        let mut terms = vec![
            term("DRFR", 0.35, Random, weigh::depth as Weigh),
            term("DSFS", 0.000_56, Systematic, weigh::depth_scale),
            term("DSTG", 2.5e-7, Systematic, weigh::depth_stretch),
            term("ABXY-TI1S", accel_bias, Systematic, weigh::accel_bias_xy_1),
            term("ABXY-TI2S", accel_bias, Systematic, weigh::accel_bias_xy_2),
            term("ABZ", accel_bias, Systematic, weigh::accel_bias_z),
            term("ASXY-TI1S", accel_scale, Systematic, weigh::accel_scale_xy_1),
            term("ASXY-TI2S", accel_scale, Systematic, weigh::accel_scale_xy_2),
            term("ASXY-TI3S", accel_scale, Systematic, weigh::accel_scale_xy_3),
            term("ASZ", accel_scale, Systematic, weigh::accel_scale_z),
            term("MBXY-TI1S", mag_bias, Systematic, weigh::mag_bias_xy_1),
            term("MBXY-TI2S", mag_bias, Systematic, weigh::mag_bias_xy_2),
            term("MBZ", mag_bias, Systematic, weigh::axial_field),
            term("MSXY-TI1S", mag_scale, Systematic, weigh::mag_scale_xy_1),
            term("MSXY-TI2S", mag_scale, Systematic, weigh::mag_scale_xy_2),
            term("MSXY-TI3S", mag_scale, Systematic, weigh::mag_scale_xy_3),
            term("MSZ", mag_scale, Systematic, weigh::mag_scale_z),
            term("AMIL", string, Systematic, weigh::axial_field),
            term("SAGE", sag, Systematic, weigh::sag),
            term("XYM1", degrees(0.1), Systematic, weigh::misaligned_up),
            term("XYM2", degrees(0.1), Systematic, weigh::misaligned_across),
            term("XYM3E", degrees(0.3), Random, weigh::misaligned_north),
            term("XYM4E", degrees(0.3), Random, weigh::misaligned_east),
            term("XCLA", 0.167, Random, weigh::course_across),
            term("XCLH", 0.167, Random, weigh::course_up),
        ];
        let sources = SOURCES.iter().filter_map(|source| Some((source, (source.values)(self.field)?)));
        for (Source { names: [dec, dbh, mdi, mfi], propagation, .. }, value) in sources {
            let [declination, by_field, dip, total] = value;
            terms.push(term(dec, degrees(declination), *propagation, weigh::declination));
            terms.push(term(dbh, nanotesla(degrees(by_field)), *propagation, weigh::declination_by_field));
            terms.push(term(mdi, degrees(dip), *propagation, weigh::reference_dip));
            terms.push(term(mfi, nanotesla(total), *propagation, weigh::reference_field));
        }
        terms
    }
}

/// One cause of the reference field's error, by the terms for which it counts: DEC, degrees; DBH, degree nanotesla;
/// MDI, degrees; MFI, nanotesla. The last two count in `+AX` codes only.
struct Source {
    names: [&'static str; 4],
    propagation: Propagation,
    values: fn(FieldClass) -> Option<[f64; 4]>,
}

use FieldClass::{Hrgm, Ifr1, Ifr2, Lrgm, Srgm};

/// U: the model itself. OS, OH, OI: what the model omits at standard and high resolution, and in-field. CH, CI: what it
/// commits of the crust. R: changes in time, from station to station.
const SOURCES: [Source; 7] = [
    Source {
        names: ["DEC-U", "DBH-U", "MDI-U", "MFI-U"],
        propagation: Propagation::Systematic,
        values: |field| {
            Some(match field {
                Lrgm => [0.29, 4_108.0, 0.16, 107.0],
                Srgm => [0.16, 2_350.0, 0.09, 61.0],
                Hrgm => [0.16, 2_359.0, 0.09, 61.0],
                Ifr1 => [0.11, 1_271.0, 0.07, 40.0],
                Ifr2 => [0.11, 963.0, 0.06, 33.0],
            })
        },
    },
    Source {
        names: ["DEC-OS", "DBH-OS", "MDI-OS", "MFI-OS"],
        propagation: Propagation::Systematic,
        values: |field| matches!(field, Lrgm | Srgm).then_some([0.24, 3_359.0, 0.14, 88.0]),
    },
    Source {
        names: ["DEC-OH", "DBH-OH", "MDI-OH", "MFI-OH"],
        propagation: Propagation::Systematic,
        values: |field| matches!(field, Lrgm | Srgm | Hrgm).then_some([0.21, 2_840.0, 0.11, 73.0]),
    },
    Source {
        names: ["DEC-CH", "DBH-CH", "MDI-CH", "MFI-CH"],
        propagation: Propagation::Systematic,
        values: |field| (field == Hrgm).then_some([0.13, 1_789.0, 0.07, 46.0]),
    },
    Source {
        names: ["DEC-CI", "DBH-CI", "MDI-CI", "MFI-CI"],
        propagation: Propagation::Systematic,
        values: |field| match field {
            Ifr1 => Some([0.09, 712.0, 0.06, 27.0]),
            Ifr2 => Some([0.09, 712.0, 0.05, 27.0]),
            _ => None,
        },
    },
    Source {
        names: ["DEC-OI", "DBH-OI", "MDI-OI", "MFI-OI"],
        propagation: Propagation::Systematic,
        values: |field| Some([0.05, 356.0, if field == Ifr2 { 0.02 } else { 0.03 }, 13.0]),
    },
    Source {
        names: ["DECR", "DBHR", "MDIR", "MFIR"],
        propagation: Propagation::Random,
        values: |field| Some(if field == Ifr2 { [0.05, 750.0, 0.02, 15.0] } else { [0.1, 3_000.0, 0.08, 60.0] }),
    },
];

fn degrees(x: f64) -> f64 {
    x.to_radians()
}

/// Microtesla.
fn nanotesla(x: f64) -> f64 {
    x * 1e-3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_without_a_published_form_falls_back_to_one_that_claims_less() {
        let code = |field, sag, multi_station| ToolCode { field, sag, multi_station };
        for (wanted, published) in [
            (code(Lrgm, true, true), "MWD+LRGM+SAG"),
            (code(Srgm, false, true), "MWD+SRGM"),
            (code(Hrgm, false, true), "MWD+HRGM"),
            (code(Hrgm, true, true), "MWD+HRGM+SAG+MS"),
            (code(Ifr1, false, true), "MWD+IFR1+MS"),
            (code(Ifr2, false, true), "MWD+IFR1+MS"),
            (code(Ifr2, true, false), "MWD+IFR2+SAG"),
        ] {
            assert_eq!(wanted.published().name(false), published);
        }
        assert_eq!(code(Srgm, true, false).name(true), "MWD+SRGM+AX+SAG");
    }
}
