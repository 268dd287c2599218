//! Files of a run, and the records that a receiver gets.

use std::{io::Read, net::TcpListener, thread};

use mwd::surveys::{
    files,
    reference::Reference,
    run::SurveyedRun,
    settings::RunSettings,
    simulated_run::{Run, TrueRun},
    stations_csv::read,
    surveyed::surveyed,
};

/// Place, date and a grid; the reference is the simulated run's own.
fn settings(run: &TrueRun) -> RunSettings {
    let reference = run.stations[0].station.reference;
    let text = format!(
        "well = \"A & B <1>\"\nlatitude_deg = 60.0\nlongitude_deg = 358.0\ndate = \"2026-06-01\"\n\
         grid = {{ utm_zone = 31 }}\n[reference]\nmodel = \"fixed\"\nname = \"simulated\"\ndate = \"2026-06-01\"\n\
         field_nt = {}\ndip_deg = {}\ndeclination_deg = -1.5\ngravity_m_s2 = 9.81\n",
        1e3 * f64::from(reference.field_ut),
        f64::from(reference.dip_rad).to_degrees()
    );
    RunSettings::parse(&text).unwrap()
}

/// Stations as another program writes them.
fn stations_csv(run: &TrueRun) -> String {
    let mut text = "md_m,gx_g,gy_g,gz_g,bx_nt,by_nt,bz_nt\n".to_owned();
    for truth in &run.stations {
        let g = truth.station.force_m_s2.map(|x| -f64::from(x) / 9.806_65);
        let b = truth.station.field_ut.map(|x| 1e3 * f64::from(x));
        text += &format!("{},{},{},{},{},{},{}\n", truth.station.depth_m, g[0], g[1], g[2], b[0], b[1], b[2]);
    }
    text
}

fn worked_out(seed: u64) -> (TrueRun, SurveyedRun) {
    let drawn = Run::default().drawn(seed);
    let settings = settings(&drawn);
    let reference = Reference::of(&settings).unwrap();
    let run = surveyed(&read(&stations_csv(&drawn)).unwrap(), &settings, &reference).unwrap();
    (drawn, run)
}

#[test]
fn a_run_from_six_axes_has_the_true_directions_within_its_sigmas_and_a_path() {
    let (mut within, mut all) = (0, 0);
    for seed in 0..20 {
        let (drawn, run) = worked_out(seed);
        assert_eq!(run.stations.len(), 40);
        let convergence = run.convergence_deg.unwrap();
        for (truth, station) in drawn.stations.iter().zip(&run.stations) {
            if truth.inclination_rad < 0.09 || station.doubted {
                continue;
            }
            all += 1;
            let grid = truth.azimuth_rad.to_degrees() - 1.5 - convergence;
            let off = libm::remainder(station.azimuth_deg - grid, 360.0).abs();
            within += i32::from(off < 2.0 * station.sigma_azimuth_deg.unwrap());
            assert!((station.inclination_deg - truth.inclination_rad.to_degrees()).abs() < 0.2);
        }
        let last = run.stations.last().unwrap();
        // The last of 40 stations, 39 x 30 m down the hole.
        let [north, east, tvd] = last.position_m;
        // Without a stated start the hole above the first station, at 1,000 m, is vertical, and that is said.
        let length = (north * north + east * east + (tvd - 1_000.0).powi(2)).sqrt();
        assert!(run.warnings.iter().any(|warning| warning.contains("above 1000.0 m")), "{:?}", run.warnings);
        assert!(length < 1_170.0 + 1e-6 && last.ellipse[0] >= last.ellipse[1] && last.ellipse[0] > 0.5, "{length}");
    }
    assert!(within as f64 > 0.93 * f64::from(all), "{within} of {all}");
}

#[test]
fn every_file_has_every_station_and_text_cannot_break_it() {
    let (_, run) = worked_out(5);
    let plain = files::csv::plain(&run);
    assert_eq!((plain.lines().next(), plain.lines().count()), (Some("md,inc,azi"), 41));
    let full = files::csv::full(&run);
    assert!(full.contains("\n# covariances count from = the first station, at 1000.00 m\n"), "{full}");
    assert!(run.warnings.iter().any(|warning| warning.contains("count from the first station, at 1000.0 m")));
    let rows: Vec<&str> = full.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(rows.len(), 41);
    let columns = rows[0].split(',').count();
    assert!(rows.iter().all(|row| row.split(',').count() == columns), "{full}");
    for (text, tag) in
        [(files::witsml1::witsml(&run), "<trajectoryStation "), (files::witsml2::witsml(&run), "<TrajectoryStation ")]
    {
        assert_eq!(text.matches(tag).count(), 40);
        assert!(text.contains("A &amp; B &lt;1&gt;") && !text.contains("A & B"));
    }
    let las = files::las::las(&run);
    assert_eq!(las.split("~ASCII").nth(1).unwrap().lines().count(), 41);
    let json: serde_json::Value = serde_json::from_str(&files::json(&run).unwrap()).unwrap();
    assert_eq!(json["schema"], "meerkat-mwd-survey/1");
    assert_eq!(json["stations"].as_array().unwrap().len(), 40);
}

/// Model and day of the reference stand with every station, in each format that has a place for them there.
#[test]
fn every_station_says_what_its_reference_is() {
    let (_, run) = worked_out(5);
    let full = files::csv::full(&run);
    let mut table = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(full.as_bytes());
    let header = table.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    let (model, date) = (column("reference_model"), column("reference_date"));
    let north = [column("declination_deg"), column("convergence_deg")];
    let convergence = format!("{:.4}", run.convergence_deg.unwrap());
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    assert!(rows.len() == 40 && rows.iter().all(|row| &row[model] == "simulated" && &row[date] == "2026-06-01"));
    assert!(rows.iter().all(|row| north.map(|k| &row[k]) == ["-1.5000", convergence.as_str()]), "{full}");
    let json: serde_json::Value = serde_json::from_str(&files::json(&run).unwrap()).unwrap();
    for station in json["stations"].as_array().unwrap() {
        assert_eq!(
            (&station["reference_model"], &station["reference_date"]),
            (&"simulated".into(), &"2026-06-01".into())
        );
        assert_eq!(station["convergence_deg"].as_f64(), run.convergence_deg);
    }
    for text in [files::witsml1::witsml(&run), files::witsml2::witsml(&run)] {
        let small = text.to_lowercase();
        assert_eq!(small.matches("<magmodelused>simulated</magmodelused>").count(), 40);
        assert_eq!(small.matches("<magmodelvalid>2026-06-01</magmodelvalid>").count(), 40);
        assert_eq!(small.matches("<stnmagdeclused uom=\"dega\">-1.5000</stnmagdeclused>").count(), 40);
        // The angle from true to grid north; `gridCorUsed` is another name for it that both schemas gave up.
        for (element, count) in [("stngridconused", 40), ("gridconused", 1)] {
            assert_eq!(small.matches(&format!("<{element} uom=\"dega\">{convergence}<")).count(), count, "{element}");
        }
    }
    let las = files::las::las(&run);
    assert!(las.contains(" MODL. simulated :") && las.contains("2026-06-01"));
    assert!(las.contains(&format!(" {:>11} {:>11}\n", "-1.5000", convergence)), "{las}");
}

/// A name that no file could hold is refused where it is read.
#[test]
fn a_name_with_a_line_break_is_refused() {
    assert!(RunSettings::parse("well = \"A\\nB\"\n").unwrap_err().to_string().contains("line break"));
    let fixed = "[reference]\nmodel = \"fixed\"\nname = \"IFR\\u0001\"\ndate = \"2026-06-01\"\nfield_nt = 50000\n\
                 dip_deg = 70\ndeclination_deg = 0\ngravity_m_s2 = 9.81\n";
    let error = Reference::of(&RunSettings::parse(fixed).unwrap()).unwrap_err().to_string();
    assert!(error.contains("name of the reference"), "{error}");
}

/// Elements of a station in WITSML 1.4.1.1, in the order that its schema demands (`grp_trajectoryStation`, as open
/// programs for that version list it), down to what is written here.
const STATION_1_4_1_1: [&str; 60] = [
    "target",
    "dTimStn",
    "typeTrajStation",
    "typeSurveyTool",
    "calcAlgorithm",
    "md",
    "tvd",
    "incl",
    "azi",
    "mtf",
    "gtf",
    "dispNs",
    "dispEw",
    "vertSect",
    "dls",
    "rateTurn",
    "rateBuild",
    "mdDelta",
    "tvdDelta",
    "modelToolError",
    "iscwsaToolErrorModel",
    "gravTotalUncert",
    "dipAngleUncert",
    "magTotalUncert",
    "gravAccelCorUsed",
    "magXAxialCorUsed",
    "sagCorUsed",
    "magDrlstrCorUsed",
    "infieldRefCorUsed",
    "interpolatedInfieldRefCorUsed",
    "inHoleRefCorUsed",
    "axialMagInterferenceCorUsed",
    "cosagCorUsed",
    "MSACorUsed",
    "gravTotalFieldReference",
    "magTotalFieldReference",
    "magDipAngleReference",
    "magModelUsed",
    "magModelValid",
    "geoModelUsed",
    "statusTrajStation",
    "rawData",
    "gravAxialRaw",
    "gravTran1Raw",
    "gravTran2Raw",
    "magAxialRaw",
    "magTran1Raw",
    "magTran2Raw",
    "corUsed",
    "sagIncCor",
    "stnMagDeclUsed",
    "stnGridConUsed",
    "valid",
    "magTotalFieldCalc",
    "magDipAngleCalc",
    "gravTotalFieldCalc",
    "matrixCov",
    "varianceNN",
    "varianceNE",
    "varianceNVert",
];

#[test]
fn elements_of_a_witsml_1_station_are_the_schemas_in_its_order() {
    let order: Vec<&str> =
        STATION_1_4_1_1.into_iter().chain(["varianceEE", "varianceEVert", "varianceVertVert"]).collect();
    let (_, run) = worked_out(5);
    let text = files::witsml1::witsml(&run);
    // Values that the schema limits: a list of kinds, and identifiers without a space.
    assert_eq!(text.matches("<typeTrajStation>magnetic MWD</typeTrajStation>").count(), 40);
    let head = text.split("<nameWell>").next().unwrap();
    let uids: Vec<&str> = head.split("uid").skip(1).map(|uid| uid.split('"').nth(1).unwrap()).collect();
    assert!(uids.len() == 3 && uids.iter().all(|uid| uid.len() == 36 && !uid.contains(' ')), "{uids:?}");
    for station in text.split("<trajectoryStation ").skip(1) {
        let station = station.split("</trajectoryStation>").next().unwrap();
        let names: Vec<&str> = station
            .split('<')
            .skip(1)
            .filter(|tag| !tag.starts_with('/'))
            .map(|tag| tag.split([' ', '>']).next().unwrap())
            .collect();
        let places: Vec<Option<usize>> =
            names.iter().map(|name| order.iter().position(|known| known == name)).collect();
        assert!(names.len() > 20 && places.iter().all(Option::is_some) && places.is_sorted(), "{names:?}");
    }
}

#[test]
fn a_receiver_gets_a_record_of_each_station() {
    let (_, run) = worked_out(6);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let receiver = thread::spawn(move || {
        let mut text = String::new();
        listener.accept().unwrap().0.read_to_string(&mut text).unwrap();
        text
    });
    files::wits0::send(&run, &address).unwrap();
    let text = receiver.join().unwrap();
    let records: Vec<&str> = text.split("&&\r\n").skip(1).collect();
    assert_eq!(records.len(), 40);
    for (record, station) in records.iter().zip(&run.stations) {
        assert!(record.ends_with("!!\r\n"));
        let item = |number: &str| -> f64 {
            record.lines().find_map(|line| line.strip_prefix(number)).unwrap().parse().unwrap()
        };
        // Degrees in a hundred metres; and the hole's depth, which is not the station's, is not made up.
        assert!((item("0720") - station.dogleg_deg_30m / 0.3).abs() < 6e-4 && !record.contains("\n0711"));
        assert!((item("0708") - station.md_m).abs() < 0.006 && (item("0713") - station.inclination_deg).abs() < 6e-4);
        assert!(
            (item("0715") - station.azimuth_deg).abs() < 6e-4 && (item("0718") - station.position_m[0]).abs() < 0.006
        );
    }
    assert!(files::wits0::send(&run, "127.0.0.1:1").is_err());
}
