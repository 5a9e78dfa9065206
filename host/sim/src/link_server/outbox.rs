//! Frames to a peer that may not read: whole frames are dropped, none is cut.

use std::io::Write;

use crate::nonblocking;

/// The rest of a frame that has begun to be sent; at most one frame is kept.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    unsent: Vec<u8>,
}

impl Outbox {
    /// Sends as many of these frames as fit, and keeps the rest of the last one.
    pub(super) fn send(&mut self, stream: &mut dyn Write, frames: &[u8]) {
        let sent = nonblocking::write(stream, &self.unsent);
        self.unsent.drain(..sent);
        if self.unsent.is_empty() {
            let sent = nonblocking::write(stream, frames);
            self.unsent.extend_from_slice(rest_of_frame(frames, sent));
        }
    }

    /// Forgets the rest: another peer follows.
    pub(super) fn clear(&mut self) {
        self.unsent.clear();
    }
}

/// Remainder of the frame that was cut after `sent` bytes. Complete frames follow, which
/// may be dropped.
fn rest_of_frame(bytes: &[u8], sent: usize) -> &[u8] {
    let rest = &bytes[sent..];
    if sent == 0 || bytes[sent - 1] == 0 {
        return &[];
    }
    let end = rest.iter().position(|byte| *byte == 0);
    &rest[..end.map_or(rest.len(), |end| end + 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_frame_is_completed() {
        let frames = [1, 2, 0, 3, 4, 0, 5, 0];
        for (sent, rest) in [
            (0, &[][..]),
            (1, &[2, 0]),
            (3, &[]),
            (4, &[4, 0]),
            (7, &[0]),
            (8, &[]),
        ] {
            assert_eq!(rest_of_frame(&frames, sent), rest, "{sent}");
        }
    }
}
