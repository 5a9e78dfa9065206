//! What may be done with a client's packet while a control loop runs.
//!
//! A client may look at everything and may move what is not under control.
//! Whatever could move, rename, slow down or reset a servo under control is
//! refused, and so is what would harm the bus. No packet of the client goes on
//! the bus as it came: a harmless one becomes a
//! [`PendingRequest`](super::PendingRequest), whose queries are made here.
//!
//! On a stock bus:
//!
//! | packet                               | what becomes of it                 |
//! |--------------------------------------|------------------------------------|
//! | PING, READ                           | asked; beyond the table: range alarm |
//! | WRITE of `led` alone                 | asked                              |
//! | WRITE, `REG_WRITE` to another servo  | asked, unless it takes an id that is under control |
//! | `SYNC_WRITE` to other servos only    | asked, on the same condition       |
//! | ACTION, `FACTORY_RESET`, any other   | refused: instruction alarm         |
//! | any other to all servos              | refused in silence                 |
//! | damaged                              | answered: checksum alarm           |
//!
//! ACTION is refused to every servo, for what it sets off is not known;
//! `FACTORY_RESET` because it makes its victim another servo 1.
//!
//! On a Morpheus bus:
//!
//! | packet                               | what becomes of it                 |
//! |--------------------------------------|------------------------------------|
//! | PING                                 | asked                              |
//! | READ                                 | asked by safe READs ([`safe_read`]) |
//! | position in a READ, CYCLE to all     | answered from the loop's samples   |
//! | READ of nothing, beyond the table, or of an unknown position | refused: NOK |
//! | LEN of 128 or more; a client's address below 0x20 or of a servo | refused: NOK |
//! | any other                            | refused: NOK                       |
//! | any other to all servos              | refused in silence                 |
//! | damaged                              | answered with silence, as by a servo |
//!
//! A packet of another protocol than that of the bus is refused without a reply:
//! no servo would receive it.
//!
//! [`safe_read`]: crate::servo::morpheus::safe_read

mod morpheus;
mod stock;
mod verdict;

pub use verdict::Verdict;

use super::response::{Bytes, Responder};
use crate::JOINTS;
use crate::servo::{ClientRequest, Firmware, ServoId};

/// Judges one packet.
pub fn judge(
    bus: Firmware,
    controlled: [ServoId; JOINTS],
    samples: [Option<u16>; JOINTS],
    request: &ClientRequest,
) -> Verdict {
    if request.firmware != bus {
        return Verdict::Refuse(Bytes::new());
    }
    let responder = Responder::to(request);
    match bus {
        Firmware::Stock => stock::judge(responder, controlled, request),
        Firmware::Morpheus => morpheus::judge(responder, controlled, samples, request),
    }
}

#[cfg(test)]
mod tests;
