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

mod care;
mod check;
mod course;
mod experiment;
pub mod gateway;
mod guard;
mod halt;
mod integrity;
mod judge;
mod law;
pub mod limits;
mod link_port;
mod mailbox;
mod orders;
mod queue;
pub mod replay;
mod schedule;
mod settle;
pub mod supervisor;
mod tick;

pub use experiment::permits;
pub use law::{can_run, why_not};
pub use link_port::LinkPort;
pub use mailbox::{BridgeEnd, LinkEnd, Mailboxes, QueueWatch};

use crate::servo::port::SetBaud;
use core::convert::Infallible;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use crate::JOINTS;
use crate::actuator::Pwm;
use crate::link::message::{
    Drive, Fault, Guards, Missing, Mode, Record, Refusal, Sample, Settings, Timing, Trip,
};
use crate::servo::Firmware;
use crate::servo::master::Master;
use crate::servo::morpheus::ServoId;
use care::Care;
use course::Course;
use experiment::Run;
use gateway::Gateway;
use guard::{Guard, Violation};
use halt::Halting;
use integrity::Originals;
use law::{Decision, Law};
use nalgebra::Vector2;
use schedule::{Search, Stage};
use settle::Stock;
use supervisor::State;

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
    law: Law,
    course: Course,
    guard: Guard,
    originals: Originals,
    care: Care,
    state: State,
    /// What the motors are driven by in [`State::Running`] and [`State::Degraded`].
    drive: Drive,
    /// The cause of [`State::Fault`].
    trip: Option<Trip>,
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
    /// What [`Drive::Experiment`] does.
    run: Run,
    /// Constant torque of [`Drive::Torque`].
    torque_nm: [f32; JOINTS],
    in_force: Decision,
    next: Decision,
    next_start_us: u64,
    now_us: u64,
    /// By how much the clock has gone back so far.
    set_back_us: u64,
    heard_us: u64,
    /// The estimator has not seen a sample since it was last in doubt.
    is_fresh: bool,
    /// The tick that was decided last.
    decided: u32,
    overruns_in_row: u8,
    record: Record,
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
        let law = Law::build(&settings.setup)?;
        let guard = Guard::new(settings.limits, law.period_us().get() as u32);
        Ok(Self {
            originals: Originals::of(&law, &guard),
            guard,
            care: Care::default(),
            master: Master::new(serial, direction, SERVO_IDS),
            end,
            law,
            course: Course::hold(Vector2::zeros()),
            state: State::Boot,
            drive: Drive::Hold,
            trip: None,
            halting: None,
            stage: Stage::Stop,
            is_chore_asked: false,
            search: Search::default(),
            firmware: None,
            stock: [Stock::default(); JOINTS],
            gateway: Gateway::default(),
            stop_due: false,
            run: Run::default(),
            torque_nm: [0.0; JOINTS],
            in_force: Decision::off(),
            next: Decision::off(),
            next_start_us: now_us,
            now_us,
            set_back_us: 0,
            heard_us: now_us,
            is_fresh: true,
            decided: 0,
            overruns_in_row: 0,
            record: blank_record(),
        })
    }

    /// Advances the bus as far as it goes.
    ///
    /// # Errors
    /// `WouldBlock` when there is nothing to do before [`Bridge::wake_at_us`]
    /// or until the serial port has something to say.
    pub fn poll(&mut self, now_us: u64) -> nb::Result<Progress, Infallible> {
        let now_us = self.tell_time(now_us);
        self.take_orders();
        self.heed_client();
        let finished = self.master.poll(now_us);
        self.pass_overheard();
        if let Ok(outcome) = finished {
            return Ok(self.finish(&outcome));
        }
        if self.master.is_idle() {
            if now_us >= self.next_start_us {
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
            self.next_start_us.min(self.client_wake_us())
        } else {
            self.master.wake_at_us()
        };
        wake_us.saturating_sub(self.set_back_us)
    }

    /// The bridge's own time, which never goes back and never stands still: a clock
    /// that jumps back is a fault, and does not hold up the stop.
    fn tell_time(&mut self, clock_us: u64) -> u64 {
        let now_us = clock_us.saturating_add(self.set_back_us);
        let back_us = self.now_us.saturating_sub(now_us);
        self.now_us = now_us.max(self.now_us);
        if back_us > 0 {
            self.set_back_us += back_us;
            self.trip(Violation {
                value: back_us as f32 * 1e-6,
                ..Violation::plain(Fault::Clock)
            });
        }
        self.now_us
    }

    /// How many bytes on the bus make it worth to poll before that, if any.
    pub fn bytes_wanted(&self) -> Option<usize> {
        self.master.bytes_wanted()
    }

    /// What the bridge is doing.
    pub fn mode(&self) -> Mode {
        match self.state {
            State::Boot => Mode::Boot,
            State::Idle => Mode::Idle,
            State::Armed => Mode::Armed,
            State::Running => Mode::Running(self.drive),
            State::Degraded => Mode::Degraded(self.drive),
            State::Passthrough => Mode::Passthrough,
            // A fault without a cause is one of the memory.
            State::Fault => Mode::Fault(self.trip.map_or(Fault::Corrupted, |trip| trip.fault)),
        }
    }

    /// Number of the tick under way, as in its record.
    pub fn tick(&self) -> u32 {
        self.record.tick
    }
}

fn blank_record() -> Record {
    Record {
        tick: 0,
        start_us: 0,
        mode: Mode::Boot,
        guards: Guards::NONE,
        samples: [Sample::Missing(Missing::NotAsked); JOINTS],
        alarms: [0; JOINTS],
        pwm_in_force: [Pwm::OFF.counts(); JOINTS],
        pwm_next: [Pwm::OFF.counts(); JOINTS],
        reference_rad: [0.0; JOINTS],
        reference_speed_rad_s: [0.0; JOINTS],
        angle_rad: [0.0; JOINTS],
        speed_rad_s: [0.0; JOINTS],
        torque_nm: [0.0; JOINTS],
        disturbance_nm: [0.0; JOINTS],
        timing: Timing::default(),
        dropped: 0,
    }
}
