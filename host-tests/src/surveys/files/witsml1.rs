//! WITSML 1.4.1.1: a trajectory (Energistics, 2011).

use super::witsml::{Document, Version, ends, identifier, short, stations};
use crate::surveys::run::SurveyedRun;

/// The run as a `trajectorys` document.
#[must_use]
pub fn witsml(run: &SurveyedRun) -> String {
    let mut out = Document::new(Version::V1);
    let [well, wellbore, uid] = ["well", "wellbore", "trajectory"].map(|kind| identifier(kind, &run.well));
    let schema = [("xmlns", "http://www.witsml.org/schemas/1series"), ("version", "1.4.1.1")];
    out.within("trajectorys", &schema, |out| {
        out.within("trajectory", &[("uidWell", &well), ("uidWellbore", &wellbore), ("uid", &uid)], |out| {
            out.word("nameWell", &short(&run.well));
            out.word("nameWellbore", &short(&run.well));
            out.word("name", "MWD surveys");
            ends(out, run);
            stations(out, run);
        });
    });
    out.text()
}
