//! Local sockets on Unix: Unix domain sockets in a folder of the user's.

use std::fs::{DirBuilder, Permissions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use super::{BoardKey, FOLDER_VARIABLE, Owner, names};

/// A connection.
pub(super) type Stream = UnixStream;

/// Folders in which sockets can be; an owner takes the first that it may have.
fn folders() -> Vec<PathBuf> {
    if let Some(folder) = std::env::var_os(FOLDER_VARIABLE) {
        return vec![folder.into()];
    }
    let user = rustix::process::geteuid().as_raw();
    let session = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let session = session.filter(|path| path.is_absolute());
    let runtime = [session, Some(format!("/run/user/{user}").into())];
    let mut folders: Vec<PathBuf> = runtime
        .into_iter()
        .flatten()
        .map(|folder| folder.join("armbridge"))
        .chain([std::env::temp_dir().join(format!("armbridge-{user}"))])
        .collect();
    folders.dedup();
    folders
}

/// Whether it is a folder of this user, which others may not enter.
fn is_private(folder: &Path) -> bool {
    let user = rustix::process::geteuid().as_raw();
    folder.symlink_metadata().is_ok_and(|metadata| {
        metadata.is_dir() && metadata.uid() == user && metadata.mode() & 0o7777 == 0o700
    })
}

/// Programs that have a board, also those that have ended without a word.
pub(super) fn owners() -> Vec<Owner> {
    let entries = folders()
        .into_iter()
        .filter(|folder| is_private(folder))
        .filter_map(|folder| folder.read_dir().ok())
        .flatten()
        .flatten();
    let owners = entries.filter_map(|entry| {
        let owner = Owner::of(entry.file_name().to_str()?)?;
        let name = entry.path().to_str()?.to_owned();
        Some(Owner { name, ..owner })
    });
    owners.collect()
}

/// Connects to a program; removes what one has left behind.
pub(super) fn connect(owner: &Owner) -> io::Result<Stream> {
    let stream = UnixStream::connect(&owner.name);
    if let Err(error) = &stream
        && error.kind() == io::ErrorKind::ConnectionRefused
    {
        // Another program may have removed it.
        let _ = std::fs::remove_file(&owner.name);
    }
    stream
}

/// A socket of this program.
#[derive(Debug)]
pub(super) struct Listener {
    listener: UnixListener,
    path: PathBuf,
}

impl Listener {
    pub(super) fn bind(board: &BoardKey) -> io::Result<Self> {
        let mut last = io::Error::from(io::ErrorKind::NotFound);
        for folder in folders() {
            // It may be there already.
            let _ = DirBuilder::new().mode(0o700).create(&folder);
            if !is_private(&folder) {
                continue;
            }
            for name in names(board) {
                match Self::bind_path(folder.join(name)) {
                    Ok(listener) => return Ok(listener),
                    // Another board of this program, or something that is no socket.
                    Err(error) if error.kind() == io::ErrorKind::AddrInUse => last = error,
                    Err(error) => {
                        last = error;
                        break;
                    }
                }
            }
        }
        Err(last)
    }

    fn bind_path(path: PathBuf) -> io::Result<Self> {
        let listener = UnixListener::bind(&path)?;
        listener.set_nonblocking(true)?;
        std::fs::set_permissions(&path, Permissions::from_mode(0o600))?;
        Ok(Self { listener, path })
    }

    /// The next connection that waits; its reads and writes do not block.
    pub(super) fn accept(&self) -> Option<Stream> {
        let (stream, _) = self.listener.accept().ok()?;
        stream.set_nonblocking(true).ok()?;
        Some(stream)
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        // Left behind, it refuses connections.
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_in_the_place_of_a_socket_is_passed_over() {
        let board = BoardKey::of_simulation("a board of this test:");
        let first = Listener::bind(&board).unwrap();
        let second = Listener::bind(&board).unwrap();
        assert_ne!(first.path, second.path);
        let taken = first.path.clone();
        drop(first);
        std::fs::write(&taken, "no socket").unwrap();
        let third = Listener::bind(&board).unwrap();
        std::fs::remove_file(taken).unwrap();
        let reached = owners()
            .into_iter()
            .filter(|owner| owner.board == board)
            .filter_map(|owner| connect(&owner).ok());
        assert_eq!(reached.count(), 2);
        assert!(second.accept().is_some() && third.accept().is_some());
    }
}
