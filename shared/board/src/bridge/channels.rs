//! Channels between the link's side, in thread mode, and the tick.
//!
//! Lock-free single-producer single-consumer queues and words, split once at boot. The
//! tick never waits for them. Commands may be refused, so they have a queue that may be
//! full. Hello, goodbye, stop and heartbeat may not: they are counters, see [`super::signals`].
//!
//! # Epochs
//!
//! A hello and a stop begin a new epoch, and a command carries the epoch in which it was
//! sent. The tick reads signals before it takes a command, and takes none of an earlier
//! epoch: a command sent before a stop cannot act after it, and a command of
//! one session is not executed in the next.
//!
//! Records and notifications are dropped when the host does not fetch them; records are
//! counted then. The client of the transparent port has queues of bytes, one each way.
//! A [`QueueWatch`] detects new items in them, without holding an end.

use core::sync::atomic::AtomicU32;

use super::command::ValidatedCommand;
use super::queue::{Channel, Count, Receiver, Sender};
use super::signals::{SignalCounters, SignalReader};
use super::transparent_port::{BusSide, CLIENT_BYTES, PortEnd};
use crate::tick::reference::StartPoint;
use armbridge_link::experiment::Conclusion;
use armbridge_link::message::{Missing, Moment, OffReport, PortCounters, Record, Refusal, Trip};
use armbridge_servo::{Firmware, JOINTS};

/// Commands that fit between two ticks. A spsc queue holds one less than this.
const REQUESTS: usize = 8;
/// Notifications that fit on the way to the host, such as acknowledgements.
const NOTIFICATIONS: usize = 16;
/// Records that fit on the way to the host, 104 bytes each: at 1 kHz, 15 ms worth.
///
/// This covers the board's own end of the link, which is busy for 2 ms at most:
/// gains take 39,000 instructions to design, between ticks, and a save of settings
/// some 70 words of flash at 16 µs. A host that stalls for longer has buffers of its
/// own in the USB transfers that it keeps open, and memory is cheaper there.
const RECORDS: usize = 16;

/// A command of the host, which may be refused.
#[derive(Clone, Debug)]
pub(super) struct HostRequest {
    /// Epoch in which it was sent.
    pub(super) epoch: u32,
    /// Sequence number to acknowledge.
    pub(super) sequence: u16,
    pub(super) command: ValidatedCommand,
}

/// Notification of the tick to the link.
#[derive(Clone, Copy, Debug)]
pub(super) enum Notification {
    /// A command was not taken: a stop or a hello came after it.
    Dropped(u16),
    /// The answer to a command.
    Ack(u16, Result<(), Refusal>, Moment),
    /// The start of the motion with this sequence number.
    StartPoint(u16, StartPoint, Moment),
    /// A hello was received.
    Began(Moment),
    /// The servo of this joint did not answer during bring-up.
    Absent(u8, Missing),
    /// Firmware of the servos, speed of the bus, and whether they take torque.
    Found(Firmware, u32, bool),
    /// The servos run different firmwares.
    Mixed([Firmware; JOINTS]),
    /// A client has the bus.
    Passthrough,
    /// The stock servo of this joint rejects its settings.
    Unprepared(u8),
    /// Counters of the client's packets.
    Port(PortCounters),
    /// Cause of a fault.
    Tripped(Trip),
    /// Evidence on motors that must be off.
    Off(OffReport),
    /// End of an experiment.
    Concluded(Conclusion),
    /// The temperature of this joint's servo.
    Temperature(u8, u16),
}

/// The queues; a `static` on the board.
#[derive(Default)]
pub struct Channels {
    requests: Channel<HostRequest, REQUESTS>,
    notifications: Channel<Notification, NOTIFICATIONS>,
    records: Channel<Record, RECORDS>,
    from_client: Channel<u8, CLIENT_BYTES>,
    to_client: Channel<u8, CLIENT_BYTES>,
    client_line: AtomicU32,
    signals: SignalCounters,
}

impl Channels {
    /// Empty queues.
    pub const fn new() -> Self {
        Self {
            requests: Channel::new(),
            notifications: Channel::new(),
            records: Channel::new(),
            from_client: Channel::new(),
            to_client: Channel::new(),
            client_line: AtomicU32::new(0),
            signals: SignalCounters::new(),
        }
    }

    /// The three ends: for the tick, for the link, for the transparent port.
    pub fn split(&mut self) -> (BridgeEnd<'_>, LinkEnd<'_>, PortEnd<'_>) {
        let (requests_in, requests_out) = self.requests.split();
        let (notifications_in, notifications_out) = self.notifications.split();
        let (records_in, records_out) = self.records.split();
        let (client_in, client_out) = self.from_client.split();
        let (answers_in, answers_out) = self.to_client.split();
        (
            BridgeEnd {
                mailbox: Mailbox {
                    requests: requests_out,
                    notifications: notifications_in,
                    records: records_in,
                    signals: self.signals.reader(),
                },
                client: BusSide {
                    from_client: client_out,
                    to_client: answers_in,
                    line: &self.client_line,
                },
            },
            LinkEnd {
                requests: requests_in,
                notifications: notifications_out,
                records: records_out,
                signals: &self.signals,
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
    pub(super) mailbox: Mailbox<'a>,
    pub(super) client: BusSide<'a>,
}

/// The queues between tick and host.
pub(super) struct Mailbox<'a> {
    requests: Receiver<'a, HostRequest, REQUESTS>,
    notifications: Sender<'a, Notification, NOTIFICATIONS>,
    records: Sender<'a, Record, RECORDS>,
    pub(super) signals: SignalReader<'a>,
}

/// The link's end.
pub struct LinkEnd<'a> {
    requests: Sender<'a, HostRequest, REQUESTS>,
    pub(super) notifications: Receiver<'a, Notification, NOTIFICATIONS>,
    pub(super) records: Receiver<'a, Record, RECORDS>,
    pub(super) signals: &'a SignalCounters,
}

/// Change detector of the queues, for the loops that wait for them: most polls of the bus
/// change none.
pub struct QueueWatch<'a> {
    for_link: [&'a Count; 2],
    for_client: [&'a Count; 2],
    link_seen: u32,
    client_seen: u32,
}

impl QueueWatch<'_> {
    /// Whether there is a new record or notification for the host.
    pub fn has_link_activity(&mut self) -> bool {
        is_new(self.for_link, &mut self.link_seen)
    }

    /// Whether there is a new byte for the client of the transparent port, or new room for
    /// one from it.
    pub fn has_client_activity(&mut self) -> bool {
        is_new(self.for_client, &mut self.client_seen)
    }
}

/// Whether one of these counts has changed since the last call.
fn is_new(counts: [&Count; 2], seen: &mut u32) -> bool {
    // Each counts up, so that their sum is constant only if both are.
    let [a, b] = counts.map(Count::get);
    let count = a.wrapping_add(b);
    core::mem::replace(seen, count) != count
}

impl<'a> BridgeEnd<'a> {
    /// A watch over this end's queues.
    pub fn watch(&self) -> QueueWatch<'a> {
        QueueWatch {
            for_link: [
                self.mailbox.records.sent(),
                self.mailbox.notifications.sent(),
            ],
            for_client: [
                self.client.to_client.sent(),
                self.client.from_client.received(),
            ],
            link_seen: 0,
            client_seen: 0,
        }
    }
}

impl Mailbox<'_> {
    /// Queues a notification for the host. `false` if the queue is full: the host does not fetch
    /// them, and repeats its hello.
    pub(super) fn notify(&mut self, notification: Notification) -> bool {
        self.notifications.enqueue(notification).is_ok()
    }

    /// Queues a record for the host; `false` if the queue is full.
    pub(super) fn publish(&mut self, record: &Record) -> bool {
        self.records.enqueue(*record).is_ok()
    }

    /// Takes the oldest command.
    pub(super) fn take_request(&mut self) -> Option<HostRequest> {
        self.requests.dequeue()
    }

    /// Whether a command is of the epoch of the last signals.
    pub(super) fn is_present(&self, request: &HostRequest) -> bool {
        request.epoch == self.signals.epoch()
    }
}

impl LinkEnd<'_> {
    /// Sends a command of the present epoch.
    ///
    /// # Errors
    /// [`Refusal::Busy`] if the queue is full.
    pub(super) fn request(
        &mut self,
        sequence: u16,
        command: ValidatedCommand,
    ) -> Result<(), Refusal> {
        let request = HostRequest {
            epoch: self.signals.epoch(),
            sequence,
            command,
        };
        let result = self.requests.enqueue(request);
        self.signals.note();
        result.map_err(|_| Refusal::Busy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::message::StopSource;

    #[test]
    fn a_watch_sees_what_the_tick_has_done_once() {
        let mut channels = Channels::new();
        let (mut tick, mut link, mut client) = channels.split();
        let mut watch = tick.watch();
        let mut activity = || (watch.has_link_activity(), watch.has_client_activity());
        assert_eq!(activity(), (false, false));
        // What comes from the other ends is no activity of the tick.
        assert_eq!(client.receive(&[1]), 1);
        link.signals.stop(StopSource::Host);
        assert_eq!(activity(), (false, false));

        assert!(tick.mailbox.signals.take().stop.is_some());
        assert!(tick.mailbox.notify(Notification::Passthrough));
        assert_eq!(activity(), (true, false));
        assert!(link.notifications.dequeue().is_some());
        assert_eq!(activity(), (false, false));
        // Room for another byte, and a byte.
        assert_eq!(tick.client.from_client.dequeue(), Some(1));
        assert_eq!(activity(), (false, true));
        assert!(tick.client.to_client.enqueue(2).is_ok());
        assert_eq!(activity(), (false, true));
        assert_eq!(client.transmit(), Some(2));
        assert_eq!(activity(), (false, false));
    }
}
