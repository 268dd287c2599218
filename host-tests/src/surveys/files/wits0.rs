//! WITS level 0: a record of text lines for each station, over TCP as rig systems read it. A line is record, item (two
//! digits each) and value; `&&` begins a record and `!!` ends it (Wellsite Information Transfer Specification, 1991,
//! record 7: survey and directional).

use std::{
    io::{BufWriter, Write},
    net::TcpStream,
    time::Duration,
};

use super::push;
use crate::surveys::{
    path::DOGLEG_LENGTH_M,
    run::{SurveyedRun, SurveyedStation},
};
use testbed::failure::Failure;

/// Time in which the receiver must take what is sent.
const PATIENCE: Duration = Duration::from_secs(10);

/// Items of record 7: number, value, decimals. Lengths in metres, angles in degrees, doglegs in the metric unit DGHM,
/// read as degrees in a hundred metres as its twin DGHF is in a hundred feet. Items and units are those of the
/// dictionary in <https://github.com/mwdstd/mwdstdwits>; the specification itself was not at hand.
fn items(s: &SurveyedStation) -> [(u8, Option<f64>, usize); 9] {
    let [north, east, tvd] = s.position_m;
    [
        // Survey depth, measured and vertical.
        (8, Some(s.md_m), 2),
        (9, Some(tvd), 2),
        // Inclination, azimuth uncorrected and corrected.
        (13, Some(s.inclination_deg), 3),
        (14, Some(s.measured_deg[1]), 3),
        (15, Some(s.azimuth_deg), 3),
        // Magnetic toolface is not given: a station has its gravity toolface.
        (17, s.gravity_toolface_deg, 1),
        (18, Some(north), 2),
        (19, Some(east), 2),
        (20, Some(s.dogleg_deg_30m * (100.0 / DOGLEG_LENGTH_M)), 3),
        // Item 11, the hole's depth while the survey was taken, is not known here.
    ]
}

/// The records of a run.
#[must_use]
pub fn records(run: &SurveyedRun) -> String {
    let mut text = String::new();
    let well: String = run.well.chars().take(16).map(|c| if c.is_ascii() { c } else { '?' }).collect();
    for (k, station) in run.stations.iter().enumerate() {
        push(&mut text, format_args!("&&\r\n0701{well}\r\n07037\r\n0704{}\r\n", k + 1));
        let mut items = items(station);
        items.sort_by_key(|item| item.0);
        for (item, value, decimals) in items {
            if let Some(value) = value {
                push(&mut text, format_args!("07{item:02}{value:.decimals$}\r\n"));
            }
        }
        text.push_str("!!\r\n");
    }
    text
}

/// Sends the records of a run to a receiver at `address`, HOST:PORT.
///
/// # Errors
/// Nobody listens there, or does not take the records within ten seconds.
pub fn send(run: &SurveyedRun, address: &str) -> Result<(), Failure> {
    let sent = || -> std::io::Result<()> {
        let stream = TcpStream::connect(address)?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let mut out = BufWriter::new(stream);
        out.write_all(records(run).as_bytes())?;
        out.flush()
    };
    sent().map_err(|error| Failure::Missing(format!("{address}: {error}")))
}
