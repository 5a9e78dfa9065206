//! The application: bring-up, the tick, safety, telemetry.
//!
//! One tick, at the running period:
//!
//! ```text
//! start   SYNC_WR(PWM decided last tick)  CYCLE -> positions   poll  -> Sampled
//!         estimate -> predict -> control -> PWM for next tick  decide
//!         record -> mailbox                                    publish
//! ```
//!
//! The PWM goes out at the start of the tick after the one that decided it, so
//! the delay from sample to torque is one period, always, and the prediction
//! accounts for it.
//!
//! | module         | what                                                    |
//! |----------------|---------------------------------------------------------|
//! | [`supervisor`] | states, events, and what follows from them: a table     |
//! | `judge`        | what is in doubt, and the way to torque off             |
//! | `guard`        | limits, tick by tick; the brake before the angle limit  |
//! | `integrity`    | whether the numbers in memory are those that were set   |
//! | `halt`         | the stop sequence until the servos stand                |
//! | `care`         | temperatures, and pings of servos that fall silent      |
//! | `schedule`     | what the bus is used for, and when                      |
//! | `settle`       | stock servos made ready, and given back                 |
//! | `tick`, `law`, `course` | what a tick decides; set-ups; references       |
//! | `experiment`   | experiments, from the permission to the end             |
//! | `orders`, `check` | what the host wants, and whether it may              |
//! | [`gateway`]    | the transparent port                                    |
//! | [`limits`]     | numbers that nobody can set                             |
//! | [`replay`]     | the same ticks again, from what was recorded            |
//!
//! [`Bridge`] belongs in the highest-priority interrupt; [`LinkPort`] in thread
//! mode. They share [`Mailboxes`] and nothing else.

pub mod app_core;
mod care;
pub mod command;
pub mod gateway;
mod halt;
mod judge;
mod link_port;
mod mailbox;
mod orders;
mod queue;
mod schedule;
mod settle;
mod tick;

pub use crate::control_loop::limits;
pub use crate::control_loop::{can_run, permits, why_not};
pub use link_port::LinkPort;
pub use mailbox::{BridgeEnd, LinkEnd, Mailboxes};

use crate::servo::port::SetBaud;
use core::convert::Infallible;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use crate::JOINTS;
use crate::control_loop::{LoopConfig, Violation};
use crate::link::message::{Fault, Missing, Mode, Refusal, Sample, Settings};
use crate::servo::Firmware;
use crate::servo::master::Master;
use crate::servo::morpheus::ServoId;
use crate::servo::protocol1::Alarms;
use app_core::Core;
use care::Care;
use gateway::Gateway;
use halt::Halting;
use schedule::{Search, Stage};
use settle::Stock;

/// Servo ids, joint by joint: the first joint's servo is 1, the second's 2.
pub const SERVO_IDS: [ServoId; JOINTS] = match (ServoId::new(1), ServoId::new(2)) {
    (Some(first), Some(second)) => [first, second],
    _ => unreachable!(),
};

/// What [`Bridge::poll`] brought to an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// This tick's samples are in: call [`Bridge::decide`], then
    /// [`Bridge::publish`].
    Sampled,
    /// A step of bring-up or of the stop sequence, or a look at a bus that is
    /// somebody else's; torque is off.
    Searching,
    /// A client's question in the slack of a tick.
    Served,
}

/// The application, as seen from the tick.
pub struct Bridge<'a, S, D> {
    master: Master<S, D>,
    end: BridgeEnd<'a>,
    core: Core,
    care: Care,
    /// The watch over servos that were told to stop.
    halting: Option<Halting>,
    stage: Stage,
    /// What is asked of the bus is the chore at hand, not a client's question.
    is_chore_asked: bool,
    search: Search,
    /// What the servos ran when they were found last.
    firmware: Option<Firmware>,
    stock: [Stock; JOINTS],
    gateway: Gateway,
    /// The stop sequence is owed to a fault.
    stop_due: bool,
    /// What the last tick brought.
    samples: [Sample; JOINTS],
    alarms: [Alarms; JOINTS],
    bus_us: u32,
    /// Records that found no room.
    dropped: u32,
    /// By how much the clock has gone back so far.
    set_back_us: u64,
}

impl<'a, S, D> Bridge<'a, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// A bridge that will begin with the stop sequence.
    ///
    /// # Errors
    /// A [`Refusal`] if no controller exists for the set-up; one does for the
    /// default.
    pub fn new(
        serial: S,
        direction: D,
        end: BridgeEnd<'a>,
        now_us: u64,
        settings: &Settings,
    ) -> Result<Self, Refusal> {
        Ok(Self {
            core: Core::new(LoopConfig::build(settings)?, now_us),
            care: Care::default(),
            master: Master::new(serial, direction, SERVO_IDS),
            end,
            halting: None,
            stage: Stage::Stop,
            is_chore_asked: false,
            search: Search::default(),
            firmware: None,
            stock: [Stock::default(); JOINTS],
            gateway: Gateway::default(),
            stop_due: false,
            samples: [Sample::Missing(Missing::NotAsked); JOINTS],
            alarms: [Alarms::NONE; JOINTS],
            bus_us: 0,
            dropped: 0,
            set_back_us: 0,
        })
    }

    /// Advances the bus as far as it goes.
    ///
    /// # Errors
    /// `WouldBlock` when there is nothing to do before [`Bridge::wake_at_us`]
    /// or until the serial port has something to say.
    pub fn poll(&mut self, now_us: u64) -> nb::Result<Progress, Infallible> {
        let now_us = self.monotonic_now(now_us);
        self.take_orders();
        self.heed_client();
        let finished = self.master.poll(now_us);
        self.pass_overheard();
        if let Ok(outcome) = finished {
            return Ok(self.finish(&outcome));
        }
        if self.master.is_idle() {
            if now_us >= self.core.next_start_us() {
                self.begin_next();
                let _ = self.master.poll(now_us);
                if self.stage == Stage::Released {
                    return Ok(Progress::Searching);
                }
            } else if !self.take_care() {
                self.serve_client();
            }
        }
        Err(nb::Error::WouldBlock)
    }

    /// When to poll again at the latest.
    pub fn wake_at_us(&self) -> u64 {
        let wake_us = if self.master.is_idle() {
            self.core.next_start_us().min(self.client_wake_us())
        } else {
            self.master.wake_at_us()
        };
        wake_us.saturating_sub(self.set_back_us)
    }

    /// The bridge's own time, which never goes back and never stands still: a clock
    /// that jumps back is a fault, and does not hold up the stop.
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

    /// How many bytes on the bus make it worth to poll before that, if any.
    pub fn bytes_wanted(&self) -> Option<usize> {
        self.master.bytes_wanted()
    }

    /// What the bridge is doing.
    pub fn mode(&self) -> Mode {
        self.core.mode()
    }

    /// Number of the tick under way, as in its record.
    pub fn tick(&self) -> u32 {
        self.core.tick()
    }

    /// Turns a bit of a number that the tick computes with, which one by `draw`: to
    /// see what becomes of it.
    pub fn corrupt(&mut self, draw: u32) {
        self.core.inject_error(draw);
    }
}
