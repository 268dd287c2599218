//! The live view as a page on loopback: a server of two answers, for browsers on this machine and for nobody else.

use std::{
    io::{self, BufRead, BufReader, Write},
    net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream},
    sync::{Arc, Mutex, PoisonError},
    thread,
    time::Duration,
};

use super::history::History;
use crate::report::html::live::{news, page};
use testbed::failure::Failure;

/// Time after which a browser that says nothing is let go.
const PATIENCE: Duration = Duration::from_secs(2);

/// Longest line of a request that is read, bytes.
const LONGEST_LINE: u64 = 8_192;

/// Most lines of a request that are read.
const MOST_LINES: usize = 100;

/// A page that shows what a probe reports, as long as it is kept.
pub struct LivePage {
    address: SocketAddr,
    said: Arc<Mutex<[String; 2]>>,
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
        let said = Arc::new(Mutex::new(said(&History::default(), &[])));
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

    /// Shows what was reported by now: over time, and the latest in lines.
    pub fn show(&self, history: &History, lines: &[String]) {
        *self.said.lock().unwrap_or_else(PoisonError::into_inner) = said(history, lines);
    }
}

/// The page, and what it asks for twice a second.
fn said(history: &History, lines: &[String]) -> [String; 2] {
    let heard = history.heard(lines);
    [page(&heard), news(&heard)]
}

/// Answers one request.
fn answer(stream: TcpStream, address: SocketAddr, said: &Mutex<[String; 2]>) -> io::Result<()> {
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
    let [whole, news] = said.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let (status, kind, body) = match asked.split(' ').take(2).collect::<Vec<_>>().as_slice() {
        _ if !is_own => ("403 Forbidden", "text/plain", "for this machine only\n".to_owned()),
        ["GET", "/"] => ("200 OK", "text/html; charset=utf-8", whole),
        ["GET", "/state"] => ("200 OK", "application/json", news),
        _ => ("404 Not Found", "text/plain", "there is / and /state\n".to_owned()),
    };
    let length = body.len();
    write!(
        &stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n{body}"
    )
}
