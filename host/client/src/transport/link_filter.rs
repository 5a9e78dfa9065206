//! Filters the messages of a link's server out of the bytes from the board.
//!
//! Bytes pass once their frame is complete, or too long to be one.

use armbridge_link::frame::{self, Decoder, Message};
use armbridge_link::server::FromServer;

/// Place of the direction in a frame, behind the first COBS code and the version, none of
/// which is zero.
const DIRECTION_AT: usize = 2;

/// Bytes of a frame that has begun.
#[derive(Debug, Default)]
pub(super) struct LinkFilter {
    frame: Vec<u8>,
}

impl LinkFilter {
    /// The bytes of these that are for the host; calls `take` with each message of the server.
    pub(super) fn pass(&mut self, bytes: &[u8], mut take: impl FnMut(FromServer)) -> Vec<u8> {
        let mut passed = Vec::with_capacity(self.frame.len() + bytes.len());
        for byte in bytes {
            self.frame.push(*byte);
            if *byte == 0 {
                match of_server(&self.frame) {
                    Some(message) => take(message),
                    None => passed.extend_from_slice(&self.frame),
                }
                self.frame.clear();
            } else if self.frame.len() > frame::MAX {
                passed.append(&mut self.frame);
            }
        }
        passed
    }
}

fn of_server(frame: &[u8]) -> Option<FromServer> {
    if frame.get(DIRECTION_AT) != Some(&FromServer::DIRECTION) {
        return None;
    }
    let mut decoder = Decoder::default();
    let received = frame.iter().find_map(|byte| decoder.push(*byte))?;
    Some(received.ok()?.message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::frame::Encoder;
    use armbridge_link::message::ToHost;
    use armbridge_link::schema;

    #[test]
    fn only_whole_frames_of_the_server_are_taken_out() {
        let touched = FromServer::Touched(Ok(()));
        let of_server = Encoder::default().encode(&touched).1.to_vec();
        let hello = Encoder::default()
            .encode(&ToHost::Hello(schema::HELLO))
            .1
            .to_vec();
        let garbage = [b'P'; frame::MAX + 7];
        let (cut, mut plain) = (&of_server[3..], vec![0]);
        for part in [&hello[..], cut, &garbage, &[0], &hello] {
            plain.extend_from_slice(part);
        }
        let mut mixed = of_server.clone();
        mixed.extend_from_slice(&plain);
        mixed.extend_from_slice(&of_server);
        for step in [1, 7, mixed.len()] {
            let (mut filter, mut taken, mut passed) = (LinkFilter::default(), 0, Vec::new());
            for bytes in mixed.chunks(step) {
                passed.extend(filter.pass(bytes, |message| {
                    assert_eq!(message, touched);
                    taken += 1;
                }));
            }
            assert_eq!((taken, &passed), (2, &plain), "{step}");
        }
    }
}
