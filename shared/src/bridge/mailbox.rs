//! Where the tick and the rest of the world meet.
//!
//! Lock-free single-producer single-consumer queues, split once at boot. The
//! tick never waits for them: orders are states, of which the latest of a kind
//! wins; records and notices are dropped and counted when nobody fetches them.
//! The client of the transparent port has queues of bytes, one each way. Whether
//! there is something new in them, a [`QueueWatch`] tells without holding an end. An
//! emergency stop has a place of its own, so that no full queue holds it up.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use super::course::{Departure, Leg};
use super::gateway::{BusSide, PortEnd};
use super::law::Law;
use super::queue::{Channel, Count, Receiver, Sender};
use crate::JOINTS;
use crate::control::trajectory::stream::Point;
use crate::link::experiment::{Conclusion, Experiment};
use crate::link::message::{
    Halt, Limits, Missing, Moment, PortCounters, Record, Refusal, StopSource, Trip,
};
use crate::servo::Firmware;

/// Orders that fit between two ticks. A spsc queue holds one less than this.
const ORDERS: usize = 8;
/// Acknowledgements and the like on their way to the host.
const NOTICES: usize = 16;
/// Records on their way to the host, 104 bytes each: at 1 kHz, 15 ms worth.
///
/// That is for the board's own end of the link, which is away for 2 ms at the most:
/// gains take 39,000 instructions to design, between ticks, and a save of settings
/// some 70 words of flash at 16 µs. A host that stalls for longer has buffers of its
/// own in the USB transfers that it keeps open, and memory is cheaper there.
const RECORDS: usize = 16;

/// Bytes of the transparent port in either direction: two of the longest packet.
pub(super) const CLIENT_BYTES: usize = 1024;

/// Nobody has asked for an emergency stop.
const NO_EMERGENCY: u8 = 0;

/// Who has, as a code that fits an atomic.
const fn emergency_code(source: StopSource) -> u8 {
    match source {
        StopSource::Host => 1,
        StopSource::Pin => 2,
        StopSource::Flood => 3,
    }
}

/// From the link to the tick.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap for a box")]
pub(super) enum Order {
    /// The host is alive.
    Heartbeat,
    /// The host has said hello.
    Greeted,
    /// The host leaves.
    Goodbye,
    /// A command, with the sequence number to acknowledge.
    Do(u16, Task),
}

/// A validated command. Gains are designed before it gets here.
#[derive(Clone, Debug)]
pub(super) enum Task {
    Idle,
    /// The session has been checked.
    Arm,
    Torque([f32; JOINTS]),
    Regulate([f32; JOINTS]),
    /// Where would a motion begin? Answered by [`Notice::Departure`].
    Depart,
    Follow(Leg),
    Stream(Point<f32>),
    /// Its shape has been checked.
    Experiment(Experiment),
    Prepare,
    Release,
    ClearFault,
    Install(Law),
    Limit(Limits),
    /// May the settings be written now?
    Save,
}

/// From the tick to the link, besides records.
#[derive(Clone, Copy, Debug)]
pub(super) enum Notice {
    /// What became of an order.
    Ack(u16, Result<(), Refusal>, Moment),
    /// Where the motion with this sequence number begins.
    Departure(u16, Departure, Moment),
    /// A hello was heard.
    Began(Moment),
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
    /// Why there is a fault.
    Tripped(Trip),
    /// What the servos did after the stop sequence.
    Halted(Halt),
    /// How an experiment ended.
    Concluded(Conclusion),
    /// The temperature of this joint's servo.
    Temperature(u8, u16),
}

/// The queues themselves; a `static` on the board.
#[derive(Default)]
pub struct Mailboxes {
    orders: Channel<Order, ORDERS>,
    notices: Channel<Notice, NOTICES>,
    records: Channel<Record, RECORDS>,
    from_client: Channel<u8, CLIENT_BYTES>,
    to_client: Channel<u8, CLIENT_BYTES>,
    client_line: AtomicU32,
    emergency: AtomicU8,
}

impl Mailboxes {
    /// Empty queues.
    pub const fn new() -> Self {
        Self {
            orders: Channel::new(),
            notices: Channel::new(),
            records: Channel::new(),
            from_client: Channel::new(),
            to_client: Channel::new(),
            client_line: AtomicU32::new(0),
            emergency: AtomicU8::new(NO_EMERGENCY),
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
                emergency: &self.emergency,
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
                emergency: &self.emergency,
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
    pub(super) orders: Receiver<'a, Order, ORDERS>,
    pub(super) notices: Sender<'a, Notice, NOTICES>,
    pub(super) records: Sender<'a, Record, RECORDS>,
    emergency: &'a AtomicU8,
    pub(super) client: BusSide<'a>,
}

/// The link's end.
pub struct LinkEnd<'a> {
    pub(super) orders: Sender<'a, Order, ORDERS>,
    pub(super) notices: Receiver<'a, Notice, NOTICES>,
    pub(super) records: Receiver<'a, Record, RECORDS>,
    emergency: &'a AtomicU8,
}

/// Whether the tick has done something that another loop waits for, for whoever
/// wakes them: most polls of the bus have nothing for anybody.
pub struct QueueWatch<'a> {
    for_link: [&'a Count; 2],
    for_client: [&'a Count; 2],
    link_seen: u32,
    client_seen: u32,
}

impl QueueWatch<'_> {
    /// There is a record or a notice for the host that was not there before.
    pub fn has_link_news(&mut self) -> bool {
        is_new(self.for_link, &mut self.link_seen)
    }

    /// There is a byte for the client of the transparent port, or room for one of its.
    pub fn has_client_news(&mut self) -> bool {
        is_new(self.for_client, &mut self.client_seen)
    }
}

/// Whether one of these has changed since the last time.
fn is_new(counts: [&Count; 2], seen: &mut u32) -> bool {
    // Each counts up, so that their sum stands still only if all do.
    let [a, b] = counts.map(Count::get);
    let count = a.wrapping_add(b);
    core::mem::replace(seen, count) != count
}

impl<'a> BridgeEnd<'a> {
    /// A watch over what this end will do.
    pub fn watch(&self) -> QueueWatch<'a> {
        QueueWatch {
            for_link: [self.records.sent(), self.notices.sent()],
            for_client: [
                self.client.to_client.sent(),
                self.client.from_client.received(),
            ],
            link_seen: 0,
            client_seen: 0,
        }
    }
}

impl BridgeEnd<'_> {
    /// The emergency stop that the link has asked for, once.
    pub(super) fn take_emergency(&self) -> Option<StopSource> {
        let code = self.emergency.load(Ordering::Acquire);
        if code == NO_EMERGENCY {
            return None;
        }
        // Whoever asks between the two asks for what is done anyway.
        self.emergency.store(NO_EMERGENCY, Ordering::Release);
        let sources = [StopSource::Pin, StopSource::Flood];
        let known = sources.into_iter().find(|s| emergency_code(*s) == code);
        Some(known.unwrap_or(StopSource::Host))
    }
}

impl LinkEnd<'_> {
    /// Asks for an emergency stop.
    pub(super) fn emergency(&self, source: StopSource) {
        let code = emergency_code(source);
        self.emergency.store(code, Ordering::Release);
    }
}
