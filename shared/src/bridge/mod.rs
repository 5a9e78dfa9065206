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
//! [`Bridge`] belongs in the highest-priority interrupt; [`LinkPort`] in thread
//! mode. They share [`Mailboxes`] and nothing else.

mod course;
pub mod gateway;
mod guard;
mod judge;
mod law;
pub mod limits;
mod link_port;
mod mailbox;
mod orders;
mod schedule;
mod settle;
pub mod supervisor;

pub use link_port::LinkPort;
pub use mailbox::{BridgeEnd, LinkEnd, Mailboxes};

use crate::servo::port::SetBaud;
use core::convert::Infallible;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use crate::JOINTS;
use crate::actuator::Pwm;
use crate::link::message::{Fault, Missing, Mode, Record, Refusal, Sample, Setup, Timing};
use crate::servo::master::Master;
use crate::servo::morpheus::ServoId;
use course::Course;
use gateway::Gateway;
use law::{Decision, Law};
use nalgebra::Vector2;
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
    law: Law,
    course: Course,
    mode: Mode,
    stage: Stage,
    /// What is asked of the bus is the chore at hand, not a client's question.
    is_chore_asked: bool,
    search: Search,
    stock: [Stock; JOINTS],
    gateway: Gateway,
    /// The stop sequence is owed to a fault.
    stop_due: bool,
    /// Constant torque of [`Mode::Torque`].
    torque_nm: [f32; JOINTS],
    in_force: Decision,
    next: Decision,
    next_start_us: u64,
    now_us: u64,
    heard_us: u64,
    /// The estimator has not seen a sample since it was last in doubt.
    is_fresh: bool,
    lost_in_row: [u8; JOINTS],
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
    /// [`Refusal::NoGains`] if no controller exists for the default set-up.
    pub fn new(serial: S, direction: D, end: BridgeEnd<'a>, now_us: u64) -> Result<Self, Refusal> {
        let mode = Mode::BringUp;
        Ok(Self {
            master: Master::new(serial, direction, SERVO_IDS),
            end,
            law: Law::build(&Setup::default())?,
            course: Course::hold(Vector2::zeros()),
            mode,
            stage: Stage::Stop,
            is_chore_asked: false,
            search: Search::default(),
            stock: [Stock::default(); JOINTS],
            gateway: Gateway::default(),
            stop_due: false,
            torque_nm: [0.0; JOINTS],
            in_force: Decision::off(),
            next: Decision::off(),
            next_start_us: now_us,
            now_us,
            heard_us: now_us,
            is_fresh: true,
            lost_in_row: [0; JOINTS],
            overruns_in_row: 0,
            record: blank_record(mode),
        })
    }

    /// Advances the bus as far as it goes.
    ///
    /// # Errors
    /// `WouldBlock` when there is nothing to do before [`Bridge::wake_at_us`]
    /// or until the serial port has something to say.
    pub fn poll(&mut self, now_us: u64) -> nb::Result<Progress, Infallible> {
        self.now_us = now_us;
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
            } else {
                self.serve_client();
            }
        }
        Err(nb::Error::WouldBlock)
    }

    /// When to poll again at the latest.
    pub fn wake_at_us(&self) -> u64 {
        if self.master.is_idle() {
            self.next_start_us.min(self.client_wake_us())
        } else {
            self.master.wake_at_us()
        }
    }

    /// How many bytes on the bus make it worth to poll before that, if any.
    pub fn bytes_wanted(&self) -> Option<usize> {
        self.master.bytes_wanted()
    }

    /// What the bridge is doing.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Estimates, controls and supervises: everything that is decided in a
    /// tick. Bracket it with a stopwatch for [`Bridge::publish`].
    pub fn decide(&mut self) {
        self.supervise();
        let measured = self.law.angles(self.record.samples.map(Sample::counts));
        self.count_lost(&measured);
        if let ([Some(a), Some(b)], true) = (measured, self.is_fresh) {
            self.law.reset([a, b]);
            self.is_fresh = false;
        }
        let state = self.law.correct(measured);
        self.check(&state);
        // What is decided now acts from the next samples on.
        let ahead = self.law.advance(&self.in_force);
        let reference = self.course.at(self.next_start_us);
        let decided = match self.mode {
            Mode::BringUp | Mode::Idle | Mode::Passthrough | Mode::Fault(_) => {
                Some(Decision::off())
            }
            Mode::Torque => self.law.constant(self.torque_nm),
            Mode::Regulate | Mode::Track => self.law.follow(&ahead, &reference),
        };
        self.next = decided.unwrap_or_else(|| {
            self.trip(Fault::NotFinite);
            Decision::off()
        });
        let record = &mut self.record;
        record.mode = self.mode;
        record.pwm_next = self.next.pwm.map(Pwm::counts);
        record.reference_rad = reference.q.into();
        record.reference_speed_rad_s = reference.dq.into();
        record.angle_rad = state.q.into();
        record.speed_rad_s = state.dq.into();
        record.torque_nm = self.next.torque_nm.into();
        record.disturbance_nm = self.law.disturbance_nm();
    }

    /// Publishes the tick's record. True if the tick began and ended in time:
    /// feed the watchdog then.
    pub fn publish(&mut self, compute_ns: u32) -> bool {
        self.record.timing.compute_ns = compute_ns;
        if self.end.records.enqueue(self.record).is_err() {
            self.record.dropped = self.record.dropped.wrapping_add(1);
        }
        self.overruns_in_row == 0
    }
}

fn blank_record(mode: Mode) -> Record {
    Record {
        tick: 0,
        start_us: 0,
        mode,
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
