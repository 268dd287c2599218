//! The live view as a page on loopback: a server of two answers, for browsers on this machine and for nobody else.

use std::{
    io::{self, BufRead, BufReader, Write},
    net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream},
    sync::{Arc, Mutex, PoisonError},
    thread,
    time::Duration,
};

use serde_json::json;

use super::{
    state::{State, flags_text},
    summary::{summary_lines, toolface},
};
use crate::failure::Failure;

/// Time after which a browser that says nothing is let go.
const PATIENCE: Duration = Duration::from_secs(2);

/// Longest line of a request that is read, bytes.
const LONGEST_LINE: u64 = 8_192;

/// Most lines of a request that are read.
const MOST_LINES: usize = 100;

/// A page that shows what a probe reports, as long as it is kept.
pub struct LivePage {
    address: SocketAddr,
    said: Arc<Mutex<String>>,
}

impl LivePage {
    /// Serves the page on loopback; port 0 takes any that is free.
    ///
    /// # Errors
    /// When the port cannot be had.
    pub fn open(port: u16) -> Result<Self, Failure> {
        let taken =
            |error: io::Error| Failure::BadInput(format!("127.0.0.1:{port}: {error}; choose another with --web=N"));
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(taken)?;
        let address = listener.local_addr().map_err(taken)?;
        let said = Arc::new(Mutex::new(said(&State::default())));
        let to_tell = Arc::clone(&said);
        thread::spawn(move || {
            // A browser that goes away has what it wanted.
            for stream in listener.incoming().flatten() {
                let _ = answer(stream, address, &to_tell);
            }
        });
        Ok(Self { address, said })
    }

    /// Address of the page.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Shows what was reported by now.
    pub fn show(&self, state: &State) {
        *self.said.lock().unwrap_or_else(PoisonError::into_inner) = said(state);
    }
}

/// What the page asks for, twice a second.
fn said(state: &State) -> String {
    let angles = state.attitude.as_ref().and_then(|attitude| attitude.angles.as_ref());
    let angles = angles.map(|angles| {
        let (kind, toolface_rad) = toolface(angles);
        let degrees = |x: [f32; 3]| x.map(f32::to_degrees);
        json!({
            "deg": degrees([angles.inclination_rad(), angles.azimuth_rad(), toolface_rad]),
            "sigma_deg": degrees(angles.sigmas_rad()),
            "toolface": kind,
            "flags": flags_text(angles.flags()),
        })
    });
    json!({ "t_s": state.t_us as f64 * 1e-6, "angles": angles, "lines": summary_lines(state) }).to_string()
}

/// Answers one request.
fn answer(stream: TcpStream, address: SocketAddr, said: &Mutex<String>) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut reader = BufReader::new(&stream);
    let (mut asked, mut host) = (String::new(), String::new());
    for number in 0..MOST_LINES {
        let mut line = String::new();
        io::Read::take(&mut reader, LONGEST_LINE).read_line(&mut line)?;
        let line = line.trim_end();
        if number == 0 {
            asked = line.to_owned();
        } else if line.is_empty() {
            break;
        } else if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("host")
        {
            host = value.trim().to_owned();
        }
    }
    // A page from elsewhere that has itself resolved to this machine names another host.
    let port = address.port();
    let is_own = [format!("127.0.0.1:{port}"), format!("localhost:{port}")].contains(&host);
    let (status, kind, body) = match asked.split(' ').take(2).collect::<Vec<_>>().as_slice() {
        _ if !is_own => ("403 Forbidden", "text/plain", "for this machine only\n".to_owned()),
        ["GET", "/"] => ("200 OK", "text/html; charset=utf-8", page()),
        ["GET", "/state"] => {
            ("200 OK", "application/json", said.lock().unwrap_or_else(PoisonError::into_inner).clone())
        }
        _ => ("404 Not Found", "text/plain", "there is / and /state\n".to_owned()),
    };
    let length = body.len();
    write!(
        &stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n{body}"
    )
}

fn page() -> String {
    format!(
        include_str!("live_page.html"),
        plots_style = include_str!("../../report/html/vendor/uplot/uPlot.min.css"),
        style = include_str!("../../report/html/style.css"),
        licence = include_str!("../../report/html/vendor/uplot/LICENSE"),
        plots = include_str!("../../report/html/vendor/uplot/uPlot.iife.min.js"),
        script = include_str!("live_page.js"),
    )
}
