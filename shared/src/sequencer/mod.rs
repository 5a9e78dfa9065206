//! The bus sequencer: what the servo bus is used for, and who may use it.
//!
//! It is in exactly one of four states:
//!
//! ```text
//!             lined up                  leave to drive
//!  Search ---------------> ForceOff <------------------> Drive
//!    ^ ^                    |  ^  |     leave withdrawn    |
//!    | +--- search ---------+  |  |                        |
//!    |                         |  | leave to lend          | leave to lend
//!    |    leave withdrawn      |  v                        |
//!    +-------------------------+ Lent <--------------------+
//! ```
//!
//! | state      | the bus carries                                                |
//! |------------|----------------------------------------------------------------|
//! | `Search`   | stops, pings and settings, until the servos are lined up       |
//! | `ForceOff` | one exchange a tick that commands every motor off, stop sequences and read-backs until each is confirmed off |
//! | `Drive`    | one exchange a tick with the control loop's command            |
//! | `Lent`     | a client's packets, as they came                               |
//!
//! # Who may drive
//!
//! [`BusSequencer::permit`] passes on the supervisor's leave, before anything is begun.
//! Without leave to drive no exchange carries a torque, and without leave to lend no
//! byte of a client's is relayed, whatever was asked for before: `ForceOff` is where the
//! sequencer goes by itself. From `Lent` the way leads through a stop at every speed
//! that the client used and through `Search`, for what a client did is not known.
//!
//! # Idle slots
//!
//! Between two ticks the bus is free for a while. One arbiter gives that time away, to
//! one `IdleRequest` at a time: to read-backs first, then to health polls, then to a
//! client. Each is registered with its owner and the reply that it expects, and a reply
//! goes to its owner and to no other.
//!
//! # Timing
//!
//! Call [`poll`](BusSequencer::poll) whenever something has happened on the bus, and at
//! [`wake_at_us`](BusSequencer::wake_at_us) at the latest; it never waits. Stop sequences
//! last 7 ms at 1 Mbaud, so with motors off ticks may begin late. A tick with motors
//! driven begins late, by some 100 µs, only where a health poll is worth it.
//!
//! | module         | what                                                       |
//! |----------------|------------------------------------------------------------|
//! | `force_off`    | evidence that motors are off                               |
//! | `stop_plan`    | stops at several speeds                                    |
//! | `discovery`    | which servos there are, and at which speed                 |
//! | `servo_setup`  | stock servos made ready, and given back                    |
//! | `health_poll`  | temperatures, and pings of servos that fall silent         |
//! | `exchange`     | the exchange of a tick                                     |
//! | `idle_request` | a query for that time, and its owner                       |
//! | `idle_slot`    | the arbiter of the time between two exchanges              |
//! | `time_budget`  | what fits into that time                                   |
//! | `lent`         | the bus lent to a client                                   |
//! | `steps`        | how transactions begin, end, and lead to each other        |

mod discovery;
mod dropouts;
mod exchange;
mod force_off;
mod health_poll;
mod idle_request;
mod idle_slot;
mod lent;
mod servo_setup;
mod setup_step;
mod steps;
mod stop_plan;
mod time_budget;

pub use dropouts::Dropouts;
pub use health_poll::Health;
pub use time_budget::TimeBudget;

use crate::JOINTS;
use crate::flow_token::FlowToken;
use crate::link::message::{Missing, OffReport};
use crate::servo::master::timing::tick_us;
use crate::servo::master::{Master, Outcome, Payload};
use crate::servo::port::{BAUD_RATES, SetBaud};
use crate::servo::{Firmware, ServoId};
use discovery::Discovery;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};
use force_off::ForceOff;
use health_poll::HealthPoll;
use idle_request::Owner;
use servo_setup::ServoSetup;
use setup_step::SetupStep;
use stop_plan::{Speeds, StopPlan, add_speed};

/// The supervisor's leave: what the bus may be used for now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusLeave {
    /// For nothing but finding the servos, motors off.
    Search,
    /// For ticks with motors off.
    Off,
    /// The same, and each in time: motors may be driven soon.
    Armed,
    /// For ticks that drive the motors.
    Drive,
    /// For a client's packets.
    Lend,
}

/// What the sequencer is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// The servos are being found.
    Search(SearchStep),
    /// Motors are switched off, again and again.
    ForceOff,
    /// Motors are driven.
    Drive,
    /// The bus is a client's.
    Lent,
}

/// Where a search is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SearchStep {
    /// The stop sequence at the speed at hand comes next.
    Stop,
    /// Is this joint's servo there, and does it run this firmware?
    Ping {
        /// Index of the joint.
        joint: usize,
        /// Whose protocol is spoken.
        firmware: Firmware,
    },
    /// Morpheus servos are lined up for the position chain.
    Start,
    /// Stock servos are read, made ready, or given back.
    SetUp(SetupStep),
}

/// What came of a poll.
#[derive(Clone, Copy, Debug)]
pub enum BusEvent {
    /// A tick's exchange is over; the tick's token, stamped.
    Sampled(Outcome, FlowToken),
    /// A step of a search or a stop is over; torque is off.
    Searching,
    /// The servos are lined up: ticks may begin.
    LinedUp,
    /// Stock servos have been given back: the bus is the client's.
    GivenBack,
    /// The servos run another firmware than before.
    FirmwareChanged,
    /// They run different firmwares; none is driven.
    Mixed([Firmware; JOINTS]),
    /// This joint's servo did not answer.
    Absent(usize, Missing),
    /// This joint's servo does not take what it must be set to.
    Unprepared(usize),
    /// A health poll has been answered.
    Health(Health),
    /// The client's request has been answered, or not: see [`BusSequencer::reply`].
    Client,
    /// An idle slot has been used.
    Served,
}

/// See the [module](self).
pub struct BusSequencer<S, D> {
    master: Master<S, D>,
    ids: [ServoId; JOINTS],
    state: State,
    leave: BusLeave,
    /// Stops that come before anything else.
    stops: StopPlan,
    /// Speeds at which servos may run since a client had the bus.
    client_speeds: Speeds,
    discovery: Discovery,
    setup: ServoSetup,
    health: HealthPoll,
    off: ForceOff,
    /// Whose request is on the bus.
    owner: Option<Owner>,
    /// The stop on the bus is one of the plan's.
    is_planned_stop: bool,
    /// Bytes of the servos are kept for the client.
    is_listening: bool,
    /// What the servos ran when they were found last.
    firmware: Option<Firmware>,
    /// When the next step of a search begins, in µs.
    next_us: u64,
    now_us: u64,
    /// The tick whose exchange was begun last.
    tick: u32,
}

impl<S, D> BusSequencer<S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// A sequencer for servos with these ids, joint by joint, that begins with the stop
    /// sequence.
    pub fn new(serial: S, direction: D, ids: [ServoId; JOINTS], now_us: u64) -> Self {
        Self {
            master: Master::new(serial, direction, ids),
            ids,
            state: State::Search(SearchStep::Stop),
            leave: BusLeave::Search,
            stops: StopPlan::default(),
            client_speeds: Speeds::new(),
            discovery: Discovery::default(),
            setup: ServoSetup::default(),
            health: HealthPoll::default(),
            off: ForceOff::default(),
            owner: None,
            is_planned_stop: false,
            is_listening: false,
            firmware: None,
            next_us: now_us,
            now_us,
            tick: 0,
        }
    }

    /// What the sequencer is at.
    pub(crate) fn state(&self) -> State {
        self.state
    }

    /// Whether there is one exchange a tick.
    pub fn is_ticking(&self) -> bool {
        matches!(self.state, State::ForceOff | State::Drive)
    }

    /// Whether nothing is under way on the bus.
    pub fn is_idle(&self) -> bool {
        self.master.is_idle()
    }

    /// What the servos run, as far as that is known.
    pub fn firmware(&self) -> Firmware {
        self.master.firmware()
    }

    /// Speed of the bus in bits per second.
    pub fn baud(&self) -> u32 {
        self.master.baud()
    }

    /// Whether torque can be given to the servos.
    pub fn is_prepared(&self) -> bool {
        self.master.is_prepared()
    }

    /// Shortest period in µs that the bus allows.
    pub fn least_period_us(&self) -> u32 {
        tick_us(self.firmware(), self.baud(), self.master.readiness())
    }

    /// Whether the last stop has come to an end: every motor has been seen to be off, or
    /// the host has been notified which has not.
    pub fn is_settled(&self) -> bool {
        self.off.is_settled()
    }

    /// The report for the host on motors that shall be off, when it changes.
    pub fn take_off_report(&mut self) -> Option<OffReport> {
        match self.state {
            State::ForceOff => self.off.take_report(self.now_us),
            State::Search(_) | State::Lent if self.off.is_reported() => {
                self.off.take_report(self.now_us)
            }
            State::Search(_) | State::Lent | State::Drive => None,
        }
    }

    /// The supervisor's leave from now on. What it takes away ends here.
    pub fn permit(&mut self, leave: BusLeave, now_us: u64) {
        self.now_us = now_us;
        self.leave = leave;
        if leave != BusLeave::Drive {
            self.master.cancel_drive();
        }
        match (self.state, leave) {
            (State::Lent, BusLeave::Lend)
            | (
                State::Search(_),
                BusLeave::Search | BusLeave::Off | BusLeave::Armed | BusLeave::Drive,
            )
            | (State::ForceOff, BusLeave::Off | BusLeave::Armed)
            | (State::Drive, BusLeave::Drive) => {}
            (State::Search(SearchStep::SetUp(step)), BusLeave::Lend) if step.is_restore() => {}
            (State::Drive, BusLeave::Off | BusLeave::Armed) => {
                self.state = State::ForceOff;
                self.off.begin(now_us, false);
            }
            (State::ForceOff, BusLeave::Drive) => self.state = State::Drive,
            (State::Search(_) | State::ForceOff | State::Drive, BusLeave::Lend) => {
                self.lend();
            }
            (State::Lent, _) => self.take_back(),
            (State::ForceOff | State::Drive, BusLeave::Search) => {
                self.off = ForceOff::default();
                self.search();
            }
        }
    }

    /// Every motor is to be off at once, by the stop sequence: after a fault, or when a
    /// stop is asked for again. The exchange under way ends first, within a tick; what it has
    /// not yet sent to the motors is off.
    pub fn force_off(&mut self, now_us: u64) {
        self.now_us = now_us;
        self.master.cancel_drive();
        if self.state == State::Lent {
            self.take_back();
        } else if self.state == State::Drive {
            self.state = State::ForceOff;
        }
        self.off.begin(now_us, true);
        self.plan_stops();
    }

    /// Stops at the speed in use; and, if a client has had the bus since motors were seen
    /// to be off, at each that it has used or may have set the servos to.
    fn plan_stops(&mut self) {
        let mut likely = Speeds::new();
        add_speed(&mut likely, self.baud());
        for baud in &self.client_speeds {
            add_speed(&mut likely, *baud);
        }
        let others: &[u32] = if self.client_speeds.is_empty() {
            &[]
        } else {
            &BAUD_RATES
        };
        self.stops = StopPlan::new(likely, others);
        self.off.note_stop(self.now_us);
    }

    fn search(&mut self) {
        self.discovery.rewind();
        self.state = State::Search(SearchStep::Stop);
        self.next_us = self.now_us;
        if !self.client_speeds.is_empty() {
            self.plan_stops();
        }
    }

    /// Makes stock servos ready for torque.
    pub fn prepare(&mut self) {
        self.set_up(SetupStep::PREPARE);
    }

    /// Gives stock servos back as they were found, then lends the bus.
    pub fn restore(&mut self) {
        self.plan_stops();
        self.set_up(SetupStep::RESTORE);
    }

    fn set_up(&mut self, step: SetupStep) {
        self.state = State::Search(SearchStep::SetUp(step));
        self.next_us = self.now_us;
    }

    /// When to poll again at the latest, with the next tick due then.
    pub fn wake_at_us(&self, tick_due_us: u64) -> u64 {
        if !self.master.is_idle() {
            return self.master.wake_at_us();
        }
        match self.state {
            State::ForceOff | State::Drive => tick_due_us,
            State::Search(_) | State::Lent => self.next_us,
        }
    }

    /// How many bytes on the bus make it worth to poll before that, if any.
    pub fn bytes_wanted(&self) -> Option<usize> {
        self.master.bytes_wanted()
    }

    /// What the last request was answered.
    pub fn reply(&self) -> Option<&Payload> {
        self.master.reply()
    }

    /// Whether stops come before anything else.
    pub fn is_stopping(&self) -> bool {
        !self.stops.is_done() || (self.is_planned_stop && !self.is_idle())
    }
}
