//! The line to a probe: a serial port, a socket, or a file captured from one.

use std::{
    fs::File,
    io::{self, ErrorKind, Read, Write},
    net::{TcpStream, ToSocketAddrs},
    path::{Path, PathBuf},
    time::Duration,
};

use clap::Args;

use testbed::failure::Failure;

/// Longest wait of a read.
const PATIENCE: Duration = Duration::from_millis(50);
/// Longest wait for a connection.
const CONNECT: Duration = Duration::from_secs(5);

/// Options of every command that talks to a probe.
#[derive(Debug, Clone, Args)]
pub struct LineArgs {
    /// A serial port, tcp:HOST:PORT, unix:PATH, or a file of captured bytes
    #[arg(value_name = "PORT|FILE")]
    pub place: String,
    /// Speed of a serial port
    #[arg(long, value_name = "BAUD", default_value_t = 115_200, value_parser = clap::value_parser!(u32).range(300..))]
    pub baud: u32,
}

/// Outcome of a read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// This many bytes came.
    Bytes(usize),
    /// Nothing came in time.
    Nothing,
    /// The line has ended.
    End,
}

/// An open line.
pub struct Line {
    device: Device,
    /// Name of the port, file or address, for errors.
    place: String,
    /// Bytes that were read and are to be read again.
    put_back: Vec<u8>,
}

enum Device {
    Serial(Box<dyn serialport::SerialPort>),
    Tcp(TcpStream),
    #[cfg(unix)]
    Unix(std::os::unix::net::UnixStream),
    Capture(File),
}

impl Line {
    /// Opens the line that `args` name.
    ///
    /// # Errors
    /// [`Failure::BadInput`] for a name that is no port, [`Failure::Missing`] if the port or socket cannot be
    /// opened.
    pub fn open(args: &LineArgs) -> Result<Self, Failure> {
        let place = args.place.as_str();
        let device = if let Some(address) = place.strip_prefix("tcp:") {
            Device::Tcp(tcp(place, address)?)
        } else if let Some(path) = place.strip_prefix("unix:") {
            unix(place, Path::new(path))?
        } else {
            let path = PathBuf::from(place);
            match std::fs::metadata(&path) {
                Ok(found) if found.is_dir() => return Err(Failure::BadInput(format!("{place}: a folder"))),
                Ok(found) if found.is_file() => Device::Capture(File::open(&path).map_err(|e| closed(place, &e))?),
                Err(error) if error.kind() == ErrorKind::NotFound && !is_port_name(place) => {
                    return Err(Failure::BadInput(format!("{place}: no such port or file")));
                }
                _ => Device::Serial(serial(place, args.baud)?),
            }
        };
        Ok(Self { device, place: place.to_owned(), put_back: Vec::new() })
    }

    /// Returns true if a probe is at the other end; a captured file is not live.
    #[must_use]
    pub const fn is_live(&self) -> bool {
        !matches!(self.device, Device::Capture(_))
    }

    /// Puts bytes back that were read beyond what was wanted; the next read gets them.
    pub fn put_back(&mut self, bytes: &[u8]) {
        self.put_back.splice(0..0, bytes.iter().copied());
    }

    /// Reads the bytes that are there, waiting for up to a twentieth of a second.
    ///
    /// # Errors
    /// [`Failure::Port`] if the line broke.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<Received, Failure> {
        if !self.put_back.is_empty() {
            let count = self.put_back.len().min(buffer.len());
            for (place, byte) in buffer.iter_mut().zip(self.put_back.drain(..count)) {
                *place = byte;
            }
            return Ok(Received::Bytes(count));
        }
        let (read, ends) = match &mut self.device {
            Device::Serial(port) => (port.read(buffer), false),
            Device::Tcp(stream) => (stream.read(buffer), true),
            #[cfg(unix)]
            Device::Unix(stream) => (stream.read(buffer), true),
            Device::Capture(file) => (file.read(buffer), true),
        };
        match read {
            Ok(0) if ends => Ok(Received::End),
            Ok(0) => Ok(Received::Nothing),
            Ok(count) => Ok(Received::Bytes(count)),
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => Ok(Received::Nothing),
                ErrorKind::ConnectionReset | ErrorKind::BrokenPipe => Ok(Received::End),
                _ => Err(failed(&self.place, "read", &error)),
            },
        }
    }

    /// Sends bytes to the probe.
    ///
    /// # Errors
    /// [`Failure::Port`] if the line broke, or is a captured file.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        let device: &mut dyn Write = match &mut self.device {
            Device::Serial(port) => port,
            Device::Tcp(stream) => stream,
            #[cfg(unix)]
            Device::Unix(stream) => stream,
            Device::Capture(_) => return Err(failed(&self.place, "written", &"it is a capture")),
        };
        device.write_all(bytes).and_then(|()| device.flush()).map_err(|error| failed(&self.place, "written", &error))
    }
}

fn is_port_name(place: &str) -> bool {
    place.starts_with("/dev/") || place.starts_with("COM")
}

fn closed(place: &str, error: &dyn std::fmt::Display) -> Failure {
    failed(place, "opened", error)
}

fn failed(place: &str, what: &'static str, error: &dyn std::fmt::Display) -> Failure {
    Failure::Port { place: place.to_owned(), what, why: error.to_string() }
}

fn tcp(place: &str, address: &str) -> Result<TcpStream, Failure> {
    let bad = |error: io::Error| Failure::BadInput(format!("{place}: not tcp:HOST:PORT: {error}"));
    let addresses = address.to_socket_addrs().map_err(bad)?;
    let mut refused = io::Error::from(ErrorKind::AddrNotAvailable);
    for address in addresses {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(stream) => {
                stream.set_read_timeout(Some(PATIENCE)).map_err(|e| closed(place, &e))?;
                return Ok(stream);
            }
            Err(error) => refused = error,
        }
    }
    Err(closed(place, &refused))
}

#[cfg(unix)]
fn unix(place: &str, path: &Path) -> Result<Device, Failure> {
    let stream = std::os::unix::net::UnixStream::connect(path).map_err(|e| closed(place, &e))?;
    stream.set_read_timeout(Some(PATIENCE)).map_err(|e| closed(place, &e))?;
    Ok(Device::Unix(stream))
}

#[cfg(not(unix))]
fn unix(place: &str, _: &Path) -> Result<Device, Failure> {
    Err(Failure::BadInput(format!("{place}: there are no such sockets on this system")))
}

fn serial(place: &str, baud: u32) -> Result<Box<dyn serialport::SerialPort>, Failure> {
    serialport::new(place, baud).timeout(PATIENCE).open().map_err(|e| closed(place, &e))
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A closed pipe is one of the line, not of the standard output, where it would be no error.
    #[test]
    fn a_line_that_is_closed_is_a_port_that_cannot_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("probe.sock");
        let listener = std::os::unix::net::UnixListener::bind(&path).unwrap();
        let place = format!("unix:{}", path.display());
        let mut line = Line::open(&LineArgs { place: place.clone(), baud: 115_200 }).unwrap();
        drop(listener.accept().unwrap());
        assert_eq!(line.read(&mut [0; 8]), Ok(Received::End));
        let failure = line.write(b"start").unwrap_err();
        assert!(
            matches!(&failure, Failure::Port { what: "written", place: named, .. } if *named == place),
            "{failure}"
        );
    }
}
