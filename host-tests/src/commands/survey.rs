//! `mwd survey`: from stations to corrected directions, positions with their uncertainty, and the files that others
//! read.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

use clap::Args;
use meerkat_mwd::{
    config::SurveyConfig,
    survey::{Checked, Grade, SurveyKind, SurveyReport},
};
use nalgebra::Vector3;

use super::same_file::none_overwritten;
use crate::{
    import::plausible::checked,
    layout::Layout,
    number::fixed,
    report::{
        html::{Sources, survey_run::page, write_page},
        surveys_csv::{grade, reason},
    },
    surveys::{
        cells::unmarked,
        depth_by_time::DepthByTime,
        far_off::is_off,
        files,
        measured::Measured,
        reference::Reference,
        run::SurveyedRun,
        settings::{Correction, ReferenceSettings, RunSettings},
        stations_csv::{ReadStation, read},
        surveyed::surveyed,
    },
};
use testbed::{
    console::{self, told},
    failure::Failure,
    flight::{configuration::of_trace, started, surveys},
    trace::Trace,
};

/// Options of `survey`.
#[derive(Debug, Clone, Args)]
pub struct SurveyArgs {
    /// Stations as CSV (columns such as md_m,gx_g,gy_g,gz_g,bx_nt,by_nt,bz_nt), or a trace, of which the surveys at
    /// rest are taken
    #[arg(value_name = "STATIONS.csv|TRACE")]
    pub input: PathBuf,
    /// Place, date, reference, grid and corrections of the run
    #[arg(long, value_name = "RUN.toml")]
    pub run: Option<PathBuf>,
    /// Correction of azimuths, instead of the one in the run's file
    #[arg(long)]
    pub correction: Option<Correction>,
    /// Bit depth by time (columns t_s,md_m), for stations without a depth
    #[arg(long, value_name = "DEPTH.csv")]
    pub depth: Option<PathBuf>,
    /// Distance from the bit to the tool, metres
    #[arg(long, value_name = "M", default_value_t = 0.0, requires = "depth", value_parser = finite)]
    pub bit_to_tool: f64,
    /// Seconds to add to the depth file's clock to get the tool's
    #[arg(long, value_name = "S", default_value_t = 0.0, requires = "depth", allow_negative_numbers = true, value_parser = finite)]
    pub clock: f64,
    /// Write every number of every station as CSV
    #[arg(long, value_name = "OUT.csv")]
    pub csv: Option<PathBuf>,
    /// Write depth, inclination and azimuth as CSV, for planning programs such as welleng
    #[arg(long, value_name = "OUT.csv")]
    pub plain: Option<PathBuf>,
    /// Write a WITSML 1.4.1.1 trajectory
    #[arg(long, value_name = "OUT.xml")]
    pub witsml1: Option<PathBuf>,
    /// Write a WITSML 2.0 trajectory
    #[arg(long, value_name = "OUT.xml")]
    pub witsml2: Option<PathBuf>,
    /// Write a LAS 2.0 file
    #[arg(long, value_name = "OUT.las")]
    pub las: Option<PathBuf>,
    /// Write everything as JSON
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Write a report with figures as HTML
    #[arg(long, value_name = "OUT.html")]
    pub html: Option<PathBuf>,
    /// Send WITS level 0 records over TCP
    #[arg(long, value_name = "HOST:PORT")]
    pub wits0: Option<String>,
}

/// Works out the run, prints it and writes what is asked for.
///
/// # Errors
/// An input cannot be used, or an output cannot be written or would overwrite an input or another one.
pub fn run(args: &SurveyArgs) -> anyhow::Result<()> {
    let mut settings = match &args.run {
        Some(path) => {
            let settings = RunSettings::parse(&text_of(path)?).map_err(|error| named(path, &error))?;
            settings.of_folder(path.parent().unwrap_or(Path::new("")))
        }
        None => RunSettings::default(),
    };
    if let Some(correction) = args.correction {
        settings.correction = correction;
    }
    check_outputs(args, &settings)?;
    let (stations, doubts) = stations(args)?;
    let reference = Reference::of(&settings)?;
    let mut run = surveyed(&stations, &settings, &reference).map_err(|error| named(&args.input, &error))?;
    run.warnings.extend(doubts);
    print(&mut told(), Layout::of_told(), &run)?;
    type Text = fn(&SurveyedRun) -> String;
    let texts: [(&Option<PathBuf>, Text); 5] = [
        (&args.csv, files::csv::full),
        (&args.plain, files::csv::plain),
        (&args.witsml1, files::witsml1::witsml),
        (&args.witsml2, files::witsml2::witsml),
        (&args.las, files::las::las),
    ];
    for (path, text) in texts {
        if let Some(path) = path {
            files::save(path, &text(&run))?;
        }
    }
    if let Some(path) = &args.json {
        files::save(path, &files::json(&run)?)?;
    }
    if let Some(path) = &args.html {
        let mut sources = Sources::program();
        if !console::is_stdio(&args.input) {
            sources = sources.file("stations", &args.input);
        }
        if let Some(depth) = &args.depth {
            sources = sources.file("depths", depth);
        }
        if let Some(settings) = &args.run {
            sources = sources.file("run's file", settings).configuration("The run's file", &text_of(settings)?);
        }
        write_page(path, &page(&run, &sources))?;
    }
    if let Some(address) = &args.wits0 {
        files::wits0::send(&run, address)?;
    }
    match &args.html {
        Some(page) => writeln!(told(), "Next: open {} in a browser.", page.display())?,
        None => writeln!(told(), "Next: --html path.html draws it; docs/surveys.md says how to read it.")?,
    }
    Ok(())
}

/// Refuses to overwrite an input, and to write two results to one file.
fn check_outputs(args: &SurveyArgs, settings: &RunSettings) -> Result<(), Failure> {
    let outputs = [&args.csv, &args.plain, &args.witsml1, &args.witsml2, &args.las, &args.json, &args.html];
    let outputs: Vec<&Path> = outputs.into_iter().flatten().map(AsRef::as_ref).collect();
    let reference = match &settings.reference {
        ReferenceSettings::Coefficients { path } | ReferenceSettings::File { path } => Some(path),
        _ => None,
    };
    let further = [args.run.as_ref(), args.depth.as_ref(), reference].into_iter().flatten();
    let inputs: Vec<&Path> = std::iter::once(&args.input).chain(further).map(AsRef::as_ref).collect();
    none_overwritten(&outputs, &inputs)
}

fn text_of(path: &Path) -> Result<String, Failure> {
    console::text(path).map_err(|error| Failure::unread(path, &error))
}

fn named(path: &Path, error: &Failure) -> Failure {
    Failure::BadInput(format!("{}: {error}", path.display()))
}

/// Stations of the input, each with a depth, and doubts about the stops that they are from, a sentence each.
fn stations(args: &SurveyArgs) -> anyhow::Result<(Vec<ReadStation>, Vec<String>)> {
    let mut doubts = Vec::new();
    // The standard input is read once: it holds stations.
    let mut stations = if !console::is_stdio(&args.input) && is_trace(&args.input)? {
        let mut trace = Trace::read(&args.input)?;
        let mut config = of_trace(&trace);
        checked(&mut trace, &mut config, false)?;
        let taken = surveys(started(&config, None, None)?, &trace)?;
        let stations: Vec<ReadStation> = taken.iter().filter_map(at_rest).collect();
        doubts = doubts_about(&taken);
        if stations.is_empty() {
            return Err(no_stop(&args.input, &config.survey, &taken).into());
        }
        stations
    } else {
        read(&text_of(&args.input)?).map_err(|error| named(&args.input, &error))?
    };
    let depths = match &args.depth {
        Some(path) => {
            let depths = DepthByTime::read(&text_of(path)?, args.bit_to_tool, args.clock);
            Some((path, depths.map_err(|error| named(path, &error))?))
        }
        None => None,
    };
    if let Some((path, _)) = &depths
        && stations.iter().all(|station| station.md_m.is_some())
    {
        let why = "every station has a depth of its own: leave out --depth, or the stations' column md_m".to_owned();
        return Err(named(path, &Failure::BadInput(why)).into());
    }
    let mut deepest_m = f64::MIN;
    for (k, station) in stations.iter_mut().enumerate() {
        let (None, Some(t_s)) = (station.md_m, station.t_s) else { continue };
        let bad = |why: String| Failure::BadInput(format!("station {} at {t_s:.1} s {why}", k + 1));
        let (path, depths) = depths.as_ref().ok_or_else(|| {
            bad("has no depth: --depth DEPTH.csv gives the bit's by time, columns t_s,md_m".to_owned())
        })?;
        let md_m = depths.at(t_s).ok_or_else(|| {
            let [first, last] = depths.span_s().unwrap_or_default();
            bad(format!(
                "is outside of {}, {first:.1} to {last:.1} s by the tool's clock: a longer file, or --clock S, gives it a depth",
                path.display()
            ))
        })?;
        if md_m < deepest_m {
            let above = deepest_m - md_m;
            return Err(bad(format!(
                "is {above:.2} m above an earlier one: a path goes down the hole; cut the trace where the string was pulled"
            ))
            .into());
        }
        deepest_m = md_m;
        station.md_m = Some(md_m);
    }
    Ok((stations, doubts))
}

/// Doubts about the stops of a trace: each that its own check does not call good, and how many have no field.
fn doubts_about(taken: &[SurveyReport]) -> Vec<String> {
    let stops = || taken.iter().filter(|report| report.survey.kind == SurveyKind::Stationary);
    let doubt = |report: &SurveyReport| {
        let (checked, why) = (report.quality.reason, reason(report.quality.reason.checked));
        let (factor, unit) = match checked.checked {
            Checked::Gravity => (1.0, "m/s^2"),
            Checked::Field => (1.0, "microtesla"),
            _ => (1_f32.to_degrees(), "deg"),
        };
        let off = checked.difference.map_or_else(String::new, |difference| {
            let [off, limit] = [difference, checked.limit].map(|x| x * factor);
            format!(", {off:+.3} {unit} off the trace's own reference, {limit:.3} is allowed")
        });
        let (at_s, grade) = (middle_s(report), grade(report.quality.grade));
        format!("the stop at {at_s:.1} s is {grade} by its {why}{off}")
    };
    let doubtful = |report: &&SurveyReport| report.averages.field_ut.is_some() && report.quality.grade != Grade::Good;
    let mut doubts: Vec<String> = stops().filter(doubtful).map(doubt).collect();
    let without = stops().filter(|report| report.averages.field_ut.is_none()).count();
    if without > 0 {
        doubts.push(format!("{without} stops without a usable field are left out"));
    }
    doubts
}

/// Why a trace has no station, and what would give it one.
fn no_stop(path: &Path, config: &SurveyConfig, taken: &[SurveyReport]) -> Failure {
    let stops = taken.iter().filter(|report| report.survey.kind == SurveyKind::Stationary).count();
    let path = path.display();
    let why = if stops > 0 {
        format!("its {stops} stops have no usable magnetometer: a survey needs mx, my, mz at rest")
    } else {
        let (settle, mean) = (config.settle_s, config.average_s);
        format!(
            "it has no stop: a survey at rest needs {:.0} s without motion, {settle:.0} to settle and {mean:.0} of mean. Give a \
             trace with stops, or stations as CSV (docs/surveys.md has the columns)",
            settle + mean
        )
    };
    Failure::BadInput(format!("{path}: no survey at rest: {why}"))
}

fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "must be a number".to_owned())?;
    if number.is_finite() { Ok(number) } else { Err("must be a finite number".to_owned()) }
}

/// A trace is compressed, or its columns are those of samples.
fn is_trace(path: &Path) -> Result<bool, Failure> {
    if path.extension().is_some_and(|extension| extension == "gz") {
        return Ok(true);
    }
    let text = text_of(path)?;
    let header =
        unmarked(&text).lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    let columns: Vec<&str> = header.split(',').map(str::trim).collect();
    Ok(["t_s", "gx", "ax"].iter().all(|name| columns.contains(name)))
}

/// Station of a survey at rest, at the middle of its mean.
fn at_rest(report: &SurveyReport) -> Option<ReadStation> {
    let averages = report.averages;
    let field = averages.field_ut.filter(|_| report.survey.kind == SurveyKind::Stationary)?;
    let wide = |v: [f32; 3]| Vector3::from(v.map(f64::from));
    let measured = Measured::SixAxis { force_m_s2: wide(averages.force_m_s2), field_ut: wide(field) };
    let azimuth = report.survey.magnetic_azimuth_rad;
    let sigma_rad = azimuth.map(|azimuth| [report.survey.inclination_rad.sigma, azimuth.sigma].map(f64::from));
    Some(ReadStation { t_s: Some(middle_s(report)), md_m: None, measured, sag_deg: None, sigma_rad })
}

/// Middle of a survey's mean, seconds.
fn middle_s(report: &SurveyReport) -> f64 {
    (report.survey.t_start_us + report.survey.t_end_us) as f64 * 0.5e-6
}

/// Prints what was found and the path.
fn print(out: &mut impl Write, layout: Layout, run: &SurveyedRun) -> io::Result<()> {
    for warning in &run.warnings {
        writeln!(out, "warning: {warning}")?;
    }
    let provenance = &run.provenance;
    writeln!(out, "reference: {} of {} {}", provenance.model, provenance.date, provenance.place)?;
    writeln!(out, "sag: {}", run.sag_told())?;
    if let Some(analysis) = &run.analysis {
        writeln!(
            out,
            "multi-station analysis of {} stations: azimuths {}; inclinations {}",
            analysis.counted, analysis.azimuth, analysis.inclination
        )?;
        let [before, left_out] = analysis.residual;
        writeln!(
            out,
            "residuals in units of the noise: {before:.2} uncorrected, {left_out:.2} as the other stations predict; noise \
             times {:.2}",
            libm::sqrtf(analysis.noise_ratio)
        )?;
        for (name, value, sigma, prior, observable) in &analysis.estimates {
            let told = if *observable { "observable" } else { "not observable" };
            let value = fixed(*value, 5);
            match layout {
                Layout::Table => {
                    writeln!(out, "  {name:<24}{value:>10} +- {sigma:.5} (before {prior:.5}) {told}")?;
                }
                Layout::Lines => writeln!(out, "  {name} {value} +- {sigma:.5} (before {prior:.5}) {told}")?,
            }
        }
        if analysis.axial_field_grows {
            writeln!(out, "the drill string's field grew over the run")?;
        }
    }
    if run.correction == Correction::Axial {
        let no_go = run.stations.iter().filter(|station| station.axial_no_go == Some(true)).count();
        let count = run.stations.len();
        writeln!(out, "short-collar correction: {no_go} of {count} stations in its no-go zone, left as measured")?;
    }
    writeln!(out, "uncertainty of positions: tool code {}", run.tool_codes.join(" and "))?;
    let north = if run.convergence_deg.is_some() { "grid" } else { "true" };
    if layout == Layout::Table {
        writeln!(
            out,
            "     md, m  incl, deg  azi ({north}), deg    +-    tvd, m   north, m    east, m deg/30m  1-sigma ellipse, m"
        )?;
    }
    for s in &run.stations {
        let [n, e, tvd] = s.position_m;
        let [major, minor, azimuth] = s.ellipse;
        let sigma = s.sigma_azimuth_deg.map_or_else(|| "-".to_owned(), |sigma| format!("{sigma:.2}"));
        let doubted = match (s.doubted, s.off_reference.is_some_and(|off| is_off(&off))) {
            (true, _) => "  contradicted by the others",
            (false, true) => "  off the reference",
            (false, false) => "",
        };
        if layout == Layout::Lines {
            let [east, north_m] = [e, n].map(|x| fixed(x, 2));
            writeln!(
                out,
                "station at {:.2} m: inclination {:.2} deg, azimuth ({north}) {:.2} +- {sigma} deg, tvd {tvd:.2} m, north \
                 {north_m} m, east {east} m, dogleg {:.2} deg/30 m, ellipse {major:.2} x {minor:.2} m at {azimuth:.0} \
                 deg{doubted}",
                s.md_m, s.inclination_deg, s.azimuth_deg, s.dogleg_deg_30m
            )?;
            continue;
        }
        writeln!(
            out,
            "{:>10.2} {:>10.2} {:>16.2} {sigma:>5} {tvd:>9.2} {n:>10.2} {e:>10.2} {:>7.2}  {major:.2} x {minor:.2} at \
             {azimuth:.0}{doubted}",
            s.md_m, s.inclination_deg, s.azimuth_deg, s.dogleg_deg_30m
        )?;
    }
    Ok(())
}
