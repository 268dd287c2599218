//! Log ASCII Standard, version 2.0 (Canadian Well Logging Society, 1992, updated 2017).

use super::push;
use crate::surveys::run::{SurveyedRun, SurveyedStation};

/// Value that stands for none.
const NULL: f64 = -999.25;

/// Curves: mnemonic, unit, description, value.
type Curve = (&'static str, &'static str, &'static str, fn(&SurveyedStation) -> f64);

const CURVES: [Curve; 17] = [
    ("DEPT", "M", "Measured depth", |s| s.md_m),
    ("INCL", "DEG", "Inclination", |s| s.inclination_deg),
    ("AZIM", "DEG", "Azimuth from the north of positions", |s| s.azimuth_deg),
    ("AZMM", "DEG", "Azimuth from magnetic north", |s| s.magnetic_azimuth_deg),
    ("SINC", "DEG", "Standard deviation of INCL", |s| s.sigma_inclination_deg.unwrap_or(NULL)),
    ("SAZI", "DEG", "Standard deviation of AZIM", |s| s.sigma_azimuth_deg.unwrap_or(NULL)),
    ("SAG", "DEG", "Sag that INCL has, added to the measured", |s| s.sag_deg),
    ("GTF", "DEG", "Gravity toolface", |s| s.gravity_toolface_deg.unwrap_or(NULL)),
    ("TVD", "M", "True vertical depth", |s| s.position_m[2]),
    ("NS", "M", "North of the start", |s| s.position_m[0]),
    ("EW", "M", "East of the start", |s| s.position_m[1]),
    ("VSEC", "M", "Vertical section", |s| s.vertical_section_m),
    ("DLS", "DEG/30M", "Dogleg severity", |s| s.dogleg_deg_30m),
    ("EMAJ", "M", "Larger half axis of the horizontal ellipse, 1 sigma", |s| s.ellipse[0]),
    ("EMIN", "M", "Smaller half axis of the horizontal ellipse, 1 sigma", |s| s.ellipse[1]),
    ("DECL", "DEG", "Declination that AZIM has", |s| s.reference.declination_deg),
    ("CONV", "DEG", "Convergence of the grid that AZIM has", |s| s.convergence_deg.unwrap_or(0.0)),
];

/// The run as a LAS file. Stations are at uneven depths: STEP is 0.
#[must_use]
pub fn las(run: &SurveyedRun) -> String {
    let mut text =
        "~VERSION INFORMATION\n VERS.   2.0 : CWLS log ASCII standard - version 2.0\n WRAP.    NO : One line \
                    per depth step\n~WELL INFORMATION\n"
            .to_owned();
    let depth = |station: Option<&SurveyedStation>| station.map_or(NULL, |station| station.md_m);
    for (mnemonic, value, description) in [
        ("STRT.M", format!("{:.3}", depth(run.stations.first())), "First depth"),
        ("STOP.M", format!("{:.3}", depth(run.stations.last())), "Last depth"),
        ("STEP.M", "0.0".to_owned(), "Step"),
        ("NULL.", format!("{NULL}"), "Null value"),
        ("COMP.", String::new(), "Company"),
        ("WELL.", one_line(&run.well), "Well"),
        ("FLD .", String::new(), "Field"),
        ("LOC .", one_line(&run.provenance.place), "Location"),
        ("PROV.", String::new(), "Province"),
        ("SRVC.", String::new(), "Service company"),
        ("DATE.", run.provenance.date.clone(), "Date of the reference"),
        ("UWI .", String::new(), "Unique well identifier"),
    ] {
        push(&mut text, format_args!(" {mnemonic:<8} {value:<24}: {description}\n"));
    }
    text.push_str("~CURVE INFORMATION\n");
    for (mnemonic, unit, description, _) in CURVES {
        push(&mut text, format_args!(" {mnemonic:<4}.{unit:<8} : {description}\n"));
    }
    let north = if run.convergence_deg.is_some() { "GRID" } else { "TRUE" };
    push(
        &mut text,
        format_args!(
            "~PARAMETER INFORMATION\n MODL. {} : Reference model\n SAGC. {} : Sag of the bottom-hole assembly\n AZRF. {north} : North of AZIM, NS and EW\n \
             VSAZ.DEG {:.3} : Azimuth of VSEC\n~ASCII LOG DATA\n",
            one_line(&run.provenance.model),
            one_line(&run.sag_told()),
            run.vertical_section_deg
        ),
    );
    for station in &run.stations {
        let cells: Vec<String> = CURVES.iter().map(|(_, _, _, value)| format!("{:>11.4}", value(station))).collect();
        text.push_str(&cells.join(" "));
        text.push('\n');
    }
    text
}

/// Text that breaks no header line: a colon ends the value, a line break the line.
fn one_line(text: &str) -> String {
    text.replace([':', '\n', '\r', '~'], " ")
}
