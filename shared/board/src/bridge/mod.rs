//! The application: core, bus and link combined.
//!
//! ```text
//!        LinkPort, PortEnd (thread)                          servo UART (interrupt)
//!              | commands, signals    records, notifications       | bytes
//!      +-------v------------------------------------^--+   +-------v--------+
//!      |                   Channels                    |   |  BusSequencer  |
//!      +-------+------------------------------------^--+   +---^-------+----+
//!              |                                    |          |permit,|samples
//!      +-------v------------------------------------+----------+command|-----+
//!      |                            Bridge                             v     |
//!      |       Core: Supervisor - permission;  ControlLoop - commands        |
//!      +---------------------------------------------------------------------+
//! ```
//!
//! One tick, at the running period:
//!
//! ```text
//! start   SYNC_WR(PWM decided last tick)  CYCLE -> positions   poll  -> Sampled
//!         ControlLoop::step -> PWM for next tick               decide
//!         record -> channels                                   publish
//! ```
//!
//! The PWM is sent at the start of the tick after the one that decided it, so
//! the delay from sample to torque is always one period, and the prediction
//! accounts for it.
//!
//! [`Bridge`] belongs in the highest-priority interrupt; [`LinkPort`] in thread
//! mode. They share [`Channels`] and nothing else. In each poll the bridge takes stops,
//! hellos and commands, passes the supervisor's permission to the sequencer, and then
//! advances the sequencer: no use of the bus outlasts its permission.
//!
//! | module               | content                                                 |
//! |----------------------|---------------------------------------------------------|
//! | `app_core`           | supervisor and control loop, without bus and queues     |
//! | [`command`]          | commands of the host, validated                         |
//! | `requests`           | requests of the host, in the tick                       |
//! | `bus_events`         | events of the bus, and actions of the core              |
//! | `servo_temperature`  | temperatures of the servos, and their limits            |
//! | `link_port`          | the board's end of the control link                     |
//! | [`transparent_port`] | the serial port for clients of the bus                  |
//! | [`supply_relay`]     | permission of the servos' supply                        |
//! | `channels`           | queues between tick and thread mode                     |
//! | `signals`            | signals of the host to the tick                         |

mod app_core;
mod bus_events;
mod channels;
pub mod command;
mod link_port;
mod queue;
mod requests;
mod servo_temperature;
mod signals;
pub mod supply_relay;
pub mod transparent_port;

pub use crate::tick::{can_run, limits, permits, settings_refusal};
use channels::Mailbox;
pub use channels::{BridgeEnd, Channels, LinkEnd, QueueWatch};
pub use link_port::LinkPort;

use armbridge_servo::bus::Bus;
use core::convert::Infallible;

use crate::sequencer::{BusSequencer, Dropouts, XRequirements};
use crate::supervisor::State;
use crate::tick::LoopConfig;
pub use app_core::MemoryRegion;
use app_core::{Core, TickSamples};
use armbridge_link::message::{Fault, Mode, Record, Refusal, Settings};
use armbridge_link::record::Violation;
use armbridge_servo::{JOINTS, ServoId, ServoIds};
use servo_temperature::Temperatures;
use supply_relay::{Supply, SupplyPermission};
use transparent_port::TransparentPort;

/// Servo ids, joint by joint: the first joint's servo is 1, the second's 2.
pub const SERVO_IDS: [ServoId; JOINTS] = match (ServoId::new(1), ServoId::new(2)) {
    (Some(first), Some(second)) => [first, second],
    _ => unreachable!(),
};

/// Step that [`Bridge::poll`] completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// This tick's samples are in: call [`Bridge::decide`], then
    /// [`Bridge::publish`].
    Sampled,
    /// A step of bring-up or of the stop sequence, or a check while the bus is lent;
    /// torque is off.
    Searching,
    /// An idle slot of a tick has been used.
    Served,
}

/// The application, as seen from the tick.
///
/// In memory it begins with what every poll uses: the processor reaches farther fields by more
/// instructions. Another order costs up to 70 in an armed millisecond.
#[repr(C)]
pub struct Bridge<'a, B> {
    /// Total time in µs by which the clock has gone back.
    set_back_us: u64,
    /// Samples of the last tick.
    sampled: TickSamples,
    sequencer: BusSequencer<B>,
    mailbox: Mailbox<'a>,
    port: TransparentPort<'a>,
    core: Core,
    temperatures: Temperatures,
    supply: Supply,
    /// Record of the last decided tick, with the number of dropped records.
    record: Record,
}

impl<'a, B: Bus> Bridge<'a, B> {
    /// A bridge that will begin with the stop sequence.
    ///
    /// # Errors
    /// A [`Refusal`] if no controller exists for the set-up; one does for the
    /// default.
    pub fn new(
        bus: B,
        end: BridgeEnd<'a>,
        now_us: u64,
        settings: &Settings,
    ) -> Result<Self, Refusal> {
        let config = LoopConfig::build(settings)?;
        let servos = ServoIds::from(SERVO_IDS).of_joints(config.joints());
        Ok(Self {
            core: Core::new(&config, now_us),
            sequencer: BusSequencer::new(bus, servos, XRequirements::of(&config), now_us),
            mailbox: end.mailbox,
            port: TransparentPort::new(end.client),
            supply: Supply::new(now_us),
            sampled: TickSamples::NONE,
            temperatures: Temperatures::default(),
            record: Record::NONE,
            set_back_us: 0,
        })
    }

    /// Advances the bus as far as it goes.
    ///
    /// # Errors
    /// `WouldBlock` when there is nothing to do before [`Bridge::wake_at_us`]
    /// or until the serial port has an event.
    pub fn poll(&mut self, now_us: u64) -> nb::Result<Progress, Infallible> {
        let now_us = self.monotonic_now(now_us);
        self.core.check_state();
        self.apply_core_actions();
        if self.mailbox.signals.has_news() {
            self.take_requests();
        }
        if !self.port.is_quiet() || self.core.state() == State::Passthrough {
            self.poll_port();
        }
        self.sequencer.permit(self.core.permission(), now_us);
        if let Some(event) = self.sequencer.poll(now_us) {
            let progress = self.take_bus_event(event);
            self.port.send_tapped(&mut self.sequencer);
            return Ok(progress);
        }
        self.port.send_tapped(&mut self.sequencer);
        let tick_due_us = self.core.next_start_us();
        if !self.sequencer.is_idle() {
            return Err(nb::Error::WouldBlock);
        }
        if self.sequencer.is_passthrough() {
            self.port.relay(&mut self.sequencer, now_us);
        } else if self.sequencer.is_ticking() {
            let is_due = now_us >= tick_due_us;
            let is_slot = !is_due || self.sequencer.is_check_due();
            if !(is_slot && self.use_idle_slot(tick_due_us)) {
                if is_due {
                    self.begin_tick();
                } else {
                    let (bus, samples) = (&mut self.sequencer, &self.sampled);
                    self.port.serve(bus, &self.core, samples, tick_due_us);
                }
            }
        }
        Err(nb::Error::WouldBlock)
    }

    /// Lets the client of the transparent port have or lose the bus. Not inlined: most polls find
    /// no client.
    #[inline(never)]
    fn poll_port(&mut self) {
        if let Some(event) = self.port.poll(&self.sequencer, &self.core) {
            // Never refused.
            let _ = self.apply(event);
        }
        self.port.report(self.core.now_us(), &mut self.mailbox);
    }

    /// Permission of the servos' supply, after each poll.
    pub fn supply(&mut self) -> SupplyPermission {
        let is_off = self.sequencer.is_off_confirmed();
        self.supply
            .update(self.core.now_us(), self.core.fault(), is_off)
    }

    /// Latest time of the next poll.
    pub fn wake_at_us(&self) -> u64 {
        let wake_us = self.sequencer.wake_at_us(self.core.next_start_us());
        let wake_us = if self.sequencer.is_idle() {
            wake_us.min(self.port.wake_at_us(self.core.config().limits()))
        } else {
            wake_us
        };
        wake_us.saturating_sub(self.set_back_us)
    }

    /// Monotonic time of the bridge: a clock that jumps back is a fault, and does not delay
    /// the stop.
    fn monotonic_now(&mut self, clock_us: u64) -> u64 {
        let now_us = clock_us.saturating_add(self.set_back_us);
        let back_us = self.core.now_us().saturating_sub(now_us);
        let now_us = now_us.max(self.core.now_us());
        self.core.set_time(now_us);
        if back_us > 0 {
            self.set_back_us += back_us;
            self.trip(Violation {
                value: back_us as f32 * 1e-6,
                ..Violation::plain(Fault::Clock)
            });
        }
        now_us
    }

    /// Number of received bytes that makes an earlier poll useful, if any.
    pub fn bytes_wanted(&self) -> Option<usize> {
        self.sequencer.bytes_wanted()
    }

    /// The bridge's mode.
    pub fn mode(&self) -> Mode {
        self.core.mode()
    }

    /// Number of the tick under way, as in its record.
    pub fn tick(&self) -> u32 {
        self.core.tick()
    }

    /// Turns a bit of the memory on which ticks depend, chosen by `draw`, for tests.
    pub fn inject_error(&mut self, region: MemoryRegion, draw: u32) {
        self.core.inject_error(region, draw);
    }

    // The tick

    /// Puts the decided command in force and keeps the schedule.
    fn begin_tick(&mut self) {
        let least_us = self.sequencer.least_period_us();
        // A waiting client gets the margin.
        let available_us = if self.port.is_waiting() {
            least_us
        } else {
            self.core.period_us(least_us)
        };
        let command = self.core.begin_tick(least_us);
        self.apply_core_actions();
        self.sequencer
            .permit(self.core.permission(), self.core.now_us());
        let (tick, dropouts) = (self.core.tick(), self.dropouts());
        self.sequencer
            .begin_tick(command, tick, &dropouts, available_us);
    }

    fn dropouts(&self) -> Dropouts {
        Dropouts {
            in_row: core::array::from_fn(|joint| self.core.lost_in_row(joint)),
            allowed: self.core.config().dropout_ticks(),
        }
    }

    fn use_idle_slot(&mut self, tick_due_us: u64) -> bool {
        let dropouts = self.dropouts();
        self.sequencer.use_idle_slot(tick_due_us, &dropouts)
    }

    /// Decides the tick. Measure its duration for [`Bridge::publish`].
    pub fn decide(&mut self) {
        self.core.decide(&self.sampled, &mut self.record);
        self.apply_core_actions();
    }

    /// Publishes the tick's record. True if the tick began in time and passed every state
    /// machine: feed the watchdog then.
    pub fn publish(&mut self, compute_ns: u32) -> bool {
        self.record.timing.compute_ns = compute_ns;
        if !self.mailbox.publish(&self.record) {
            self.record.dropped = self.record.dropped.wrapping_add(1);
        }
        self.core.may_feed_watchdog()
    }
}
