//! Unit and axes of the gyro against the vectors, and of the vectors against each other.

use nalgebra::{Matrix3, Vector3};

use super::{
    super::{
        resolve::{in_words, name},
        rotation_fit::{Axes, RotationFit, fit},
        units::{Quantity, STANDARD_GRAVITY},
    },
    Finding, Imported,
};
use testbed::trace::BodyFrame;

/// Factor by which a gyro's scale may be off; a unit is off by 57.
const SCALE: std::ops::RangeInclusive<f64> = 0.7..=1.4;
/// Share of the vectors' turning that has to be explained before nothing else can be the cause.
const SURELY: f64 = 0.8;
/// Seconds at rest with the tool's axis this far up, degrees of inclination, and a field that points up, from
/// which gravity is upside down.
const UP_THE_HOLE_DEG: f64 = 100.0;
/// Dip that is the known one, degrees.
const AS_STATED_DEG: f64 = 4.0;
/// Dip that a known one may be missed by, degrees.
const DIP_DEG: f64 = 25.0;

pub(super) fn check(imported: &Imported) -> Vec<Finding> {
    let merged = imported.merged;
    let to = |rows: &[[f64; 4]]| if rows.is_empty() { None } else { fit(&merged.t_us, &merged.gyro, rows) };
    let (to_accel, to_mag) = (to(&merged.accel), to(&merged.mag));
    let mut findings = scale(imported, to_mag.or(to_accel));
    findings.extend(order(imported, to_accel, to_mag));
    findings.extend(dip(imported));
    findings
}

fn scale(imported: &Imported, fit: Option<RotationFit>) -> Vec<Finding> {
    let Some(RotationFit { scale, explained, .. }) = fit else {
        return vec![Finding::note(
            "unit and axes of the gyro cannot be told from this motion: it turns too little".into(),
        )];
    };
    let told = format!(
        "the vectors turn at {scale:.3} times the gyro's rate ({:.0} % of their turning explained)",
        100.0 * explained
    );
    if SCALE.contains(&scale) {
        return vec![Finding::fine(told)];
    }
    let now =
        imported.map.gyro.unit.as_deref().and_then(|unit| Quantity::Gyro.unit(unit)).map_or(1.0, |unit| unit.factor);
    let fits = Quantity::Gyro.units().iter().find(|unit| SCALE.contains(&(scale * now / unit.factor)));
    let fix = fits.map_or_else(
        || "columns, unit or time_unit in [gyro]".into(),
        |unit| format!("unit = {:?} in [gyro]", unit.name),
    );
    vec![Finding::wrong(told, fix).unless(fits.is_some() && explained > SURELY)]
}

fn order(imported: &Imported, to_accel: Option<RotationFit>, to_mag: Option<RotationFit>) -> Vec<Finding> {
    // Two vectors that say the same of an axis need not both be undisturbed.
    let turned = [to_accel, to_mag].into_iter().flatten().filter(|fit| fit.axes != Axes::IDENTITY);
    let is_sure = turned.into_iter().any(|fit| fit.explained > SURELY);
    order_told(imported, to_accel, to_mag).into_iter().map(|finding| finding.unless(is_sure)).collect()
}

fn order_told(imported: &Imported, to_accel: Option<RotationFit>, to_mag: Option<RotationFit>) -> Vec<Finding> {
    let (accel, mag) = (to_accel.map(|fit| fit.axes), to_mag.map(|fit| fit.axes));
    let is_wrong = |axes: Option<Axes>| axes.filter(|axes| *axes != Axes::IDENTITY);
    match (is_wrong(accel), is_wrong(mag)) {
        (None, None) => match (accel, mag) {
            (None, None) => Vec::new(),
            (Some(_), Some(_)) => vec![Finding::fine("axes of the gyro agree with gravity and field".into())],
            (Some(_), None) => vec![Finding::fine("axes of the gyro agree with gravity".into())],
            (None, Some(_)) => vec![Finding::fine("axes of the gyro agree with the field".into())],
        },
        // Both vectors say the same of the gyro, or only one can speak.
        (Some(a), Some(m)) if a == m => vec![of_gyro(imported, a, "gravity and field say")],
        // An odd order of axes cannot be a vector's: with all its axes turned round it is even. The other vector
        // may agree with the gyro where it does not turn.
        (None, Some(m)) if m.matrix().determinant() < 0.0 => vec![of_gyro(imported, m, "the field says")],
        (Some(a), None) if mag.is_none() || a.matrix().determinant() < 0.0 => {
            vec![of_gyro(imported, a, "gravity says")]
        }
        // Gravity does not speak: the field's angle to it does, which only the right axes hold steady.
        (None, Some(m)) if accel.is_none() && vectors_agree_as_they_are(imported, m) => {
            vec![of_gyro(imported, m, "the field says")]
        }
        (None, Some(m)) => vec![of_vector(imported, Quantity::Mag, m)],
        (Some(a), None) => vec![of_vector(imported, Quantity::Accel, a)],
        (Some(a), Some(m)) => vec![of_vector(imported, Quantity::Accel, a), of_vector(imported, Quantity::Mag, m)],
    }
}

fn of_gyro(imported: &Imported, axes: Axes, who: &str) -> Finding {
    let columns = columns(imported, Quantity::Gyro, axes);
    Finding::wrong(
        format!("axes of the gyro are wrong: {who} {}", told(axes)),
        format!("columns = {columns} in [gyro]"),
    )
}

/// Returns true if the angle between field and gravity is steadier as they are than with the field's axes turned so
/// that they agree with the gyro.
fn vectors_agree_as_they_are(imported: &Imported, seen: Axes) -> bool {
    let merged = imported.merged;
    let spread = |matrix: &Matrix3<f64>| {
        let sines = sines_of_dip(&merged.accel, &turned(&merged.mag, matrix));
        let mean = sines.iter().sum::<f64>() / sines.len() as f64;
        sines.iter().map(|sine| (sine - mean) * (sine - mean)).sum::<f64>()
    };
    spread(&Matrix3::identity()) <= spread(&(seen.matrix().transpose() * seen.matrix().determinant()))
}

/// Readings with other axes.
fn turned(rows: &[[f64; 4]], matrix: &Matrix3<f64>) -> Vec<[f64; 4]> {
    let turn = |row: &[f64; 4]| {
        let v = matrix * Vector3::new(row[0], row[1], row[2]);
        [v.x, v.y, v.z, 0.0]
    };
    rows.iter().map(turn).collect()
}

/// A vector read as `v = S u` makes the gyro look turned by `det(S) S^T`: so `S` is known up to its sign,
/// and of both the one that makes the field dip down (or as the header says) is named.
fn of_vector(imported: &Imported, quantity: Quantity, seen: Axes) -> Finding {
    let proper = seen.matrix().transpose() * seen.matrix().determinant();
    let is_right = |matrix: &Matrix3<f64>| {
        let merged = imported.merged;
        let found = if quantity == Quantity::Accel {
            dip_deg(&turned(&merged.accel, matrix), &merged.mag)
        } else {
            dip_deg(&merged.accel, &turned(&merged.mag, matrix))
        };
        found.is_none_or(|found| (found > 0.0) == (expected_dip(imported).unwrap_or(1.0) > 0.0))
    };
    let fewer =
        if Axes::of(&proper).changed() <= Axes::of(&-proper).changed() { [proper, -proper] } else { [-proper, proper] };
    let matrix = fewer.iter().find(|matrix| is_right(matrix)).unwrap_or(&fewer[0]);
    let axes = Axes::of(matrix);
    let columns = columns(imported, quantity, axes);
    Finding::wrong(
        format!("axes of the {} are wrong: the gyro says {}", in_words(quantity), told(axes)),
        format!("columns = {columns} in [{}]", name(quantity)),
    )
}

/// An order of axes in words: only what is not as it was.
fn told(axes: Axes) -> String {
    let letter = ["x", "y", "z"];
    let changed = axes.0.iter().enumerate().filter(|(axis, of)| **of != (*axis, 1));
    let told = changed.map(|(axis, (from, sign))| {
        format!("{} is {}{}", letter[axis], if *sign < 0 { "-" } else { "" }, letter[*from])
    });
    told.collect::<Vec<_>>().join(", ")
}

/// The columns of a map with another order of axes.
fn columns(imported: &Imported, quantity: Quantity, axes: Axes) -> String {
    let now = imported.map.part(quantity).columns.as_deref().unwrap_or_default();
    let column = |(from, sign): (usize, i8)| {
        let name = now.get(from).map_or("", String::as_str);
        match (name.strip_prefix('-'), sign < 0) {
            (Some(plain), true) => plain.to_owned(),
            (None, true) => format!("-{name}"),
            (_, false) => name.to_owned(),
        }
    };
    format!("{:?}", axes.0.map(column))
}

/// Median angle of the field below the horizontal, degrees.
fn dip_deg(accel: &[[f64; 4]], mag: &[[f64; 4]]) -> Option<f64> {
    let mut sines = sines_of_dip(accel, mag);
    let middle = sines.len() / 2;
    (!sines.is_empty())
        .then(|| sines.select_nth_unstable_by(middle, f64::total_cmp).1.clamp(-1.0, 1.0).asin().to_degrees())
}

/// Sine of the field's angle below the horizontal in each row that has both vectors. The force counts as one g: by its
/// own length, which vibration makes longer, the field would seem flat.
fn sines_of_dip(accel: &[[f64; 4]], mag: &[[f64; 4]]) -> Vec<f64> {
    let sine = |(a, m): (&[f64; 4], &[f64; 4])| {
        let (a, m) = (Vector3::new(a[0], a[1], a[2]), Vector3::new(m[0], m[1], m[2]));
        -a.dot(&m) / (STANDARD_GRAVITY * m.norm())
    };
    accel.iter().zip(mag).map(sine).filter(|sine| sine.is_finite()).collect()
}

/// Dip that the header states or implies (a dipole's, from the latitude).
fn expected_dip(imported: &Imported) -> Option<f64> {
    let of_dipole = |latitude: f64| (2.0 * latitude.to_radians().tan()).atan().to_degrees();
    imported.keys.dip_deg.or_else(|| imported.keys.latitude_deg.map(of_dipole))
}

fn dip(imported: &Imported) -> Option<Finding> {
    let found = dip_deg(&imported.merged.accel, &imported.merged.mag)?;
    let told = format!("the field dips {found:.1} deg below the horizontal");
    let turned = "the sign of all axes of the accelerometer or of the magnetometer: an accelerometer at rest reads up";
    Some(match expected_dip(imported) {
        Some(expected) if (found + expected).abs() < DIP_DEG && expected.abs() > DIP_DEG => {
            Finding::wrong(format!("{told}, and the header says {expected:.1}"), turned.into())
        }
        Some(expected) if (found - expected).abs() > DIP_DEG && flipped_z_dips(imported, expected) => {
            let fix = "the sign of z of the accelerometer or of the magnetometer";
            Finding::wrong(format!("{told}, and the header says {expected:.1}"), fix.into())
        }
        Some(expected) if (found - expected).abs() > DIP_DEG && imported.keys.dip_deg.is_some() => {
            let fix = "axes of the accelerometer or of the magnetometer, or dip_deg in the header";
            Finding::wrong(format!("{told}, and the header says {expected:.1}"), fix.into())
        }
        None if found < -10.0 && points_up_the_hole(imported) => {
            let told = format!("{told}, and the tool's axis points up: inclination beyond {UP_THE_HOLE_DEG} deg");
            Finding::wrong(told, turned.into())
        }
        None if found < -10.0 => Finding {
            fix: Some("right in the southern hemisphere; else turn the sign of all axes of [accel] (at rest it reads up) or of [mag]".into()),
            ..Finding::note(told)
        },
        _ => Finding::fine(told),
    })
}

/// Returns true if the axis of a tool points up in most of the recording.
fn points_up_the_hole(imported: &Imported) -> bool {
    let along = |row: &[f64; 4]| -row[2] / Vector3::new(row[0], row[1], row[2]).norm();
    let mut cosines: Vec<f64> = imported.merged.accel.iter().map(along).filter(|cosine| cosine.is_finite()).collect();
    let middle = cosines.len() / 2;
    imported.keys.body_frame == BodyFrame::Tool
        && !cosines.is_empty()
        && *cosines.select_nth_unstable_by(middle, f64::total_cmp).1 < UP_THE_HOLE_DEG.to_radians().cos()
}

/// Returns true if with the sign of one sensor's z turned the field dips as the header says.
fn flipped_z_dips(imported: &Imported, expected: f64) -> bool {
    let flipped = turned(&imported.merged.accel, &Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)));
    let found = dip_deg(&flipped, &imported.merged.mag);
    imported.keys.dip_deg.is_some() && found.is_some_and(|found| (found - expected).abs() < AS_STATED_DEG)
}
