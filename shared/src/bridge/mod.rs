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

mod law;
pub mod limits;
mod link_port;
mod mailbox;
pub mod supervisor;

pub use link_port::LinkPort;
pub use mailbox::{BridgeEnd, LinkEnd, Mailboxes};

use core::convert::Infallible;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};
use nalgebra::Vector2;

use crate::JOINTS;
use crate::actuator::Pwm;
use crate::arm::State;
use crate::link::message::{Fault, Missing, Mode, Record, Refusal, Sample, Setup, Timing};
use crate::servo::master::{Master, Outcome, Transaction};
use crate::servo::morpheus::ServoId;
use law::{Decision, Law};
use mailbox::{Notice, Order, Task};
use supervisor::{Event, Request, torque_is_on};

/// Servo ids, joint by joint: the first joint's servo is 1, the second's 2.
pub const SERVO_IDS: [ServoId; JOINTS] = match (ServoId::new(1), ServoId::new(2)) {
    (Some(first), Some(second)) => [first, second],
    _ => unreachable!(),
};

/// Rest between two attempts to find the servos.
const SEARCH_PAUSE_US: u64 = 50_000;

/// What [`Bridge::poll`] brought to an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// This tick's samples are in: call [`Bridge::decide`], then
    /// [`Bridge::publish`].
    Sampled,
    /// A step of bring-up or of the stop sequence; torque is off.
    Searching,
}

/// What the bus is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The stop sequence, then bring-up.
    Stop,
    /// Is this joint's servo there?
    Ping(usize),
    /// Lining the servos up.
    Start,
    /// One exchange a tick.
    Ticking,
}

/// The application, as seen from the tick.
pub struct Bridge<'a, S, D> {
    master: Master<S, D>,
    end: BridgeEnd<'a>,
    law: Law,
    mode: Mode,
    stage: Stage,
    /// The stop sequence is owed to a fault.
    stop_due: bool,
    /// Constant torque of [`Mode::Torque`].
    torque_nm: [f32; JOINTS],
    /// Torque that acted until this tick's samples were taken.
    acted_nm: Vector2<f32>,
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
    S: Read<u8> + Write<u8>,
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
            mode,
            stage: Stage::Stop,
            stop_due: false,
            torque_nm: [0.0; JOINTS],
            acted_nm: Vector2::zeros(),
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
        if let Ok(outcome) = self.master.poll(now_us) {
            return Ok(self.finish(&outcome));
        }
        if self.master.is_idle() && now_us >= self.next_start_us {
            let transaction = self.next_transaction();
            // Idle was just seen: it is not busy.
            let _ = self.master.begin(transaction, now_us);
            let _ = self.master.poll(now_us);
        }
        Err(nb::Error::WouldBlock)
    }

    /// When to poll again at the latest.
    pub fn wake_at_us(&self) -> u64 {
        if self.master.is_idle() {
            self.next_start_us
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
        let state = self.law.update(measured, self.acted_nm);
        self.check(&state);
        let decided = match self.mode {
            Mode::BringUp | Mode::Idle | Mode::Fault(_) => Some(Decision::off()),
            Mode::Torque => self.law.constant(self.torque_nm),
            Mode::Regulate => self.law.regulate(self.in_force.torque_nm),
        };
        self.next = decided.unwrap_or_else(|| {
            self.trip(Fault::NotFinite);
            Decision::off()
        });
        let record = &mut self.record;
        record.mode = self.mode;
        record.pwm_next = self.next.pwm.map(Pwm::counts);
        record.reference_rad = self.law.reference_rad();
        record.angle_rad = state.q.into();
        record.speed_rad_s = state.dq.into();
        record.torque_nm = self.next.torque_nm.into();
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

    // --- the bus -----------------------------------------------------------

    /// What the bus is used for next. A pause between attempts is over when
    /// this is called.
    fn next_transaction(&mut self) -> Transaction {
        if core::mem::take(&mut self.stop_due) {
            return Transaction::Stop;
        }
        match self.stage {
            Stage::Stop => Transaction::Stop,
            Stage::Ping(joint) => Transaction::Ping { joint },
            Stage::Start => Transaction::Start,
            Stage::Ticking => {
                self.begin_tick();
                Transaction::Drive(self.in_force.pwm)
            }
        }
    }

    /// A transaction is over: what does it mean?
    fn finish(&mut self, outcome: &Outcome) -> Progress {
        match (outcome.transaction, self.stage) {
            (Transaction::Drive(_), _) => {
                self.record.samples = outcome.samples;
                self.record.timing.bus_us = outcome.bus_us;
                return Progress::Sampled;
            }
            (Transaction::Stop, Stage::Stop) => self.stage = Stage::Ping(0),
            // A fault's stop: ticks go on with torque off, from now.
            (Transaction::Stop, _) => self.next_start_us = self.now_us,
            (Transaction::Ping { joint }, _) => match outcome.samples.get(joint) {
                Some(Sample::Missing(missing)) => self.report_absent(joint, *missing),
                Some(Sample::Counts(_)) if joint + 1 < JOINTS => {
                    self.stage = Stage::Ping(joint + 1);
                }
                _ => self.stage = Stage::Start,
            },
            (Transaction::Start, _) => match first_missing(outcome.samples) {
                Some((joint, missing)) => self.report_absent(joint, missing),
                None => self.begin_ticking(),
            },
        }
        Progress::Searching
    }

    fn report_absent(&mut self, joint: usize, missing: Missing) {
        // A full queue means that the host knows already.
        let _ = self
            .end
            .notices
            .enqueue(Notice::Absent(joint as u8, missing));
        self.stage = Stage::Ping(0);
        self.next_start_us = self.now_us + SEARCH_PAUSE_US;
    }

    fn begin_ticking(&mut self) {
        self.stage = Stage::Ticking;
        self.next_start_us = self.now_us;
        self.lost_in_row = [0; JOINTS];
        self.overruns_in_row = 0;
        self.is_fresh = true;
        // Never refused.
        let _ = self.apply(Event::BusReady);
    }

    /// Puts the decided PWM in force and keeps the schedule.
    fn begin_tick(&mut self) {
        let period_us = u64::from(self.law.period_us());
        let late_us = self.now_us.saturating_sub(self.next_start_us);
        let missed = late_us / period_us;
        self.next_start_us += (missed + 1) * period_us;
        if missed > 0 && torque_is_on(self.mode) {
            self.overruns_in_row = self.overruns_in_row.saturating_add(1);
            if self.overruns_in_row >= limits::OVERRUNS {
                self.trip(Fault::Overrun);
            }
        } else {
            self.overruns_in_row = 0;
        }
        if !torque_is_on(self.mode) {
            self.next = Decision::off();
        }
        self.acted_nm = self.in_force.torque_nm;
        self.in_force = self.next;
        let record = &mut self.record;
        record.tick = record.tick.wrapping_add(1);
        record.start_us = self.now_us;
        record.pwm_in_force = self.in_force.pwm.map(Pwm::counts);
        record.timing = Timing {
            start_error_us: late_us as u32,
            missed: record.timing.missed.wrapping_add(missed as u32),
            ..Timing::default()
        };
    }

    // --- what happened -----------------------------------------------------

    fn count_lost(&mut self, measured: &[Option<f32>; JOINTS]) {
        for (lost, angle) in self.lost_in_row.iter_mut().zip(measured) {
            *lost = if angle.is_some() {
                0
            } else {
                lost.saturating_add(1)
            };
        }
        if self
            .lost_in_row
            .iter()
            .any(|lost| *lost >= limits::LOST_SAMPLES)
        {
            self.trip(Fault::SamplesLost);
        }
    }

    fn supervise(&mut self) {
        let silent_us = self.now_us.saturating_sub(self.heard_us);
        if torque_is_on(self.mode) && silent_us > limits::HOST_SILENCE_US {
            self.trip(Fault::HostSilent);
        }
    }

    /// Judges the state while torque is on.
    fn check(&mut self, state: &State<f32>) {
        if !torque_is_on(self.mode) {
            return;
        }
        let is_finite = state.q.iter().chain(&state.dq).all(|x| x.is_finite());
        if !is_finite {
            self.trip(Fault::NotFinite);
        } else if state.q.iter().any(|q| q.abs() > limits::ANGLE_MAX_RAD) {
            self.trip(Fault::AngleLimit);
        }
    }

    /// Torque off, latched. The stop sequence follows at once on the bus.
    fn trip(&mut self, fault: Fault) {
        // Never refused.
        let _ = self.apply(Event::Tripped(fault));
    }

    /// Changes the mode as the supervisor has it.
    fn apply(&mut self, event: Event) -> Result<(), Refusal> {
        let before = self.mode;
        self.mode = supervisor::next(before, event)?;
        if self.mode == before {
            return Ok(());
        }
        match self.mode {
            Mode::Fault(_) => {
                self.next = Decision::off();
                self.stop_due = true;
                // The stop does not wait for the next tick.
                self.next_start_us = self.now_us;
            }
            Mode::BringUp => {
                self.stage = Stage::Stop;
                self.next_start_us = self.now_us;
            }
            // Whatever the arm did with torque off, the estimator's model did
            // not see it: begin at rest where the arm is.
            Mode::Torque | Mode::Regulate => self.is_fresh |= !torque_is_on(before),
            Mode::Idle => {}
        }
        Ok(())
    }

    // --- what the host wants -----------------------------------------------

    fn take_orders(&mut self) {
        while let Some(order) = self.end.orders.dequeue() {
            self.heard_us = self.now_us;
            if let Order::Do(sequence, task) = order {
                let result = self.perform(task);
                // Lost if the host does not fetch them: it will ask again.
                let _ = self.end.notices.enqueue(Notice::Ack(sequence, result));
            }
        }
    }

    fn perform(&mut self, task: Task) -> Result<(), Refusal> {
        match task {
            Task::Idle => self.apply(Event::Asked(Request::Idle)),
            Task::ClearFault => self.apply(Event::Asked(Request::ClearFault)),
            Task::Torque(torque_nm) => {
                self.apply(Event::Asked(Request::Torque))?;
                self.torque_nm = torque_nm;
                Ok(())
            }
            Task::Regulate(reference_rad) => {
                self.apply(Event::Asked(Request::Regulate))?;
                self.law.set_reference(reference_rad);
                Ok(())
            }
            Task::Install(law) => {
                self.apply(Event::Asked(Request::Configure))?;
                self.law = law;
                self.is_fresh = true;
                Ok(())
            }
        }
    }
}

fn first_missing(samples: [Sample; JOINTS]) -> Option<(usize, Missing)> {
    samples
        .into_iter()
        .enumerate()
        .find_map(|(joint, sample)| match sample {
            Sample::Missing(missing) => Some((joint, missing)),
            Sample::Counts(_) => None,
        })
}

fn blank_record(mode: Mode) -> Record {
    Record {
        tick: 0,
        start_us: 0,
        mode,
        samples: [Sample::Missing(Missing::NotAsked); JOINTS],
        pwm_in_force: [Pwm::OFF.counts(); JOINTS],
        pwm_next: [Pwm::OFF.counts(); JOINTS],
        reference_rad: [0.0; JOINTS],
        angle_rad: [0.0; JOINTS],
        speed_rad_s: [0.0; JOINTS],
        torque_nm: [0.0; JOINTS],
        timing: Timing::default(),
        dropped: 0,
    }
}
