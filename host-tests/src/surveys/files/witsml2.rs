//! WITSML 2.0: a trajectory (Energistics, 2016).

use super::witsml::{Document, Version, ends, identifier, short, stations};
use crate::surveys::run::SurveyedRun;

/// The run as a `Trajectory` document.
#[must_use]
pub fn witsml(run: &SurveyedRun) -> String {
    let mut out = Document::new(Version::V2);
    let created = if run.provenance.date.is_empty() { "1970-01-01" } else { run.provenance.date.as_str() };
    let uuid = identifier("trajectory", &run.well);
    let attributes = [
        ("xmlns", "http://www.energistics.org/energyml/data/witsmlv2"),
        ("xmlns:eml", "http://www.energistics.org/energyml/data/commonv2"),
        ("schemaVersion", "2.0"),
        ("uuid", uuid.as_str()),
    ];
    out.within("Trajectory", &attributes, |out| {
        out.within("eml:Citation", &[], |out| {
            out.plain("eml:Title", &[], &format!("{} MWD surveys", short(&run.well)));
            out.plain("eml:Originator", &[], "meerkat-mwd");
            out.plain("eml:Creation", &[], &format!("{created}T00:00:00Z"));
            out.plain("eml:Format", &[], "meerkat-mwd");
        });
        out.word("growingStatus", "closed");
        ends(out, run);
        stations(out, run);
        out.within("Wellbore", &[], |out| {
            out.plain("eml:ContentType", &[], "application/x-witsml+xml;version=2.0;type=Wellbore");
            out.plain("eml:Title", &[], &short(&run.well));
            out.plain("eml:Uuid", &[], &identifier("wellbore", &run.well));
        });
    });
    out.text()
}
