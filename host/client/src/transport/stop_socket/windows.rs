//! Local sockets on Windows: named pipes, which end with their owner.
//!
//! By default a pipe can be written by its owner's user, by administrators and by the system.
//! Pipes of all users are in one list, so the user's name is in that of the pipe. This is
//! compiled in the gate, and has not been run on Windows.

use std::io;

use interprocess::local_socket::traits::{Listener as _, Stream as _};
use interprocess::local_socket::{
    self as local, GenericNamespaced, ListenerNonblockingMode, ListenerOptions, ToNsName,
};

use super::{BoardKey, Owner, names};

/// A connection.
pub(super) type Stream = local::Stream;

/// Folder in which Windows lists named pipes.
const PIPES: &str = r"\\.\pipe\";

/// Beginning of a pipe's name.
fn prefix() -> String {
    let user = std::env::var("USERNAME").unwrap_or_default();
    let user = user.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    format!("armbridge.{user}.")
}

/// Programs that have a board.
pub(super) fn owners() -> Vec<Owner> {
    let prefix = prefix();
    let entries = std::fs::read_dir(PIPES).into_iter().flatten().flatten();
    let owners = entries.filter_map(|entry| {
        let name = entry.file_name().to_str()?.to_owned();
        let owner = Owner::of(name.strip_prefix(&prefix)?)?;
        Some(Owner { name, ..owner })
    });
    owners.collect()
}

/// Connects to a program.
pub(super) fn connect(owner: &Owner) -> io::Result<Stream> {
    Stream::connect(owner.name.as_str().to_ns_name::<GenericNamespaced>()?)
}

/// A pipe of this program.
#[derive(Debug)]
pub(super) struct Listener(local::Listener);

impl Listener {
    pub(super) fn bind(board: &BoardKey) -> io::Result<Self> {
        let mut last = io::Error::from(io::ErrorKind::NotFound);
        for name in names(board) {
            let name = format!("{}{name}", prefix());
            let options = ListenerOptions::new()
                .name(name.to_ns_name::<GenericNamespaced>()?)
                .nonblocking(ListenerNonblockingMode::Accept);
            match options.create_sync() {
                Ok(listener) => return Ok(Self(listener)),
                // Another board of this program.
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    /// The next connection that waits; its reads and writes do not block.
    pub(super) fn accept(&self) -> Option<Stream> {
        let stream = self.0.accept().ok()?;
        stream.set_nonblocking(true).ok()?;
        Some(stream)
    }
}
