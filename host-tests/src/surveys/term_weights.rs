//! Weights of the error model's terms: what one unit of an error adds to depth, inclination and azimuth of a station.
//!
//! Azimuth enters as sin(I) dA, which is finite at the vertical, so that no term is singular there. Formulas: ISCWSA
//! MWD error model, revision 5, in the forms that do not depend on the toolface.

use libm::{cos, sin, tan};

use super::path::Direction;

/// A station as the error model sees it. Stations at one depth count as one: each place comes once.
#[derive(Clone, Copy, Debug)]
pub struct ModelStation {
    /// Depth and direction, azimuth from the north that positions count from.
    pub direction: Direction,
    /// True vertical depth, metres.
    pub tvd_m: f64,
    /// Azimuth from magnetic north, radians.
    pub magnetic_azimuth_rad: f64,
    /// Azimuth from true north, radians.
    pub true_azimuth_rad: f64,
    /// Reference's total field, microtesla.
    pub field_ut: f64,
    /// Dip, radians.
    pub dip_rad: f64,
    /// Gravity, m/s^2.
    pub gravity_m_s2: f64,
    /// True where the azimuth has the short-collar correction.
    pub axial: bool,
}

/// Change of depth, inclination, and azimuth times sin(I).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weights {
    /// Along the hole.
    pub depth: f64,
    /// Upwards in the vertical plane.
    pub inclination: f64,
    /// Across it.
    pub across: f64,
    /// True for an error of the course from the station before to this one, which turns all of that leg and nothing of
    /// the next.
    pub own_leg: bool,
}

/// Weights at a station.
pub type Weigh = fn(&At) -> Weights;

/// Interval under which a misalignment that is drawn anew at each station grows as the root of its inverse, metres, and
/// the one under which stations are one place (error model's definition, revision 5.13, 5.1.2).
const SHORTEST_M: [f64; 2] = [10.0, 0.1];
/// Bend of the hole between stations that do not show it, rad/m: 1 deg over 100 ft.
const TORTUOSITY_RAD_M: f64 = 0.000_572_614_583_987_641;
/// Sine of the inclination below which a hole has no azimuth.
const VERTICAL: f64 = 1e-6;

/// Sines and cosines of one station: inclination i, magnetic azimuth m, true azimuth t; tangent of the dip, horizontal
/// and total field, gravity.
pub struct At {
    si: f64,
    ci: f64,
    sm: f64,
    cm: f64,
    st: f64,
    ct: f64,
    td: f64,
    bh: f64,
    b: f64,
    g: f64,
    md: f64,
    tvd: f64,
    axial: bool,
    /// Changes since the station before: depth, inclination, and the sine of that of the azimuth, which is 0 below a
    /// vertical hole.
    course_m: f64,
    bend: [f64; 2],
}

impl At {
    /// A station after the one before it.
    #[must_use]
    pub fn of(before: Option<&ModelStation>, station: &ModelStation) -> Self {
        let (si, ci) = libm::sincos(station.direction.inclination_rad);
        let (sm, cm) = libm::sincos(station.magnetic_azimuth_rad);
        let (st, ct) = libm::sincos(station.true_azimuth_rad);
        let before = before.unwrap_or(station);
        let turn = sin(station.true_azimuth_rad - before.true_azimuth_rad).abs();
        let turned = if sin(before.direction.inclination_rad) < VERTICAL { 0.0 } else { si * turn };
        Self {
            si,
            ci,
            sm,
            cm,
            st,
            ct,
            td: tan(station.dip_rad),
            bh: station.field_ut * cos(station.dip_rad),
            b: station.field_ut,
            g: station.gravity_m_s2,
            md: station.direction.md_m,
            tvd: station.tvd_m,
            axial: station.axial,
            course_m: station.direction.md_m - before.direction.md_m,
            bend: [(station.direction.inclination_rad - before.direction.inclination_rad).abs(), turned],
        }
    }

    /// Factor on a transverse error under the short-collar correction: 1 without it.
    fn freed(&self) -> f64 {
        if self.axial { 1.0 / (1.0 - (self.si * self.sm) * (self.si * self.sm)).max(VERTICAL) } else { 1.0 }
    }

    /// Tangent of the dip as it enters the axial field's part of the azimuth.
    fn along(&self) -> f64 {
        self.td * self.ci + self.si * self.cm
    }

    /// Azimuth times sin(I) for a unit that adds `up` to the inclination by turning gravity in the vertical plane.
    fn by_gravity(&self, up: f64) -> Weights {
        let across = if self.axial {
            -up * self.si * self.ci * self.sm * self.along() * self.freed()
        } else {
            -up * self.si * self.td * self.sm
        };
        Weights { inclination: up, across, ..Weights::default() }
    }

    fn damping(&self) -> f64 {
        let [shortest, place] = SHORTEST_M;
        if self.course_m > place && self.course_m < shortest { libm::sqrt(shortest / self.course_m) } else { 1.0 }
    }
}

fn across(across: f64) -> Weights {
    Weights { across, ..Weights::default() }
}

fn along_hole(depth: f64) -> Weights {
    Weights { depth, ..Weights::default() }
}

pub(super) fn depth(_: &At) -> Weights {
    along_hole(1.0)
}

pub(super) fn depth_scale(a: &At) -> Weights {
    along_hole(a.md)
}

pub(super) fn depth_stretch(a: &At) -> Weights {
    along_hole(a.md * a.tvd)
}

pub(super) fn accel_bias_xy_1(a: &At) -> Weights {
    a.by_gravity(-a.ci / a.g)
}

pub(super) fn accel_bias_xy_2(a: &At) -> Weights {
    across((a.ci - a.td * a.si * a.cm) / a.g * a.freed())
}

pub(super) fn accel_bias_z(a: &At) -> Weights {
    a.by_gravity(-a.si / a.g)
}

pub(super) fn accel_scale_xy_1(a: &At) -> Weights {
    a.by_gravity(a.si * a.ci * std::f64::consts::FRAC_1_SQRT_2)
}

pub(super) fn accel_scale_xy_2(a: &At) -> Weights {
    a.by_gravity(a.si * a.ci * 0.5)
}

pub(super) fn accel_scale_xy_3(a: &At) -> Weights {
    across(0.5 * a.si * (a.td * a.si * a.cm - a.ci) * a.freed())
}

pub(super) fn accel_scale_z(a: &At) -> Weights {
    a.by_gravity(-a.si * a.ci)
}

pub(super) fn mag_bias_xy_1(a: &At) -> Weights {
    across(-a.si * a.ci * a.sm / a.bh * a.freed())
}

pub(super) fn mag_bias_xy_2(a: &At) -> Weights {
    across(a.si * a.cm / a.bh * a.freed())
}

/// A field along the tool, which the short-collar correction replaces.
pub(super) fn axial_field(a: &At) -> Weights {
    across(if a.axial { 0.0 } else { -a.si * a.si * a.sm / a.bh })
}

pub(super) fn mag_scale_xy_1(a: &At) -> Weights {
    across(a.si * a.si * a.sm * a.along() * std::f64::consts::FRAC_1_SQRT_2 * a.freed())
}

pub(super) fn mag_scale_xy_2(a: &At) -> Weights {
    across(0.5 * a.si * a.sm * (a.td * a.si * a.ci - a.ci * a.ci * a.cm - a.cm) * a.freed())
}

pub(super) fn mag_scale_xy_3(a: &At) -> Weights {
    across(0.5 * a.si * (a.ci * (a.cm * a.cm - a.sm * a.sm) - a.td * a.si * a.cm) * a.freed())
}

pub(super) fn mag_scale_z(a: &At) -> Weights {
    across(if a.axial { 0.0 } else { -a.si * a.along() * a.si * a.sm })
}

pub(super) fn declination(a: &At) -> Weights {
    across(a.si)
}

pub(super) fn declination_by_field(a: &At) -> Weights {
    across(a.si / a.bh)
}

/// Dip of the reference, which enters through the short-collar correction only.
pub(super) fn reference_dip(a: &At) -> Weights {
    across(if a.axial { -a.si * a.si * a.sm * (a.ci - a.td * a.si * a.cm) * a.freed() } else { 0.0 })
}

pub(super) fn reference_field(a: &At) -> Weights {
    across(if a.axial { -a.si * a.si * a.sm * a.along() / a.b * a.freed() } else { 0.0 })
}

pub(super) fn sag(a: &At) -> Weights {
    Weights { inclination: libm::pow(a.si.max(0.0), 0.25), ..Weights::default() }
}

pub(super) fn misaligned_up(a: &At) -> Weights {
    Weights { inclination: a.si.abs(), ..Weights::default() }
}

pub(super) fn misaligned_across(a: &At) -> Weights {
    across(-a.si)
}

pub(super) fn misaligned_north(a: &At) -> Weights {
    let size = a.ci.abs() * a.damping();
    Weights { inclination: size * a.ct, across: -size * a.st, ..Weights::default() }
}

pub(super) fn misaligned_east(a: &At) -> Weights {
    let size = a.ci.abs() * a.damping();
    Weights { inclination: size * a.st, across: size * a.ct, ..Weights::default() }
}

pub(super) fn course_across(a: &At) -> Weights {
    let [_, turned] = a.bend;
    Weights { across: turned.max(TORTUOSITY_RAD_M * a.course_m), own_leg: true, ..Weights::default() }
}

pub(super) fn course_up(a: &At) -> Weights {
    let [built, _] = a.bend;
    Weights { inclination: built.max(TORTUOSITY_RAD_M * a.course_m), own_leg: true, ..Weights::default() }
}
