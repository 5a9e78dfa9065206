//! Policy for a client's packets while a control loop runs.
//!
//! A client may read every servo and may move servos that are not under control.
//! A packet that could move, re-address, slow down or reset a servo under control, or
//! disturb the bus, is refused. No packet of the client is sent on
//! the bus unchanged: a harmless one becomes a
//! [`PendingRequest`](super::PendingRequest), whose queries are made here.
//!
//! On a bus of stock or X servos:
//!
//! | packet                               | verdict                            |
//! |--------------------------------------|------------------------------------|
//! | PING, READ                           | queried; beyond the table: range alarm |
//! | WRITE of `led` alone                 | queried                            |
//! | WRITE, `REG_WRITE` to another servo  | queried, unless it takes an id that is under control |
//! | `SYNC_WRITE` to other servos only    | queried, on the same condition     |
//! | reads of several servos at once      | refused in silence                 |
//! | ACTION, `FACTORY_RESET`, any other   | refused: instruction alarm         |
//! | any other to all servos              | refused in silence                 |
//! | damaged                              | answered: checksum alarm           |
//!
//! ACTION is refused to every servo, because its effect is not known;
//! `FACTORY_RESET` because it changes the id of the servo to 1.
//!
//! On a Morpheus bus:
//!
//! | packet                               | verdict                            |
//! |--------------------------------------|------------------------------------|
//! | PING                                 | queried                            |
//! | READ                                 | queried by safe READs ([`safe_read`]) |
//! | position in a READ, CYCLE to all     | answered from the loop's samples   |
//! | READ of no bytes, beyond the table, or of an unknown position | refused: NOK |
//! | LEN of 128 or more; a client's address below 0x20 or of a servo | refused: NOK |
//! | any other                            | refused: NOK                       |
//! | any other to all servos              | refused in silence                 |
//! | damaged                              | answered with silence, as by a servo |
//!
//! A packet of another protocol than that of the bus is refused without a reply:
//! no servo would receive it.
//!
//! [`safe_read`]: armbridge_servo::morpheus::safe_read

mod dynamixel;
mod morpheus;
mod verdict;

pub use verdict::Verdict;

use super::response::{Bytes, Responder};
use armbridge_servo::{ClientRequest, Firmware, JOINTS, ServoIds};

/// Decides on one packet.
pub fn decide(
    bus: Firmware,
    controlled: ServoIds,
    samples: [Option<u16>; JOINTS],
    request: &ClientRequest,
) -> Verdict {
    if request.firmware != bus {
        return Verdict::Refuse(Bytes::new());
    }
    let responder = Responder::for_request(request);
    match bus {
        Firmware::Stock => dynamixel::decide(responder, &dynamixel::AX12A, controlled, request),
        Firmware::XSeries => dynamixel::decide(responder, &dynamixel::X, controlled, request),
        Firmware::Morpheus => morpheus::decide(responder, controlled, samples, request),
    }
}

#[cfg(test)]
mod tests;
