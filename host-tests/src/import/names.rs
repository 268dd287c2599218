//! Names of columns: which sensor and which axis a column is, by the words in its name and in its table's.

use super::units::Quantity;

/// Words of a name, in lower case: parted at every sign, at a change of case and before an index.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for letter in name.chars() {
        let parts = !letter.is_alphanumeric() || (was_lower && letter.is_uppercase());
        if parts {
            words.push(String::new());
        }
        if letter.is_alphanumeric() {
            words.last_mut().into_iter().for_each(|word| word.extend(letter.to_lowercase()));
        }
        was_lower = letter.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The sensor that a word names.
fn sensor(word: &str) -> Option<Quantity> {
    let starts = |stems: &[&str]| stems.iter().any(|stem| word.starts_with(stem));
    if starts(&["gyr", "angular", "omega", "rotationrate", "angvel"]) {
        Some(Quantity::Gyro)
    } else if starts(&["acc", "specificforce"]) {
        Some(Quantity::Accel)
    } else if starts(&["mag", "compass"]) {
        Some(Quantity::Mag)
    } else if starts(&["temp"]) {
        Some(Quantity::Temperature)
    } else {
        None
    }
}

/// The sensor that a column's name holds a word of.
#[must_use]
pub fn sensor_of(column: &str) -> Option<Quantity> {
    words(column).iter().find_map(|word| sensor(word))
}

/// Whole names in use for one axis of one sensor.
fn short(word: &str) -> Option<(Quantity, usize)> {
    let mut letters = word.chars();
    let (stem, axis, None) = (letters.next()?, letters.next()?, letters.next()) else { return None };
    let quantity = match stem {
        'g' | 'w' => Quantity::Gyro,
        'a' | 'f' => Quantity::Accel,
        'm' | 'b' | 'h' => Quantity::Mag,
        'q' => return Some((Quantity::Reference, "wxyz".find(axis)?)),
        _ => return None,
    };
    Some((quantity, "xyz".find(axis)?))
}

/// Meaning of a column by its name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Meaning {
    /// Quantity that it measures.
    pub quantity: Quantity,
    /// Axis, or component of the quaternion; 0 for a scalar.
    pub axis: usize,
    /// The rest of the name, which the axes of one sensor share.
    pub group: String,
    /// Rank by how well the words fit: what a logger has worked on already comes after the raw reading.
    pub rank: u8,
}

/// Meaning of a table's column; `None` if it is no reading of a sensor.
#[must_use]
pub fn meaning(table: &str, column: &str) -> Option<Meaning> {
    let own = words(column);
    let all: Vec<&str> = words_of_both(table, &own);
    if all.iter().any(|word| {
        ["covariance", "bias", "offset", "variance", "std", "sigma", "true", "norm", "filtered"].contains(word)
    }) {
        return None;
    }
    let rank = rank(&all);
    // A thermometer of another part is not the gyro's.
    let is_elsewhere = |word: &str| {
        let starts = ["baro", "batt", "press", "airspeed", "ambient"].iter().any(|stem| word.starts_with(stem));
        starts || matches!(word, "air" | "cpu" | "gps" | "esc" | "motor" | "power")
    };
    if let Some((quantity, axis)) = own.first().and_then(|word| short(word)) {
        return Some(Meaning { quantity, axis, group: own[1..].concat(), rank });
    }
    if own.iter().any(|word| word.starts_with("temp")) && !own.iter().any(|word| word == "template") {
        if words(table).iter().chain(&own).any(|word| is_elsewhere(word)) {
            return None;
        }
        return Some(Meaning { quantity: Quantity::Temperature, axis: 0, group: own.concat(), rank });
    }
    let index = |word: &str| match word {
        "x" | "0" => Some(0),
        "y" | "1" => Some(1),
        "z" | "2" => Some(2),
        _ => None,
    };
    // The axis is a word of its own, or the last letter of the sensor's.
    let place = own.iter().rposition(|word| index(word).is_some());
    let (axis, rest): (usize, Vec<String>) = match place {
        Some(place) => {
            let rest = own.iter().enumerate().filter(|(at, _)| *at != place).map(|(_, word)| word.clone());
            (index(&own[place])?, rest.collect())
        }
        None => own.iter().enumerate().find_map(|(at, word)| {
            let (stem, last) = word.split_at(word.char_indices().last()?.0);
            let axis = index(last)?;
            sensor(stem)?;
            let rest =
                own.iter().enumerate().map(|(other, word)| if other == at { stem.to_owned() } else { word.clone() });
            Some((axis, rest.collect()))
        })?,
    };
    // "Magnetic field", but "magnitude" is none of three axes; "angular velocity", but "linear velocity" is none.
    let of = |words: &[&str]| {
        let joined = words.concat();
        let known = words.iter().find_map(|word| sensor(word)).or_else(|| sensor(&joined));
        known.or_else(|| joined.contains("rotationrate").then_some(Quantity::Gyro))
    };
    let own_words: Vec<&str> = rest.iter().map(String::as_str).collect();
    let quantity = of(&own_words).or_else(|| of(&all))?;
    (quantity != Quantity::Temperature).then(|| Meaning { quantity, axis, group: rest.concat(), rank })
}

fn words_of_both<'a>(table: &str, own: &'a [String]) -> Vec<&'a str> {
    // A table's words are few and known, so that they need no place to live.
    const KNOWN: [&str; 26] = [
        "gyroscope",
        "gyro",
        "gyr",
        "angular",
        "velocity",
        "rotation",
        "rate",
        "accelerometer",
        "acceleration",
        "accel",
        "acc",
        "total",
        "linear",
        "gravity",
        "user",
        "uncalibrated",
        "magnetometer",
        "magnetic",
        "field",
        "mag",
        "compass",
        "covariance",
        "bias",
        "filtered",
        "vehicle",
        "combined",
    ];
    let of_table = words(table);
    let known = KNOWN.into_iter().filter(|known| of_table.iter().any(|word| word == known));
    known.chain(own.iter().map(String::as_str)).collect()
}

/// 0 for the whole reading, more for what something was taken from.
fn rank(words: &[&str]) -> u8 {
    let has = |word: &str| words.contains(&word);
    if has("total") || has("combined") {
        0
    } else if has("gravity") || has("user") || has("linear") && !words.iter().any(|word| word.starts_with("angular")) {
        3
    } else {
        1 + u8::from(has("uncalibrated"))
    }
}

/// Returns true if a column holds time, by its name.
#[must_use]
pub fn is_time(column: &str) -> bool {
    let words = words(column);
    let known = [
        "t",
        "ts",
        "time",
        "timestamp",
        "clock",
        "epoch",
        "stamp",
        "utc",
        "elapsed",
        "datetime",
        "seconds",
        "millis",
        "micros",
        "timestamps",
    ];
    words.iter().any(|word| known.contains(&word.as_str())) && !words.iter().any(|word| word == "relative")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(table: &str, column: &str) -> Option<(Quantity, usize)> {
        meaning(table, column).map(|meaning| (meaning.quantity, meaning.axis))
    }

    #[test]
    fn loggers_names_are_understood() {
        use Quantity::{Accel, Gyro, Mag, Reference, Temperature};
        for (table, column, quantity, axis) in [
            ("log", "gx", Gyro, 0),
            ("log", "wz_dps", Gyro, 2),
            ("log", "qw", Reference, 0),
            ("log", "GyrX", Gyro, 0),
            ("log", "gyroz", Gyro, 2),
            ("log", "Gyroscope y (rad/s)", Gyro, 1),
            ("log", "angular_velocity.z", Gyro, 2),
            ("log", "rotationRateX", Gyro, 0),
            ("Gyroscope", "y", Gyro, 1),
            ("Magnetometer", "Z", Mag, 2),
            ("log", "Magnetic field x (\u{3bc}T)", Mag, 0),
            ("log", "linear_acceleration.x", Accel, 0),
            ("sensor_combined", "gyro_rad[0]", Gyro, 0),
            ("sensor_combined", "accelerometer_m_s2[2]", Accel, 2),
            ("log", "temp_c", Temperature, 0),
            ("log", "acc_x", Accel, 0),
        ] {
            assert_eq!(told(table, column), Some((quantity, axis)), "{table} {column}");
        }
        for column in ["x", "pressure", "latitude", "angular_velocity_covariance[0]", "wx_true", "roll", "gyro_norm"] {
            assert_eq!(told("log", column), None, "{column}");
        }
    }

    #[test]
    fn a_whole_reading_comes_before_one_without_gravity() {
        let rank = |table| meaning(table, "x").map(|meaning| meaning.rank);
        assert!(rank("TotalAcceleration") < rank("Accelerometer"));
        assert!(rank("Accelerometer") < rank("LinearAcceleration"));
        assert!(rank("Accelerometer") < rank("AccelerometerUncalibrated"));
    }

    #[test]
    fn time_is_told_from_what_only_sounds_like_it() {
        assert!(["t_s", "Time (ms)", "timestamp", "seconds_elapsed", "time"].iter().all(|name| is_time(name)));
        assert!(!["temp", "runtime", "accelerometer_timestamp_relative"].iter().any(|name| is_time(name)));
        let of = ["time_gyr", "acc timestamp", "MagTime", "timestamp"].map(sensor_of);
        assert_eq!(of, [Some(Quantity::Gyro), Some(Quantity::Accel), Some(Quantity::Mag), None]);
    }
}
