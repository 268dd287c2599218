//! Errors and omissions in a run's files are told with the file, the place in it, and what mends them.

use std::{fs, process::Command};

use tempfile::TempDir;

const RUN: &str = "latitude_deg = 57.8\nlongitude_deg = 362.1\ndate = \"2026-08-08\"\nstart_m = [0.0, 0.0, 600.0]\n";
const TABLE: &str = "# name = IFR-1\n# date = 2026-08-01\ntvd_m,field_nt,dip_deg,declination_deg\n0,50790,71.29,1.56\n\
                     800,50850,71.30,1.57\n";
const HEADER: &str = "md_m,gx_g,gy_g,gz_g,bx_nt,by_nt,bz_nt";
/// Two stations, of 2 and 4 deg.
const ROWS: [&str; 2] = [
    "600,-0.015061,0.030999,1.000791,-4401.5,-14399.7,49028.2",
    "629,-0.013735,-0.074362,0.998639,11600.3,7067.4,49426.8",
];

/// True if the program succeeds, and the text that it prints on its way.
fn said(run: &str, stations: &[u8]) -> (bool, String) {
    said_with(run, stations, &[])
}

/// The same, with further arguments; the folder has a file of depths.
fn said_with(run: &str, stations: &[u8], further: &[&str]) -> (bool, String) {
    said_beside(run, stations, further, "t_s,md_m\n0,600\n100,629\n")
}

/// The same, with another text in the file of depths.
fn said_beside(run: &str, stations: &[u8], further: &[&str], depths: &str) -> (bool, String) {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("run.toml"), run).unwrap();
    fs::write(path("ifr.csv"), TABLE).unwrap();
    fs::write(path("stations.csv"), stations).unwrap();
    fs::write(path("depths.csv"), depths).unwrap();
    let mut mwd = Command::new(env!("CARGO_BIN_EXE_mwd"));
    mwd.arg("survey").arg(path("stations.csv")).arg("--run").arg(path("run.toml")).args(further);
    let output = mwd.current_dir(folder.path()).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8(text).unwrap())
}

fn csv(header: &str, rows: &[&str]) -> Vec<u8> {
    [&[header], rows].concat().join("\n").into_bytes()
}

#[test]
fn a_table_counts_from_the_folder_of_the_settings_and_says_how_far_it_reaches() {
    let with_table = format!("{RUN}[reference]\nmodel = \"file\"\npath = \"ifr.csv\"\n");
    let (done, text) = said(&with_table, &csv(HEADER, &ROWS));
    assert!(done && text.contains("reference: IFR-1 of 2026-08-01 57.8 N 2.1 E"), "{text}");
    let below = with_table.replace("600.0", "790.0");
    let (done, text) = said(&below, &csv(HEADER, &ROWS));
    assert!(!done && text.contains("reference table IFR-1: reaches from 0.0 to 800.0 m"), "{text}");
    let (done, text) = said(&with_table.replace("ifr", "none"), &csv(HEADER, &ROWS));
    assert!(!done && text.contains("none.csv: cannot be read"), "{text}");
}

#[test]
fn settings_that_cannot_be_are_refused_by_their_file() {
    let (done, text) = said(&format!("{RUN}grid = {{ utm_zone = 91 }}\n"), &csv(HEADER, &ROWS));
    assert!(!done && text.contains("run.toml: grid.utm_zone = 91: must be from 1 to 60"), "{text}");
}

#[test]
fn an_error_that_has_no_size_is_refused_by_its_name() {
    for (table, told) in [
        ("[errors]\nmag_bias_ut = -0.5\n", "run.toml: errors.mag_bias_ut: must be finite and positive"),
        ("[errors]\nmag_scale = nan\n", "run.toml: errors.mag_scale: must be finite and positive"),
        (
            "[multi_station]\nfield_noise_ut = 0.0\n",
            "run.toml: multi_station.field_noise_ut = 0.0: must be finite and above 0",
        ),
    ] {
        let (done, text) = said(&format!("{RUN}{table}"), &csv(HEADER, &ROWS));
        assert!(!done && text.contains(told), "{text}");
    }
}

#[test]
fn a_table_of_the_field_with_an_impossible_angle_or_two_columns_of_a_name_is_refused() {
    let run = format!("{RUN}[reference]\nmodel = \"file\"\npath = \"depths.csv\"\n");
    for (was, is, told) in [
        ("71.29", "101.29", "line 4: dip_deg = 101.29: must be from -90 to 90"),
        ("1.56", "-190", "line 4: declination_deg = -190: must be from -180 to 180"),
        (
            "tvd_m,field_nt",
            "tvd_m,tvd_m,field_nt",
            "columns \"tvd_m\" and \"tvd_m\" are both tvd_m: leave out one of them",
        ),
    ] {
        let table = TABLE.replace(was, is);
        let (done, text) = said_beside(&run, &csv(HEADER, &ROWS), &[], &table);
        assert!(!done && text.contains(told), "{text}");
    }
}

#[test]
fn a_distance_that_is_no_number_is_refused() {
    let by_time =
        csv("t_s,gx_g,gy_g,gz_g,bx_nt,by_nt,bz_nt", &["0,-0.015061,0.030999,1.000791,-4401.5,-14399.7,49028.2"]);
    for option in ["--bit-to-tool=nan", "--clock=inf"] {
        let (done, text) = said_with(RUN, &by_time, &["--depth", "depths.csv", option]);
        assert!(!done && text.contains("must be a finite number"), "{text}");
    }
}

#[test]
fn stations_that_cannot_be_used_are_told_with_what_mends_them() {
    let units = HEADER.replace("_g", "_mg");
    let (done, text) = said(RUN, &csv(&units, &ROWS));
    assert!(!done && text.contains("station 1 at 600.00 m: gravity of 0.0098 m/s^2"), "{text}");
    assert!(text.contains("check the unit and the values of the gravity columns"), "{text}");
    let (done, text) = said(RUN, b"\xff\xfem\0d\0");
    assert!(!done && text.contains("it is no text in UTF-8") && text.contains("next: save it as plain text"), "{text}");
}

#[test]
fn an_analysis_that_is_asked_for_and_not_made_is_told() {
    let (done, text) = said(RUN, &csv(HEADER, &ROWS));
    assert!(
        done && text.contains("no multi-station analysis") && text.contains("2 stations have gravity and field"),
        "{text}"
    );
    let (done, text) = said(&format!("{RUN}correction = \"none\"\n"), &csv(HEADER, &ROWS));
    assert!(done && !text.contains("no multi-station analysis"), "{text}");
    let angles = csv("md_m,inclination_deg,magnetic_azimuth_deg", &["600,2,40", "629,4,40"]);
    let (done, text) = said(RUN, &angles);
    assert!(done && !text.contains("no multi-station analysis"), "{text}");
}

#[test]
fn a_short_collar_correction_that_is_asked_for_and_not_made_is_told() {
    let axial = format!("{RUN}correction = \"axial\"\n");
    let (done, text) = said(&axial, &csv(HEADER, &ROWS));
    assert!(done && !text.contains("no short-collar correction"), "{text}");
    let angles = csv("md_m,inclination_deg,magnetic_azimuth_deg", &["600,2,40", "629,4,40"]);
    let (done, text) = said(&axial, &angles);
    assert!(
        done && text.contains("no short-collar correction at 2 stations: they have no gravity and field"),
        "{text}"
    );
    // Twice the field across the axis: none along it agrees with the reference.
    let strong = ["600,-0.015061,0.030999,1.000791,-4401.5,-14399.7,49028.2", "629,-0.5,0.5,0.70,45000,45000,49426.8"];
    let (done, text) = said(&axial, &csv(HEADER, &strong));
    assert!(done && text.contains("no short-collar correction at 1 stations: no field along the axis"), "{text}");
}

#[test]
fn a_station_that_is_off_the_reference_is_told_by_its_depth() {
    let place = "[reference]\nmodel = \"fixed\"\nname = \"survey\"\ndate = \"2026-08-08\"\nfield_nt = 51275\ndip_deg = 71.44\n\
                 declination_deg = 1.5\ngravity_m_s2 = 9.8208\n";
    let run = format!("{RUN}{place}");
    let near_steel = ROWS[1].replace("11600.3", "12600.3");
    let (done, text) = said(&run, &csv(HEADER, &[ROWS[0], &near_steel]));
    let told = "warning: 1 of 2 stations read gravity, field or dip off the reference";
    assert!(done && text.contains(told) && text.contains("at 629.0 m"), "{text}");
    assert_eq!(text.matches("  off the reference").count(), 1, "{text}");
    let (done, text) = said(&run, &csv(HEADER, &ROWS));
    assert!(done && !text.contains("stations read gravity"), "{text}");
}

#[test]
fn a_file_of_depths_that_no_station_needs_is_refused() {
    let (done, text) = said_with(RUN, &csv(HEADER, &ROWS), &["--depth", "depths.csv"]);
    assert!(!done && text.contains("depths.csv: every station has a depth of its own: leave out --depth"), "{text}");
}

#[test]
fn no_output_overwrites_an_input_or_another_one() {
    let with_table = format!("{RUN}[reference]\nmodel = \"file\"\npath = \"ifr.csv\"\n");
    for option in ["--csv", "--plain", "--witsml1", "--witsml2", "--las", "--json", "--html"] {
        for input in ["stations.csv", "run.toml", "ifr.csv"] {
            let (done, text) = said_with(&with_table, &csv(HEADER, &ROWS), &[option, input]);
            let told = format!("{input}: the result would overwrite what is read");
            assert!(!done && text.contains(&told), "{option} {input}: {text}");
        }
    }
    let by_time =
        csv(&HEADER.replace("md_m", "t_s"), &ROWS.map(|row| row.replacen('6', "", 1)).each_ref().map(|r| &**r));
    let (done, text) = said_with(RUN, &by_time, &["--depth", "depths.csv", "--csv", "depths.csv"]);
    assert!(!done && text.contains("depths.csv: the result would overwrite what is read"), "{text}");
    let (done, text) = said_with(RUN, &csv(HEADER, &ROWS), &["--csv", "out", "--json", "./out"]);
    assert!(!done && text.contains("./out: the result would overwrite another one"), "{text}");
}

#[test]
fn an_angle_out_of_its_range_is_told_with_its_place() {
    let angles = csv("md_m,inclination_deg,magnetic_azimuth_deg", &["600,2,40", "629,200,40"]);
    let (done, text) = said(RUN, &angles);
    let told = "stations.csv: line 3: column inclination_deg: \"200\" is out of range: must be 0 to 180 deg";
    assert!(!done && text.contains(told), "{text}");
}

#[test]
fn two_groups_of_columns_for_one_quantity_are_refused() {
    let twice = |header: &str, rest: &str| {
        let rows = ROWS.map(|row| format!("{row},{rest}"));
        csv(header, &rows.each_ref().map(|row| &**row))
    };
    for (more, rest, told) in [
        ("MD (ft)", "1968.5", "columns \"md_m\" and \"MD (ft)\" are both depth: leave out one of them"),
        (
            "ax_m_s2,ay_m_s2,az_m_s2",
            "0.1,-0.3,-9.8",
            "columns \"ax_m_s2, ay_m_s2, az_m_s2\" and \"gx_g, gy_g, gz_g\" are both gravity: leave out one of them",
        ),
        (
            "Bx (uT),By (uT),Bz (uT)",
            "-4.4,-14.4,49.0",
            "columns \"Bx (uT), By (uT), Bz (uT)\" and \"bx_nt, by_nt, bz_nt\" are both field: leave out one of them",
        ),
    ] {
        let (done, text) = said(RUN, &twice(&format!("{HEADER},{more}"), rest));
        assert!(!done && text.contains(told), "{text}");
    }
    // One axis of another group is no second group.
    let (done, text) = said(RUN, &twice(&format!("{HEADER},ax_m_s2"), "0.1"));
    assert!(done, "{text}");
    let (done, text) = said_beside(
        RUN,
        &csv(&HEADER.replace("md_m", "t_s"), &ROWS),
        &["--depth", "depths.csv"],
        "t_s,md_m,md_ft\n0,600,1968\n9999,629,2063\n",
    );
    assert!(!done && text.contains("columns \"md_m\" and \"md_ft\" are both depth"), "{text}");
}
