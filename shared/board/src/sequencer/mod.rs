//! The bus sequencer: use of the servo bus, and who may use it.
//!
//! The sequencer is in exactly one of four states:
//!
//! ```text
//!             lined up                  drive permitted
//!  Search ---------------> ForceOff <------------------> Drive
//!    ^ ^                    |  ^  |     drive withdrawn    |
//!    | +--- search ---------+  |  |                        |
//!    |                         |  | client permitted       | client permitted
//!    |    client withdrawn     |  v                        |
//!    +-------------------------+ Passthrough <-------------+
//! ```
//!
//! | state         | the bus carries                                                |
//! |---------------|----------------------------------------------------------------|
//! | `Search`      | stops, pings and settings, until the servos are lined up       |
//! | `ForceOff`    | one exchange a tick that commands every motor off, stop sequences and read-backs until each is confirmed off |
//! | `Drive`       | one exchange a tick with the control loop's command            |
//! | `Passthrough` | a client's packets, unchanged                                  |
//!
//! # Permission to drive
//!
//! [`BusSequencer::permit`] sets the supervisor's permission before each step.
//! Without permission to drive no exchange carries a torque, and without permission for
//! the client none of its bytes is relayed, whatever was requested before: `ForceOff` is the state
//! that the sequencer enters by itself. From `Passthrough` a transition leads through a stop at every speed
//! that the client used and through `Search`, because the client's changes are not known.
//!
//! # Idle slots
//!
//! Between two ticks the bus is idle. One arbiter assigns that time to one
//! `IdleRequest` at a time: to read-backs first, then to health polls, then to a
//! client. Each is registered with its owner and the reply that it expects, and a reply
//! goes to its owner and to no other.
//!
//! # Timing
//!
//! Call [`poll`](BusSequencer::poll) after every event on the bus, and at
//! [`wake_at_us`](BusSequencer::wake_at_us) at the latest; it never waits. Stop sequences
//! last 7 ms at 1 Mbaud, so with motors off ticks may begin late. A tick with motors
//! driven begins late, by some 100 µs, only for a health poll that is overdue.
//!
//! | module         | content                                                    |
//! |----------------|------------------------------------------------------------|
//! | `force_off`    | evidence that motors are off                               |
//! | `stop_plan`    | stops at several speeds                                    |
//! | `discovery`    | search for the servos, their firmware and speed            |
//! | `servo_setup`  | stock and X servos made ready, and restored                |
//! | `servo_settings` | their settings: registers, and those of a ready servo    |
//! | `health_poll`  | temperatures, torque enable, pings of silent servos        |
//! | `exchange`     | the exchange of a tick                                     |
//! | `idle_request` | a query for that time, and its owner                       |
//! | `idle_slot`    | the arbiter of the time between two exchanges              |
//! | `passthrough`  | a client's packets, relayed unchanged                      |
//! | `time_budget`  | requests that fit into that time                           |
//! | `state`        | states, permissions and events                             |
//! | `steps`        | begin, end and order of the transactions                   |

mod discovery;
mod dropouts;
mod exchange;
mod force_off;
mod health_poll;
mod idle_request;
mod idle_slot;
mod passthrough;
mod servo_settings;
mod servo_setup;
mod setup_step;
mod state;
mod steps;
mod stop_plan;
mod time_budget;

pub use dropouts::Dropouts;
pub use health_poll::Health;
pub(crate) use servo_settings::XRequirements;
pub use state::BusEvent;
pub(crate) use state::{SearchStep, State};
pub use time_budget::TimeBudget;

use armbridge_link::message::OffReport;
use armbridge_link::record::Permission;
use armbridge_servo::bus::Bus;
use armbridge_servo::master::{Master, Payload};
use armbridge_servo::port::{BAUD_RATES, baud_rates_to};
use armbridge_servo::{Firmware, ServoIds};
use discovery::Discovery;
use force_off::ForceOff;
use health_poll::HealthPoll;
use idle_request::Owner;
use servo_setup::ServoSetup;
use setup_step::SetupStep;
use stop_plan::{Speeds, StopPlan, add_speed};

/// See the [module](self).
pub struct BusSequencer<B> {
    master: Master<B>,
    ids: ServoIds,
    state: State,
    permission: Permission,
    /// Stops that precede every other packet.
    stops: StopPlan,
    /// Speeds at which servos may run since a client had the bus.
    client_speeds: Speeds,
    discovery: Discovery,
    setup: ServoSetup,
    health: HealthPoll,
    off: ForceOff,
    /// Owner of the request on the bus.
    owner: Option<Owner>,
    /// Whether the stop on the bus is one of the plan's.
    is_planned_stop: bool,
    /// Whether bytes of the servos are tapped for the client.
    is_tapping: bool,
    /// Firmware and speed of the servos when they were found last.
    firmware: Option<Firmware>,
    found_baud: u32,
    /// Start of the next step of a search, in µs.
    next_us: u64,
    now_us: u64,
    /// The tick whose exchange was begun last.
    tick: u32,
}

impl<B: Bus> BusSequencer<B> {
    /// A sequencer for servos with these ids, joint by joint, that begins with the stop sequence.
    pub(crate) fn new(bus: B, ids: ServoIds, required: XRequirements, now_us: u64) -> Self {
        Self {
            master: Master::new(bus, ids),
            ids,
            state: State::Search(SearchStep::Stop),
            permission: Permission::Search,
            stops: StopPlan::default(),
            client_speeds: Speeds::new(),
            discovery: Discovery::new(baud_rates_to(B::BAUD_MAX), ids.len()),
            setup: ServoSetup::new(required),
            health: HealthPoll::default(),
            off: ForceOff::new(ids.len()),
            owner: None,
            is_planned_stop: false,
            is_tapping: false,
            firmware: None,
            found_baud: BAUD_RATES[0],
            next_us: now_us,
            now_us,
            tick: 0,
        }
    }

    /// State of the sequencer.
    pub(crate) fn state(&self) -> State {
        self.state
    }

    /// Whether each tick has an exchange.
    pub fn is_ticking(&self) -> bool {
        matches!(self.state, State::ForceOff | State::Drive)
    }

    /// The servos under control.
    pub fn servos(&self) -> ServoIds {
        self.ids
    }

    /// Whether no transaction is under way.
    pub fn is_idle(&self) -> bool {
        self.master.is_idle()
    }

    /// Firmware of the servos, as far as it is known.
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
        self.master.least_period_us()
    }

    /// Whether the last stop has concluded: every motor is confirmed off, or the host has
    /// been notified which is not.
    pub fn is_settled(&self) -> bool {
        self.off.is_settled()
    }

    /// Whether the servo of this joint has been silent for some ticks, since motors have been forced off.
    pub fn is_out_of_reach(&self, joint: usize) -> bool {
        self.off.is_out_of_reach(joint)
    }

    /// Whether every motor is confirmed off, and has answered since.
    pub fn is_off_confirmed(&self) -> bool {
        self.off.is_off()
    }

    /// Takes the report for the host on motors that must be off, when it changes.
    pub fn take_off_report(&mut self) -> Option<OffReport> {
        match self.state {
            State::ForceOff => self.off.take_report(self.now_us),
            State::Search(_) | State::Passthrough if self.off.is_reported() => {
                self.off.take_report(self.now_us)
            }
            State::Search(_) | State::Passthrough | State::Drive => None,
        }
    }

    /// The last report, for a host that joins after it.
    pub fn last_off_report(&self) -> Option<OffReport> {
        self.off.last_report()
    }

    /// Sets the supervisor's permission. A use of the bus that it withdraws ends here.
    pub fn permit(&mut self, permission: Permission, now_us: u64) {
        self.now_us = now_us;
        self.permission = permission;
        if !permission.drives_motors() {
            self.master.cancel_drive();
        } else if self.state == State::Drive {
            // The case of nearly every call while motors are driven.
            return;
        }
        match (self.state, permission) {
            (State::Passthrough, Permission::Passthrough)
            | (
                State::Search(_),
                Permission::Search
                | Permission::Off
                | Permission::Armed
                | Permission::MotorCheck
                | Permission::Drive
                | Permission::Park,
            )
            | (State::ForceOff, Permission::Off | Permission::Armed)
            | (State::Drive, Permission::MotorCheck | Permission::Drive | Permission::Park) => {}
            (State::Search(SearchStep::SetUp(step)), Permission::Passthrough)
                if step.is_restore() => {}
            (State::Drive, Permission::Off | Permission::Armed) => {
                self.state = State::ForceOff;
                self.off.begin(now_us, false);
            }
            (State::ForceOff, Permission::MotorCheck | Permission::Drive | Permission::Park) => {
                self.state = State::Drive;
            }
            (State::Search(_) | State::ForceOff | State::Drive, Permission::Passthrough) => {
                self.begin_passthrough();
            }
            (State::Passthrough, _) => self.end_passthrough(),
            (State::ForceOff | State::Drive, Permission::Search) => {
                self.off = ForceOff::new(self.ids.len());
                self.search();
            }
        }
    }

    /// Forces every motor off at once by the stop sequence: after a fault, or when a
    /// stop is repeated. The exchange under way ends first, within a tick; a command that it
    /// has not yet sent is replaced by off.
    pub fn force_off(&mut self, now_us: u64) {
        self.now_us = now_us;
        self.master.cancel_drive();
        if self.state == State::Passthrough {
            self.end_passthrough();
        } else if self.state == State::Drive {
            self.state = State::ForceOff;
        }
        self.off.begin(now_us, true);
        self.plan_stops();
    }

    /// Repeats the order that motors are off, where they have to be: the ticks give it again,
    /// and read back what they have done.
    pub fn repeat_off(&mut self) {
        if self.state == State::ForceOff {
            self.off.repeat();
        }
    }

    /// Plans stops at the speed in use; and, if a client has had the bus since motors were
    /// confirmed off, at each speed that it has used or may have set the servos to.
    fn plan_stops(&mut self) {
        let mut likely = Speeds::new();
        add_speed(&mut likely, self.baud());
        for baud in &self.client_speeds {
            add_speed(&mut likely, *baud);
        }
        let others: &[u32] = if self.client_speeds.is_empty() {
            &[]
        } else {
            baud_rates_to(B::BAUD_MAX)
        };
        self.stops = StopPlan::new(likely, others);
    }

    /// Searches for other servos from now on.
    pub(crate) fn set_servos(&mut self, ids: ServoIds) {
        self.ids = ids;
        self.off = ForceOff::new(ids.len());
        if self.state != State::Passthrough {
            self.search();
        }
    }

    /// Begins a search.
    fn search(&mut self) {
        self.discovery = Discovery::new(baud_rates_to(B::BAUD_MAX), self.ids.len());
        self.state = State::Search(SearchStep::Stop);
        self.next_us = self.now_us;
        if !self.client_speeds.is_empty() {
            self.plan_stops();
        }
    }

    /// Sets what X servos have to be. Whether they have to be made ready again.
    pub(crate) fn require(&mut self, required: XRequirements) -> bool {
        let is_other = self.setup.require(required);
        is_other && self.is_prepared() && self.firmware() == Firmware::XSeries
    }

    /// Makes stock and X servos ready for torque.
    pub fn prepare(&mut self) {
        self.set_up(SetupStep::PREPARE);
    }

    /// Restores stock servos to the settings found, then lends the bus.
    pub fn restore(&mut self) {
        self.plan_stops();
        self.set_up(SetupStep::RESTORE);
    }

    fn set_up(&mut self, step: SetupStep) {
        self.state = State::Search(SearchStep::SetUp(step));
        self.next_us = self.now_us;
    }

    /// Latest time of the next poll, with the next tick due at `tick_due_us`.
    pub fn wake_at_us(&self, tick_due_us: u64) -> u64 {
        if !self.master.is_idle() {
            return self.master.wake_at_us();
        }
        match self.state {
            State::ForceOff | State::Drive => tick_due_us,
            State::Search(_) | State::Passthrough => self.next_us,
        }
    }

    /// Number of received bytes that makes an earlier poll useful, if any.
    pub fn bytes_wanted(&self) -> Option<usize> {
        self.master.bytes_wanted()
    }

    /// Reply to the last request.
    pub fn reply(&self) -> Option<&Payload> {
        self.master.reply()
    }

    /// Whether a check of the motors goes before a tick that is due: with motors off a late
    /// tick does no harm, and on a slow bus ticks may leave no idle slot.
    pub fn is_check_due(&self) -> bool {
        let is_off = self.state == State::ForceOff && self.permission == Permission::Off;
        is_off && self.off.next_check(self.now_us).is_some()
    }

    /// Whether planned stops are under way or to be sent.
    pub fn is_stopping(&self) -> bool {
        !self.stops.is_done() || (self.is_planned_stop && !self.is_idle())
    }
}
