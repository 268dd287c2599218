//! A flight as a page: what flew and why, attitude, and everything it rests on.

use super::{Page, Told, attitude, dynamics, effects, first_screen, provenance, readings, residual, surveys, windows};

/// The whole page.
#[must_use]
pub fn page(told: &Told) -> String {
    let mut page = Page::new(&format!("Flight of {}", told.file_name()), told.span_s());
    page.head(&first_screen::of_a_flight(told));
    page.section("Attitude");
    attitude::add(&mut page, told);
    page.section("Surveys");
    surveys::add(&mut page, told);
    page.section("Rotation, vibration, shocks");
    dynamics::add(&mut page, told);
    page.section("Against the reference");
    residual::add_rotation(&mut page, told);
    page.section("What was identified");
    windows::add(&mut page, told);
    if told.config.effects {
        page.section("Effects that were found");
        effects::add(&mut page, told);
        page.section("Residuals");
        residual::add(&mut page, told);
    }
    page.section("Readings");
    readings::add(&mut page, told);
    page.section("Where this comes from");
    page.add(&provenance::of_a_flight(told));
    page.finish()
}
