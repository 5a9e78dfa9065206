//! Armed with zero torque, or holding the arm where it is, until ctrl-c, after a time, or
//! until a fault.

mod outcome;

use std::time::Duration;

use armbridge_client::ctrl_c;
use armbridge_client::session::{Request, SERVO_TIMEOUT_US};
use armbridge_client::status::{BoardStatus, FoundServos};
use armbridge_link::message::{BoardReport, Command, Mode, Refusal};
use armbridge_servo::JOINTS;

use super::{Task, TaskError, View};
pub use outcome::Outcome;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    /// Since the board has answered.
    Waiting(Option<u64>),
    Preparing(u64),
    Arming(u64),
    /// For the answer to the command that holds the arm at these angles, which comes after the
    /// motor check.
    Engaging(u64, [f32; JOINTS]),
    /// Since this tick.
    Holding(u32),
    /// The link broke while it was armed.
    Lost,
    Over,
}

/// Longest time without a record, and without the account of a fault.
const SILENCE_US: u64 = 1_000_000;
/// Largest distance of a held joint from its place, in rad: 6 degrees, more than static friction
/// and the motor check leave.
const STRAY_MAX_RAD: f32 = 0.1;
/// Time between two status lines.
const REPORT_US: u64 = 1_000_000;

/// Latest records of the board.
#[derive(Clone, Copy, Debug, Default)]
struct RecordTimes {
    /// Tick of the latest.
    tick: u32,
    /// When it came, in µs.
    at_us: u64,
    /// When the latest came that says it is armed.
    armed_us: u64,
}

/// Arms and holds.
pub struct Arm {
    step: Step,
    /// Sets stock servos to wheel mode, which torque needs.
    prepares: bool,
    /// Holds the arm where it is, instead of zero torque.
    holds: bool,
    /// Angles at which it holds the arm, and the largest distances so far, in rad.
    held_at_rad: Option<[f32; JOINTS]>,
    strayed_rad: f32,
    /// Ends by itself.
    lasts: Option<Duration>,
    report: Option<BoardReport>,
    outcome: Option<Outcome>,
    held: Duration,
    record_times: RecordTimes,
    report_line: Box<dyn FnMut(&str)>,
    report_us: u64,
}

impl Arm {
    /// For this long, or until ctrl-c.
    pub fn new(lasts: Option<Duration>, prepares: bool) -> Self {
        Self {
            step: Step::Waiting(None),
            prepares,
            holds: false,
            held_at_rad: None,
            strayed_rad: 0.0,
            lasts,
            report: None,
            outcome: None,
            held: Duration::ZERO,
            record_times: RecordTimes::default(),
            report_line: Box::new(|_| {}),
            report_us: 0,
        }
    }

    /// The same, with a status line every second.
    #[must_use]
    pub fn reporting(self, report_line: impl FnMut(&str) + 'static) -> Self {
        Self {
            report_line: Box::new(report_line),
            ..self
        }
    }

    /// The same, with the arm held where it is when the board arms.
    #[must_use]
    pub fn holding(self) -> Self {
        Self {
            holds: true,
            ..self
        }
    }

    /// Angles at which the arm is held, in rad, once the motors are checked.
    pub fn held_at_rad(&self) -> Option<[f32; JOINTS]> {
        self.held_at_rad
    }

    /// Largest distance of a joint from there, in rad.
    pub fn strayed_rad(&self) -> f32 {
        self.strayed_rad
    }

    /// Time for which the board was armed and the motors checked, by its ticks.
    pub fn held(&self) -> Duration {
        self.held
    }

    /// Its end, once it has ended.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()
    }

    fn end(&mut self, view: &mut View<'_>, outcome: Outcome) {
        self.step = Step::Over;
        self.outcome = Some(outcome);
        view.session.request(view.now_us, Request::Leave);
    }

    fn wait(&mut self, view: &mut View<'_>, since_us: u64) -> Result<(), TaskError> {
        let now_us = view.now_us;
        let status = view.session.status();
        if let Some(trip) = status.trip {
            return Err(TaskError::Latched(trip));
        }
        match (status.mode(), status.servos) {
            (Some(Mode::Passthrough), _) => {
                return Err(TaskError::Refused {
                    result: "the board is not armed",
                    refusal: Refusal::Passthrough,
                });
            }
            (Some(Mode::Idle), Some(FoundServos { is_ready: true, .. })) => {
                view.session.request(now_us, Request::Arm);
                self.step = Step::Arming(now_us);
            }
            (
                _,
                Some(FoundServos {
                    is_ready: false, ..
                }),
            ) if self.prepares => {
                let prepare = Request::Command(Command::Prepare);
                view.session.request(now_us, prepare);
                self.step = Step::Preparing(now_us);
            }
            (
                _,
                Some(FoundServos {
                    is_ready: false, ..
                }),
            ) => return Err(TaskError::NotPrepared),
            _ if now_us.saturating_sub(since_us) > SERVO_TIMEOUT_US => {
                return Err(TaskError::NoServos(status.obstacle));
            }
            _ => {}
        }
        Ok(())
    }

    fn hold(&mut self, view: &mut View<'_>, since_tick: u32) {
        let status = view.session.status();
        if let (Some(settings), Some(record)) = (status.settings, status.record) {
            let ticks = record.tick.saturating_sub(since_tick);
            self.held = Duration::from_micros(settings.setup.period_us.into()) * ticks;
        }
        if let (Some(place), Some(record)) = (self.held_at_rad, status.record) {
            let distances =
                [0, 1].map(|joint| (record.output.angle_rad[joint] - place[joint]).abs());
            let [first, second] = distances;
            self.strayed_rad = self.strayed_rad.max(first).max(second);
            // A distance that is no number is too large as well.
            if !distances.iter().all(|distance| *distance <= STRAY_MAX_RAD) {
                self.end(view, Outcome::Strayed(self.strayed_rad));
                return;
            }
        }
        if view.now_us >= self.report_us {
            self.report_us = view.now_us + REPORT_US;
            (self.report_line)(&line(view.session.status(), self.held));
        }
        if ctrl_c::is_raised() || self.lasts.is_some_and(|lasts| self.held >= lasts) {
            self.end(view, Outcome::Disarmed);
        }
    }

    /// Events that end it in any step.
    fn misfortune(&mut self, view: &View<'_>) -> Option<Outcome> {
        let status = view.session.status();
        if let (Some(before), Some(report)) = (self.report, status.report)
            && before.is_before_reset(&report)
        {
            return Some(Outcome::Reset(report.last_end));
        }
        if let (Some(Mode::Fault(_)), Some(trip)) = (status.mode(), status.trip) {
            return Some(Outcome::Tripped(trip));
        }
        let now_us = view.now_us;
        let record_times = &mut self.record_times;
        if let Some(record) = status
            .record
            .filter(|record| record.tick != record_times.tick)
        {
            (record_times.tick, record_times.at_us) = (record.tick, now_us);
            if record.mode.is_armed() {
                record_times.armed_us = now_us;
            }
        }
        if now_us.saturating_sub(record_times.at_us) > SILENCE_US {
            return Some(Outcome::Silent);
        }
        if now_us.saturating_sub(record_times.armed_us) <= SILENCE_US {
            return None;
        }
        Some(match status.mode() {
            Some(Mode::Fault(fault)) => Outcome::Fault(fault),
            _ => Outcome::Released,
        })
    }
}

impl Task for Arm {
    fn look(&mut self, mut view: View<'_>) -> Result<(), TaskError> {
        let now_us = view.now_us;
        match self.step {
            Step::Over => return Ok(()),
            Step::Lost if view.session.status().report.is_some() && view.session.is_greeted() => {
                let outcome = self.misfortune(&view).unwrap_or(Outcome::Parted);
                self.end(&mut view, outcome);
            }
            Step::Waiting(_) | Step::Preparing(_) | Step::Lost if ctrl_c::is_raised() => {
                self.end(&mut view, Outcome::Disarmed);
            }
            Step::Lost => {}
            Step::Waiting(None) => {
                if view.session.is_greeted() {
                    self.step = Step::Waiting(Some(now_us));
                }
            }
            Step::Waiting(Some(since_us)) => self.wait(&mut view, since_us)?,
            Step::Preparing(since_us) => {
                let status = view.session.status();
                if status.servos.is_some_and(|servos| servos.is_ready) {
                    self.step = Step::Waiting(Some(now_us));
                } else if now_us.saturating_sub(since_us) > SERVO_TIMEOUT_US {
                    return Err(TaskError::NoWheelMode(status.obstacle));
                }
            }
            Step::Arming(since_us) => {
                if view.is_acknowledged(since_us, "the board refused to arm")? {
                    self.report = view.session.status().report;
                    (self.record_times.at_us, self.record_times.armed_us) = (now_us, now_us);
                    self.step = Step::Holding(latest_tick(&view));
                    if let (true, Some(record)) = (self.holds, view.session.status().record) {
                        let hold = Command::Regulate(record.output.angle_rad);
                        view.session.request(now_us, Request::Command(hold));
                        self.step = Step::Engaging(now_us, record.output.angle_rad);
                    }
                }
            }
            Step::Engaging(since_us, place) => {
                if let Some(outcome) = self.misfortune(&view) {
                    self.end(&mut view, outcome);
                    return Ok(());
                }
                if view.is_acknowledged(since_us, "the board refused to hold the arm")? {
                    self.held_at_rad = Some(place);
                    self.step = Step::Holding(latest_tick(&view));
                } else if ctrl_c::is_raised() {
                    self.end(&mut view, Outcome::Disarmed);
                }
            }
            Step::Holding(since_tick) => match self.misfortune(&view) {
                Some(outcome) => self.end(&mut view, outcome),
                None => self.hold(&mut view, since_tick),
            },
        }
        Ok(())
    }

    fn disconnected(&mut self, _now_us: u64) {
        self.step = match self.step {
            Step::Waiting(_) | Step::Preparing(_) => Step::Waiting(None),
            Step::Arming(_) | Step::Engaging(..) | Step::Holding(_) | Step::Lost => Step::Lost,
            Step::Over => Step::Over,
        };
    }
}

/// Tick of the latest record: a board that arms was idle by one.
fn latest_tick(view: &View<'_>) -> u32 {
    (view.session.status().record).map_or(0, |record| record.tick)
}

/// As "armed for 3 s: joints at +0.300, -0.250 rad".
fn line(status: &BoardStatus, held: Duration) -> String {
    let at = status.record.map_or_else(String::new, |record| {
        let [first, second] = record.output.angle_rad;
        format!(": joints at {first:+.3}, {second:+.3} rad")
    });
    format!("armed for {} s{at}; ctrl-c disarms", held.as_secs())
}
