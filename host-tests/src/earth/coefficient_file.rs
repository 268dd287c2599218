//! A field model from a file of spherical harmonic coefficients, of any degree: the World Magnetic Model (12), its high
//! resolution version WMMHR (133), and what else is written in that form.
//!
//! The file's first line holds epoch, name and day of release, each other one degree, order, g and h in nT, and their
//! change in nT a year, up to a line of nines. Formulas: The US/UK World Magnetic Model for 2020-2025, technical
//! report, section 1.2 (doi 10.25923/ytk1-yx35).

use std::{fs, path::Path};

use world_magnetic_model::time::{Date, util::days_in_year};

use super::field_at_depth::DEEPEST_M;
use testbed::failure::Failure;

/// Radius of the model's sphere, metres.
const SPHERE_M: f64 = 6_371_200.0;
/// Semi-major axis and square of the eccentricity of WGS 84.
const WGS84: (f64, f64) = (6_378_137.0, 6.694_379_990_141_32e-3);
/// Highest degree that is read; its functions stay within a double's range from 0.4 deg off the poles on, and underflow
/// to zero nearer to them.
const HIGHEST_DEGREE: usize = 200;
/// Years for which a model of this form is made.
const YEARS: f64 = 5.0;
/// Highest place, metres above the ellipsoid.
const HIGHEST_M: f64 = 850_000.0;
/// Least sine of the colatitude: a ten-thousandth of a metre from a pole's axis per degree of the sphere.
const LEAST_SINE: f64 = 1e-9;

/// Field north, east and down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldComponents {
    /// North, nT.
    pub north_nt: f64,
    /// East, nT.
    pub east_nt: f64,
    /// Down, nT.
    pub down_nt: f64,
}

impl FieldComponents {
    /// Total field, nT.
    #[must_use]
    pub fn total_nt(&self) -> f64 {
        libm::hypot(libm::hypot(self.north_nt, self.east_nt), self.down_nt)
    }

    /// Dip below the horizon, degrees.
    #[must_use]
    pub fn dip_deg(&self) -> f64 {
        libm::atan2(self.down_nt, libm::hypot(self.north_nt, self.east_nt)).to_degrees()
    }

    /// Declination east of true north, degrees.
    #[must_use]
    pub fn declination_deg(&self) -> f64 {
        libm::atan2(self.east_nt, self.north_nt).to_degrees()
    }
}

/// Coefficients of a degree and order: g, h and their change a year.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Coefficients {
    g: f64,
    h: f64,
    g_a_year: f64,
    h_a_year: f64,
}

/// A model as a file of coefficients holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct CoefficientFile {
    /// Name of the model, for instance `WMMHR-2025`.
    pub name: String,
    /// Year for which the coefficients hold.
    pub epoch: f64,
    degree: usize,
    /// By degree, then order.
    coefficients: Vec<Coefficients>,
}

impl CoefficientFile {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or is no file of coefficients: the line is named.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let bad = |why: String| Failure::BadInput(format!("{}: {why}", path.display()));
        let text = fs::read_to_string(path).map_err(|error| Failure::unread(path, &error))?;
        Self::parse(&text).map_err(bad)
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// Description of what is wrong, and in which line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
        let (_, header) = lines.next().ok_or("is empty")?;
        let mut words = header.split_whitespace();
        let epoch = words.next().and_then(|word| word.parse().ok()).filter(|year| (1900.0..2200.0).contains(year));
        let (Some(epoch), Some(name)) = (epoch, words.next()) else {
            return Err("line 1: must begin with epoch and name, as 2025.0 WMMHR-2025".to_owned());
        };
        let (mut coefficients, mut degree) = (Vec::new(), 0);
        for (number, line) in lines {
            if line.trim().starts_with("9999") {
                break;
            }
            let bad = |why: &str| format!("line {number}: {why}");
            let words: Vec<&str> = line.split_whitespace().collect();
            let &[n, m, g, h, g_a_year, h_a_year] = words.as_slice() else {
                return Err(bad("must hold degree, order, g, h and their change a year"));
            };
            let whole = |word: &str| word.parse::<usize>().map_err(|_| bad(&format!("{word:?} is no degree or order")));
            let (n, m) = (whole(n)?, whole(m)?);
            if n == 0 || n > HIGHEST_DEGREE || m > n {
                return Err(bad(&format!(
                    "degree {n}, order {m}: degrees go to {HIGHEST_DEGREE}, orders to the degree"
                )));
            }
            let number = |word: &str| {
                let value: Option<f64> = word.parse().ok().filter(|x: &f64| x.is_finite());
                value.ok_or_else(|| bad(&format!("{word:?} is no number")))
            };
            let read =
                Coefficients { g: number(g)?, h: number(h)?, g_a_year: number(g_a_year)?, h_a_year: number(h_a_year)? };
            degree = degree.max(n);
            coefficients.resize((degree + 1) * (degree + 2) / 2, None);
            if coefficients[place(n, m)].replace(read).is_some() {
                return Err(bad(&format!("degree {n}, order {m} stands there twice")));
            }
        }
        if degree == 0 {
            return Err("holds no coefficients".to_owned());
        }
        // Nothing of degree 0: a monopole.
        coefficients[0] = Some(Coefficients::default());
        if let Some(lacking) = coefficients.iter().position(Option::is_none) {
            let n = (0..=degree).rfind(|&n| place(n, 0) <= lacking).unwrap_or(0);
            return Err(format!("lacks degree {n}, order {}", lacking - place(n, 0)));
        }
        Ok(Self { name: name.to_owned(), epoch, degree, coefficients: coefficients.into_iter().flatten().collect() })
    }

    /// The field at a geodetic latitude (degrees north), a longitude (degrees east, any turn), a height above the
    /// ellipsoid (metres) and a day.
    ///
    /// Below the ground this continues the field downwards as if no rock above the place were magnetised.
    ///
    /// # Errors
    /// A place below 12 km under the ellipsoid or above 850 km, or a day outside the five years from the epoch.
    pub fn field_at(
        &self,
        latitude_deg: f64,
        longitude_deg: f64,
        height_m: f64,
        date: Date,
    ) -> Result<FieldComponents, Failure> {
        let Self { name, epoch, .. } = self;
        let refused = |why: String| Err(Failure::BadInput(format!("{name}: {why}")));
        let year = decimal_year(date);
        if !(*epoch..=epoch + YEARS).contains(&year) {
            return refused(format!("{date} is not within five years from {epoch:.1} on"));
        }
        if !(-90.0..=90.0).contains(&latitude_deg) || !longitude_deg.is_finite() {
            return refused(format!("latitude {latitude_deg}, longitude {longitude_deg}: no such place"));
        }
        if !(DEEPEST_M..=HIGHEST_M).contains(&height_m) {
            return refused(format!("{height_m} m: heights go from {DEEPEST_M} to {HIGHEST_M} m"));
        }
        Ok(self.components(latitude_deg.to_radians(), longitude_deg.to_radians(), height_m, year - epoch))
    }

    fn components(&self, latitude: f64, longitude: f64, height_m: f64, years: f64) -> FieldComponents {
        let (axis, eccentricity_2) = WGS84;
        let (sine, cosine) = (libm::sin(latitude), libm::cos(latitude));
        let curvature = axis / libm::sqrt(1.0 - eccentricity_2 * sine * sine);
        let from_axis = (curvature + height_m) * cosine;
        let north = (curvature * (1.0 - eccentricity_2) + height_m) * sine;
        let radius = libm::hypot(from_axis, north);
        // Colatitude on the sphere.
        let (sin_theta, cos_theta) = ((from_axis / radius).max(LEAST_SINE), north / radius);
        let (p, slope) = legendre(self.degree, sin_theta, cos_theta);
        let by_order: Vec<(f64, f64)> =
            (0..=self.degree).map(|m| libm::sincos(m as f64 * longitude)).map(|(s, c)| (c, s)).collect();
        let ratio = SPHERE_M / radius;
        let mut power = ratio * ratio;
        let (mut x, mut y, mut z) = (0.0, 0.0, 0.0);
        for n in 1..=self.degree {
            power *= ratio;
            for (m, &(cos_m, sin_m)) in by_order.iter().enumerate().take(n + 1) {
                let k = place(n, m);
                let c = self.coefficients[k];
                let (g, h) = (c.g + years * c.g_a_year, c.h + years * c.h_a_year);
                let along = g * cos_m + h * sin_m;
                x += power * along * slope[k];
                y += power * m as f64 * (g * sin_m - h * cos_m) * p[k] / sin_theta;
                z -= power * (n + 1) as f64 * along * p[k];
            }
        }
        // From the sphere's vertical to the ellipsoid's: WMM report, equation 17.
        let (sin_psi, cos_psi) = (cos_theta * cosine - sin_theta * sine, sin_theta * cosine + cos_theta * sine);
        FieldComponents { north_nt: x * cos_psi - z * sin_psi, east_nt: y, down_nt: x * sin_psi + z * cos_psi }
    }
}

/// Place of a degree and order in a list.
const fn place(n: usize, m: usize) -> usize {
    n * (n + 1) / 2 + m
}

/// Schmidt semi-normalised associated Legendre functions of the cosine of the colatitude, and their slopes with the
/// colatitude, by degree, then order.
fn legendre(degree: usize, sine: f64, cosine: f64) -> (Vec<f64>, Vec<f64>) {
    let mut p = vec![0.0; place(degree, degree) + 1];
    let mut slope = p.clone();
    p[0] = 1.0;
    for n in 1..=degree {
        for m in 0..n {
            let (one, two) = (place(n - 1, m), (n >= m + 2).then(|| place(n - 2, m)));
            let root = libm::sqrt((n * n - m * m) as f64);
            let back = libm::sqrt(((n - 1) * (n - 1) - m * m) as f64);
            let double = (2 * n - 1) as f64;
            let (p_two, slope_two) = two.map_or((0.0, 0.0), |k| (p[k], slope[k]));
            p[place(n, m)] = (double * cosine * p[one] - back * p_two) / root;
            slope[place(n, m)] = (double * (cosine * slope[one] - sine * p[one]) - back * slope_two) / root;
        }
        let factor = if n == 1 { 1.0 } else { libm::sqrt((2 * n - 1) as f64 / (2 * n) as f64) };
        let before = place(n - 1, n - 1);
        p[place(n, n)] = factor * sine * p[before];
        slope[place(n, n)] = factor * (cosine * p[before] + sine * slope[before]);
    }
    (p, slope)
}

/// Year with its fraction.
fn decimal_year(date: Date) -> f64 {
    f64::from(date.year()) + f64::from(date.ordinal() - 1) / f64::from(days_in_year(date.year()))
}

#[cfg(test)]
mod tests;
