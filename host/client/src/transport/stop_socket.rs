//! Emergency stop of a link that another process has: a local socket of its owner.
//!
//! A serial port, a board's USB pipes and a pseudo-terminal have one owner, so `armbridge stop`
//! in a second terminal cannot open them. The owner listens on a Unix domain socket, whose name
//! is the link's, in a folder that only its user may enter. A connection is the request; the
//! answer is one line, when the board has reported the stop, or after a second.
//!
//! A socket that its owner has left behind refuses connections, and the next owner replaces
//! it. A board behind a socket of the network needs none: its server passes stops on.

use std::fs::{DirBuilder, Permissions};
use std::io::{self, Read, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use armbridge_shared::link::frame::Decoder;
use armbridge_shared::link::message::{Fault, Mode, ToHost};

use super::{LinkUri, usb, usb_discovery};
use crate::enum_names;

/// Longest wait for the board's report.
const TIMEOUT: Duration = Duration::from_secs(1);
/// Longest wait for the owner's answer.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(3);
/// Interval at which a stop is repeated until it is reported.
const INTERVAL: Duration = Duration::from_millis(20);
/// Requests that wait for the board's report.
const WAITING_MAX: usize = 8;
/// Longest answer.
const ANSWER_MAX: u64 = 256;

/// Answer of a link's owner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StopAnswer {
    /// The board reports this fault, by its name.
    Stopped(String),
    /// The stop is not known to have reached the board, for this reason.
    Failed(String),
}

/// Asks the owner of a link for an emergency stop; `None` if no process of this user owns it.
pub fn ask(link: &LinkUri) -> Option<StopAnswer> {
    let name = name(link)?;
    let mut stream = folders()
        .filter(|folder| is_private(folder))
        .find_map(|folder| UnixStream::connect(folder.join(&name)).ok())?;
    let mut answer = String::new();
    let read = stream
        .set_read_timeout(Some(ANSWER_TIMEOUT))
        .and_then(|()| (&mut stream).take(ANSWER_MAX).read_to_string(&mut answer));
    Some(match (read, answer.trim().split_once(' ')) {
        (Ok(_), Some(("stopped", fault))) => StopAnswer::Stopped(fault.to_owned()),
        (Ok(_), Some(("failed", reason))) => StopAnswer::Failed(reason.to_owned()),
        (Ok(_) | Err(_), _) => StopAnswer::Failed("the program that has it does not answer".into()),
    })
}

/// Name of a link's socket, the same for all of the link's URIs; `None` for a link that
/// needs none.
fn name(link: &LinkUri) -> Option<String> {
    let of_path = |path: &Path| {
        let path = path.canonicalize().unwrap_or_else(|_| path.into());
        let plain = path.to_string_lossy().replace('%', "%25");
        Some(format!("{}.stop", plain.replace('/', "%2F")))
    };
    let of_usb = |serial: Option<String>| {
        let serial = serial.unwrap_or_default().replace('%', "%25");
        Some(format!("usb:{}.stop", serial.replace('/', "%2F")))
    };
    match link {
        LinkUri::Serial(Some(path)) | LinkUri::Pty(Some(path)) => of_path(path),
        LinkUri::Serial(None) => {
            let found = usb_discovery::find().ok()?;
            if found.has_pipes {
                of_usb(found.serial)
            } else {
                of_path(&found.terminal)
            }
        }
        LinkUri::Usb(Some(serial)) => of_usb(Some(serial.clone())),
        LinkUri::Usb(None) => of_usb(usb::serial_of_the_only_one()),
        LinkUri::Tcp(_) | LinkUri::Pty(None) => None,
    }
}

/// Folders in which sockets can be; an owner takes the first that it may have.
fn folders() -> impl Iterator<Item = PathBuf> {
    let user = rustix::process::geteuid().as_raw();
    let session = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let session = session.filter(|path| path.is_absolute());
    let runtime = [session, Some(format!("/run/user/{user}").into())];
    runtime
        .into_iter()
        .flatten()
        .map(|folder| folder.join("armbridge"))
        .chain([std::env::temp_dir().join(format!("armbridge-{user}"))])
}

/// Whether it is a folder of this user, which others may not enter.
fn is_private(folder: &Path) -> bool {
    let user = rustix::process::geteuid().as_raw();
    folder.symlink_metadata().is_ok_and(|metadata| {
        metadata.is_dir() && metadata.uid() == user && metadata.mode() & 0o7777 == 0o700
    })
}

/// A request and its repetitions.
#[derive(Clone, Copy, Debug)]
struct Request {
    until: Instant,
    next: Instant,
}

/// Socket of a link's owner.
#[derive(Debug)]
pub(super) struct StopListener {
    listener: UnixListener,
    path: PathBuf,
    /// They wait for the answer.
    waiting: Vec<UnixStream>,
    request: Option<Request>,
    decoder: Decoder,
}

impl StopListener {
    /// Listens for stops of this link; `None` if it needs no socket.
    pub(super) fn open(link: &LinkUri) -> io::Result<Option<Self>> {
        let Some(name) = name(link) else {
            return Ok(None);
        };
        let mut last = io::Error::from(io::ErrorKind::NotFound);
        for folder in folders() {
            // It may be there already.
            let _ = DirBuilder::new().mode(0o700).create(&folder);
            if !is_private(&folder) {
                continue;
            }
            match Self::bind(folder.join(&name)) {
                Ok(listener) => return Ok(Some(listener)),
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    fn bind(path: PathBuf) -> io::Result<Self> {
        let listener = UnixListener::bind(&path).or_else(|error| {
            let is_stale = error.kind() == io::ErrorKind::AddrInUse
                && UnixStream::connect(&path)
                    .is_err_and(|error| error.kind() == io::ErrorKind::ConnectionRefused);
            if !is_stale {
                return Err(error);
            }
            std::fs::remove_file(&path)?;
            UnixListener::bind(&path)
        })?;
        listener.set_nonblocking(true)?;
        std::fs::set_permissions(&path, Permissions::from_mode(0o600))?;
        Ok(Self {
            listener,
            path,
            waiting: Vec::new(),
            request: None,
            decoder: Decoder::default(),
        })
    }

    /// Takes requests; true whenever a stop is to be sent to the board.
    pub(super) fn is_stop_due(&mut self) -> bool {
        let now = Instant::now();
        while let Ok((stream, _)) = self.listener.accept() {
            if self.waiting.len() < WAITING_MAX {
                self.waiting.push(stream);
            }
            self.decoder = Decoder::default();
            self.request = Some(Request {
                until: now + TIMEOUT,
                next: now,
            });
        }
        let Some(request) = &mut self.request else {
            return false;
        };
        if now >= request.until {
            self.answer("failed the stop was sent, and the board has not reported it");
            return false;
        }
        let is_due = now >= request.next;
        if is_due {
            request.next = now + INTERVAL;
        }
        is_due
    }

    /// Takes bytes of the board: its report ends a request.
    pub(super) fn receive(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if self.request.is_none() {
                return;
            }
            if let Some(Ok(received)) = self.decoder.push::<ToHost>(*byte)
                && let Some(fault) = fault(&received.message)
            {
                self.answer(&format!("stopped {}", enum_names::fault(fault)));
            }
        }
    }

    /// Answers all requests: the link is broken.
    pub(super) fn refuse(&mut self) {
        if self.is_stop_due() {
            self.answer("failed the link is broken; a board switches off when its host is silent");
        }
    }

    fn answer(&mut self, line: &str) {
        self.request = None;
        for mut stream in self.waiting.drain(..) {
            // A short line fits into the socket; one that asked may have gone.
            let _ = stream.set_nonblocking(true);
            let _ = writeln!(stream, "{line}");
        }
    }
}

/// The fault that a message reports.
fn fault(message: &ToHost) -> Option<Fault> {
    match message {
        ToHost::Tripped(trip) => Some(trip.fault),
        ToHost::Record(record) => match record.mode {
            Mode::Fault(fault) => Some(fault),
            _ => None,
        },
        _ => None,
    }
}

impl Drop for StopListener {
    fn drop(&mut self) {
        // Left behind, it is stale.
        let _ = std::fs::remove_file(&self.path);
    }
}
