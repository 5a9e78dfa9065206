//! A control transfer (USB 2.0, section 8.5.3): SETUP, data, status.

use super::PACKET;
use super::enumeration::Request;
use crate::peripherals::otg::{Answer, Otg};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Setup,
    DataIn,
    DataOut,
    StatusIn,
    StatusOut,
}

/// A transfer in progress.
#[derive(Clone, Debug)]
pub struct Transfer {
    request: Request,
    stage: Stage,
    data: Vec<u8>,
    sent: usize,
    toggle: bool,
}

/// End of a transfer: the data, or that the device refused it.
pub type Outcome = Result<Vec<u8>, Refused>;

/// The device stalled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused;

impl Transfer {
    /// A request, with the data that it sends.
    pub fn new(request: Request, data: Vec<u8>) -> Self {
        Self {
            request,
            stage: Stage::Setup,
            data,
            sent: 0,
            toggle: true,
        }
    }

    /// Performs the next transaction; `Some` at the end.
    pub fn transact(&mut self, otg: &mut Otg) -> Option<Outcome> {
        match self.stage {
            Stage::Setup => {
                if otg.setup(self.request.to_bytes(self.data.len())) == Answer::Ack {
                    self.stage = match (self.request.is_in(), self.data.is_empty()) {
                        (true, _) => Stage::DataIn,
                        (false, true) => Stage::StatusIn,
                        (false, false) => Stage::DataOut,
                    };
                }
                None
            }
            Stage::DataIn => match otg.input(0) {
                Answer::Data(data, toggle) if toggle == self.toggle => {
                    self.toggle = !self.toggle;
                    let is_short = data.len() < PACKET;
                    self.data.extend(data);
                    if is_short || self.data.len() >= usize::from(self.request.length) {
                        self.stage = Stage::StatusOut;
                    }
                    None
                }
                Answer::Stall => Some(Err(Refused)),
                _ => None,
            },
            Stage::DataOut => {
                let end = self.data.len().min(self.sent + PACKET);
                match otg.out(0, &self.data[self.sent..end], self.toggle) {
                    Answer::Ack => {
                        self.toggle = !self.toggle;
                        self.sent = end;
                        if self.sent == self.data.len() {
                            self.stage = Stage::StatusIn;
                        }
                        None
                    }
                    Answer::Stall => Some(Err(Refused)),
                    _ => None,
                }
            }
            Stage::StatusIn => match otg.input(0) {
                Answer::Data(..) => Some(Ok(Vec::new())),
                Answer::Stall => Some(Err(Refused)),
                _ => None,
            },
            // A status packet is DATA1.
            Stage::StatusOut => match otg.out(0, &[], true) {
                Answer::Ack => Some(Ok(std::mem::take(&mut self.data))),
                Answer::Stall => Some(Err(Refused)),
                _ => None,
            },
        }
    }
}
