//! Where the tick and the rest of the world meet.
//!
//! Lock-free single-producer single-consumer queues, split once at boot. The
//! tick never waits for them: orders are states, of which the latest of a kind
//! wins; records and notices are dropped and counted when nobody fetches them.
//! The client of the transparent port has queues of bytes, one each way.

use core::sync::atomic::AtomicU32;
use heapless::spsc::{Consumer, Producer, Queue};

use super::course::{Departure, Leg};
use super::gateway::{BusSide, PortEnd};
use super::law::Law;
use crate::JOINTS;
use crate::control::trajectory::stream::Point;
use crate::link::message::{Missing, PortCounters, Record, Refusal};
use crate::servo::Firmware;

/// Orders that fit between two ticks. A spsc queue holds one less than this.
const ORDERS: usize = 8;
/// Acknowledgements and the like on their way to the host.
const NOTICES: usize = 16;
/// Records on their way to the host: at 1 kHz, 63 ms worth.
const RECORDS: usize = 64;

/// Bytes of the transparent port in either direction: two of the longest packet.
const CLIENT_BYTES: usize = 1024;

/// From the link to the tick.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap for a box")]
pub(super) enum Order {
    /// The host is alive.
    Heartbeat,
    /// The host has said hello.
    Greeted,
    /// A command, with the sequence number to acknowledge.
    Do(u16, Task),
}

/// A validated command. Gains are designed before it gets here.
#[derive(Clone, Debug)]
pub(super) enum Task {
    Idle,
    Torque([f32; JOINTS]),
    Regulate([f32; JOINTS]),
    /// Where would a motion begin? Answered by [`Notice::Departure`].
    Depart,
    Follow(Leg),
    Stream(Point<f32>),
    Prepare,
    Release,
    ClearFault,
    Install(Law),
}

/// From the tick to the link, besides records.
#[derive(Clone, Copy, Debug)]
pub(super) enum Notice {
    /// What became of an order.
    Ack(u16, Result<(), Refusal>),
    /// Where the motion with this sequence number begins.
    Departure(u16, Departure),
    /// The servo of this joint did not answer during bring-up.
    Absent(u8, Missing),
    /// What the servos run, the speed of the bus, and whether they take torque.
    Found(Firmware, u32, bool),
    /// They run different firmwares.
    Mixed([Firmware; JOINTS]),
    /// A client has the bus.
    Passthrough,
    /// The stock servo of this joint does not take its settings.
    Unprepared(u8),
    /// What became of the client's packets so far.
    Port(PortCounters),
}

/// The queues themselves; a `static` on the board.
#[derive(Default)]
pub struct Mailboxes {
    orders: Queue<Order, ORDERS>,
    notices: Queue<Notice, NOTICES>,
    records: Queue<Record, RECORDS>,
    from_client: Queue<u8, CLIENT_BYTES>,
    to_client: Queue<u8, CLIENT_BYTES>,
    client_line: AtomicU32,
}

impl Mailboxes {
    /// Empty queues.
    pub const fn new() -> Self {
        Self {
            orders: Queue::new(),
            notices: Queue::new(),
            records: Queue::new(),
            from_client: Queue::new(),
            to_client: Queue::new(),
            client_line: AtomicU32::new(0),
        }
    }

    /// The three ends: for the tick, for the link, for the transparent port.
    pub fn split(&mut self) -> (BridgeEnd<'_>, LinkEnd<'_>, PortEnd<'_>) {
        let (orders_in, orders_out) = self.orders.split();
        let (notices_in, notices_out) = self.notices.split();
        let (records_in, records_out) = self.records.split();
        let (client_in, client_out) = self.from_client.split();
        let (answers_in, answers_out) = self.to_client.split();
        (
            BridgeEnd {
                orders: orders_out,
                notices: notices_in,
                records: records_in,
                client: BusSide {
                    from_client: client_out,
                    to_client: answers_in,
                    line: &self.client_line,
                },
            },
            LinkEnd {
                orders: orders_in,
                notices: notices_out,
                records: records_out,
            },
            PortEnd {
                from_client: client_in,
                to_client: answers_out,
                line: &self.client_line,
            },
        )
    }
}

/// The tick's end.
pub struct BridgeEnd<'a> {
    pub(super) orders: Consumer<'a, Order>,
    pub(super) notices: Producer<'a, Notice>,
    pub(super) records: Producer<'a, Record>,
    pub(super) client: BusSide<'a>,
}

/// The link's end.
pub struct LinkEnd<'a> {
    pub(super) orders: Producer<'a, Order>,
    pub(super) notices: Consumer<'a, Notice>,
    pub(super) records: Consumer<'a, Record>,
}
