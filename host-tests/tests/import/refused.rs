//! What cannot be is refused, with the fix that makes it right.

use mwd::import::{ColumnMap, Import, Verdict, import};
use tempfile::TempDir;

use crate::files::{flies_as_the_original, imported, si, with_map, written};

type Change = fn([f64; 3]) -> [f64; 3];

/// What is wrong, and the fix; one finding only.
fn wrong(told: &Import) -> (String, String) {
    let wrong: Vec<_> = told.findings.iter().filter(|finding| finding.verdict == Verdict::Wrong).collect();
    assert_eq!(wrong.len(), 1, "{:#?}", told.findings);
    (wrong[0].told.clone(), wrong[0].fix.clone().unwrap())
}

/// The fix of a finding, as lines of a map.
fn as_map(fix: &str) -> String {
    let (setting, section) = fix.rsplit_once(" in [").unwrap();
    format!("[{}\n{setting}\n", section)
}

/// Turned axes are refused by name, and with the fix as a map the flight is the original's.
#[test]
fn turned_axes_are_named_and_the_fix_makes_them_right() {
    let folder = TempDir::new().unwrap();
    const SAME: Change = |v| v;
    let cases: [(&str, [Change; 3]); 6] = [
        ("axes of the gyro", [|[x, y, z]| [-y, x, z], SAME, SAME]),
        ("axes of the gyro", [|[x, y, z]| [x, -y, z], SAME, SAME]),
        ("axes of the gyro", [|[x, y, z]| [x, z, y], SAME, SAME]),
        // An AK8963 in an MPU-9250, as it comes.
        ("axes of the magnetometer", [SAME, SAME, |[x, y, z]| [y, x, -z]]),
        ("axes of the magnetometer", [SAME, SAME, |[x, y, z]| [x, -y, -z]]),
        ("axes of the magnetometer", [SAME, SAME, |[x, y, z]| [x, y, -z]]),
    ];
    for (index, (what, changes)) in cases.into_iter().enumerate() {
        let path = written(&folder, &format!("{index}.csv"), &si(changes));
        let (told, fix) = wrong(&imported(std::slice::from_ref(&path)));
        assert!(told.starts_with(what), "{index}: {told}: {fix}");
        flies_as_the_original(&with_map(&path, &as_map(&fix)));
    }
}

#[test]
fn wrong_units_are_refused_with_the_right_one() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, "log.csv", &si([|v| v.map(f64::to_degrees), |v| v.map(|x| x / 9.806_65), |v| v]));
    for (map, fix) in [
        ("[gyro]\nunit = 'rad/s'", "unit = \"deg/s\" in [gyro]"),
        ("[accel]\nunit = 'm/s^2'", "unit = \"g\" in [accel]"),
        ("[mag]\nunit = 'nT'", "unit = \"uT\" in [mag]"),
    ] {
        assert_eq!(wrong(&with_map(&path, map)).1, fix);
    }
    flies_as_the_original(&with_map(&path, "[gyro]\nunit = 'deg/s'"));
}

#[test]
fn an_acceleration_without_gravity_and_a_dead_axis_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = written(&folder, "log.csv", &si([|v| v, |v| v, |[x, _, z]| [x, 12.0, z]]));
    let told = imported(&[path]);
    assert!(
        told.findings.iter().any(|f| f.told == "magnetometer y, column \"my\", never changes"),
        "{:?}",
        told.findings
    );
    let still: String = (0..2_000).map(|i| format!("{},0.01,0,0.0{},0.0{},0.01,0.02\n", i * 5, i % 3, i % 7)).collect();
    let path = written(&folder, "still.csv", &format!("t_ms,gx,gy,gz,ax,ay,az\n{still}"));
    let told = with_map(&path, "[accel]\nunit = 'm/s^2'");
    assert!(told.findings.iter().any(|f| f.fix.as_deref().is_some_and(|fix| fix.starts_with("gravity was taken out"))));
}

#[test]
fn a_message_names_what_is_there() {
    let folder = TempDir::new().unwrap();
    let said = |text: &str, map: &str| {
        let path = written(&folder, "log.csv", text);
        let map: ColumnMap = toml::from_str(map).unwrap();
        import(&[path], &map, &[]).map(|_| ()).unwrap_err().to_string()
    };
    let table = "t_s,a,b,c,d,e,f\n0,1,2,3,4,5,6\n0.01,1,2,3,4,5,6\n";
    let told = said(table, "");
    assert!(
        told.starts_with("no columns of the gyro are known") && told.contains("log: t_s, a, b, c, d, e, f"),
        "{told}"
    );
    let told = said(table, "[gyro]\ncolumns = ['a', 'b', 'x']");
    assert_eq!(told, "[gyro] of the map: there is no column \"x\"; there are t_s, a, b, c, d, e, f");
    let told = said(table, "[gyro]\ncolumns = ['a', 'b', 'c']\nunit = 'furlong'");
    assert!(told.contains("unit \"furlong\" is not known; known are rad/s, deg/s"), "{told}");
    let told = said("k,gx,gy,gz,ax,ay,az\n0,1,2,3,4,5,6\n", "");
    assert!(told.contains("rate_hz"), "{told}");
    let told = said("t_s,gx,gy,gz,ax,ay,az\n0,1,2,3,4,5,6\n0.01,1,oops,3,4,5,6\n", "");
    assert_eq!(told, "log: line 3, column gy: \"oops\" is not a number (1 such cells)");
    assert!(said("PK\u{3}\u{4}rest", "").ends_with("a zip archive: unpack it and name the files or their folder"));
}
