//! Oracle: runs a case and checks the requirements.
//!
//! ```text
//! ready     first fault ... last    removed     cleared
//! |0.3-0.8 s| up to 0.1 s |  1.5 s   |   0.2 s  | 3 s at most
//! ```
//!
//! Requirements are checked at every event on the bench, not at ticks.

use armbridge_client::enum_names;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Fault, Mode};

use super::case::{Case, Injection};
use super::expect::{self, FaultExpectation, STOP_US};
use super::fixture::Fixture;
use super::kind::Kind;
use super::outcome::Outcome;
use super::trace::Trace;

/// Until the scenario runs, in µs: bring-up takes 20 ms.
const READY_US: u64 = 1_000_000;
/// From the removal of the faults to the end, in µs.
const SETTLE_US: u64 = 200_000;
/// Until a cleared board is idle again, in µs. A hot Morpheus servo reads its temperature every
/// 0.8 s, and at 1 kHz the board asks for it every 2.5 s.
const CLEAR_US: u64 = 5_000_000;
/// Far more events than a case can have: six or seven a tick.
const EVENTS_MAX: u32 = 200_000;
/// Torque that a PWM's rounding adds, in N m: a count is 1.2 mN m.
const ROUNDING_NM: f32 = 0.002;

/// Runner of a case.
pub(super) struct CaseRunner<'a, 'b> {
    case: &'b Case,
    fixture: Fixture<'a>,
    trace: &'b mut Trace,
    outcome: Outcome,
    mode: Mode,
    /// Start of the present time in modes that do not drive the motors, in µs.
    undriven_us: Option<u64>,
    fault: Option<(Fault, u64)>,
    /// A motor's PWM exceeded the limits.
    is_pwm_exceeded: bool,
    events: u32,
}

impl<'a, 'b> CaseRunner<'a, 'b> {
    pub(super) fn new(case: &'b Case, fixture: Fixture<'a>, trace: &'b mut Trace) -> Self {
        Self {
            case,
            mode: fixture.mode(),
            fixture,
            trace,
            outcome: Outcome::new(case),
            undriven_us: None,
            fault: None,
            is_pwm_exceeded: false,
            events: 0,
        }
    }

    /// Runs the case to its end.
    pub(super) fn run(mut self) -> Outcome {
        let is_ready = self.run_until(READY_US, |runner| runner.fixture.driver().is_working());
        if !is_ready || self.fault.is_some() {
            let why = format!("not ready: {}", self.state_text());
            return self.outcome.failed(why);
        }
        let ready_us = self.fixture.now_us();
        self.trace.append(ready_us, || "the scenario runs".into());
        self.inject(ready_us);
        self.check_fault(ready_us);
        let now_us = self.fixture.now_us();
        if let Some(off) = self.fixture.driver().off {
            self.trace
                .append(now_us, || format!("report of the board: {off:?}"));
        }
        self.trace
            .append(now_us, || "all faults are removed".into());
        self.fixture.repair();
        self.run_until(now_us + SETTLE_US, |_| false);
        self.clear();
        self.check_motors();
        self.outcome
    }

    /// Injects the faults, and observes.
    fn inject(&mut self, ready_us: u64) {
        let injections = &self.case.injections;
        let mut steps: Vec<(u64, bool, usize)> = injections
            .iter()
            .enumerate()
            .flat_map(|(index, injection)| {
                let begin_us = ready_us + injection.after_us;
                let end_us = begin_us.saturating_add(injection.lasts_us);
                [(begin_us, true, index), (end_us, false, index)]
            })
            .collect();
        steps.sort_unstable_by_key(|(at_us, is_begin, _)| (*at_us, !is_begin));
        let last_us = injections.iter().map(|i| i.after_us).max().unwrap_or(0);
        let until_us = ready_us + last_us + self.case.observation_us();
        for (at_us, is_begin, index) in steps {
            if at_us >= until_us {
                break;
            }
            self.run_until(at_us, |_| false);
            if let Some(injection) = injections.get(index) {
                self.apply(injection, is_begin);
            }
        }
        self.run_until(until_us, |_| false);
    }

    /// Starts or ends an injection.
    fn apply(&mut self, injection: &Injection, is_begin: bool) {
        let now_us = self.fixture.now_us();
        if is_begin {
            self.trace.injection(now_us, injection);
            if self.fixture.is_fault_free() && self.fault.is_some() {
                let why = format!("a fault before anything was wrong: {}", self.state_text());
                self.outcome.fail(why);
            }
            self.fixture.begin(injection);
        } else {
            self.fixture.end(injection);
            if injection.lasts_us > 0 {
                self.trace
                    .append(now_us, || format!("{} is over", injection.kind));
            }
        }
    }

    /// Runs until that time, or until the condition holds. Returns whether it holds.
    fn run_until(&mut self, until_us: u64, holds: impl Fn(&mut Self) -> bool) -> bool {
        while self.fixture.now_us() < until_us && !holds(self) {
            if self.events >= EVENTS_MAX {
                self.outcome.fail("hung: too many events".into());
                return false;
            }
            self.events += 1;
            self.fixture.step_until(until_us);
            self.observe();
        }
        holds(self)
    }

    /// Updates mode, fault and motor times after an event.
    fn observe(&mut self) {
        let now_us = self.fixture.now_us();
        let mode = self.fixture.mode();
        if mode != self.mode {
            self.trace
                .mode_change(now_us, self.mode, mode, &mut self.fixture);
            if mode.drive().is_some() {
                self.undriven_us = None;
            } else if self.mode.drive().is_some() {
                self.undriven_us = Some(now_us);
            }
            if let (Mode::Fault(fault), None) = (mode, self.fault) {
                self.fault = Some((fault, now_us));
            }
            self.mode = mode;
        }
        let is_corrupting = self.fixture.is_corrupting();
        let allowed = self.case.limits().pwm_counts;
        for servo in 0..JOINTS {
            if let Some(since_us) = self.undriven_us {
                let overdue_ms = self.fixture.overdue_us(servo, since_us) as f64 * 1e-3;
                self.outcome.stop_ms = self.outcome.stop_ms.max(overdue_ms);
            }
            let max_deviation = self.fixture.cosim.bench.take_most_counts(servo);
            if max_deviation > allowed && !is_corrupting && !self.is_pwm_exceeded {
                self.is_pwm_exceeded = true;
                let why = format!("motor {servo} was {max_deviation} counts from off");
                self.outcome.fail(why);
            }
        }
    }

    /// Mode and trip as text.
    fn state_text(&mut self) -> String {
        let trip = self.fixture.driver().trip;
        let fault = trip.map_or_else(String::new, |trip| format!(", {trip:?}"));
        format!("{:?}{fault}", self.mode)
    }

    /// Compares the fault with the expected ones.
    fn check_fault(&mut self, ready_us: u64) {
        let injections = &self.case.injections;
        let is =
            |requirement, injection| expect::fault_expectation(injection, self.case) == requirement;
        let outcome = &mut self.outcome;
        match self.fault {
            None => {
                outcome.is_fault_expected =
                    !injections.iter().any(|i| is(FaultExpectation::Required, i));
            }
            Some((fault, at_us)) => {
                let is_expected = |i: &Injection| {
                    expect::expected(i.kind, self.case.servos)
                        .faults
                        .contains(&fault)
                };
                outcome.is_fault_expected = injections
                    .iter()
                    .any(|i| is_expected(i) && !is(FaultExpectation::Forbidden, i));
                outcome.fault = Some(enum_names::fault(fault));
                let first_us = ready_us + injections.first().map_or(0, |i| i.after_us);
                outcome.detected_ms = Some(at_us.saturating_sub(first_us) as f64 * 1e-3);
            }
        }
        if self.case.has(Kind::Goodbye) && self.mode.is_armed() {
            outcome.fail("still armed after a goodbye".into());
        }
    }

    /// Clears the fault, and checks that the board becomes idle.
    fn clear(&mut self) {
        if self.fault.is_none() || !self.case.is_cleared {
            return;
        }
        let now_us = self.fixture.now_us();
        self.trace
            .append(now_us, || "the host clears the fault".into());
        self.fixture.driver().clear();
        let is_back = self.run_until(now_us + CLEAR_US, |runner| runner.mode == Mode::Idle);
        self.outcome.is_cleared = Some(is_back);
        if !is_back {
            let why = format!(
                "not idle after the fault was cleared: {}",
                self.state_text()
            );
            self.outcome.fail(why);
        }
    }

    /// Checks PWM, torque and stop time against the limits.
    fn check_motors(&mut self) {
        let outcome = &mut self.outcome;
        if outcome.stop_ms > STOP_US as f64 * 1e-3 {
            outcome.fail(format!("a motor was on for {:.1} ms", outcome.stop_ms));
        }
        if let Some((at_us, counts)) = self.fixture.cosim.board.beyond {
            outcome.fail(format!(
                "a PWM {counts} counts from off was sent at {at_us} µs"
            ));
        }
        let [allowed_nm, _] = self.case.limits().torque_nm;
        let driver = self.fixture.driver();
        // A torque that is computed from corrupted parameters is not checked; the PWM is.
        if driver.max_torque_nm > allowed_nm + ROUNDING_NM && !self.case.has(Kind::Corrupt) {
            let max_torque_nm = driver.max_torque_nm;
            outcome.fail(format!(
                "torque of {max_torque_nm} N m, {allowed_nm} allowed"
            ));
        }
        if driver.accepted_invalid > 0 {
            let accepted = driver.accepted_invalid;
            outcome.fail(format!("{accepted} commands out of range accepted"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::case::Scenario;
    use super::super::driver::HostFault;
    use super::*;
    use armbridge_shared::bridge::Channels;
    use armbridge_shared::link::message::StopSource;
    use armbridge_shared::servo::Firmware;

    /// The first single of this kind, in the first scenario.
    fn case_of(kind: Kind, is_tight: bool) -> Case {
        let index = Kind::ALL.iter().position(|other| *other == kind).unwrap();
        let case = Case::new(2 * index as u64, Firmware::Morpheus);
        Case { is_tight, ..case }
    }

    /// Checks a case on a board that was set up for another case, after a change that is not
    /// part of the case.
    fn checked(case: &Case, set_up: &Case, done: impl FnOnce(&mut Fixture<'_>)) -> Outcome {
        let mut channels = Channels::new();
        let fixture = Fixture::new(set_up, channels.split()).unwrap();
        let mut trace = Trace::off();
        let mut runner = CaseRunner::new(case, fixture, &mut trace);
        assert!(runner.run_until(READY_US, |runner| runner.fixture.driver().is_working()));
        let ready_us = runner.fixture.now_us();
        runner.run_until(ready_us + 100_000, |_| false);
        done(&mut runner.fixture);
        runner.inject(ready_us);
        runner.check_fault(ready_us);
        runner.check_motors();
        runner.outcome
    }

    #[test]
    fn a_motor_that_stays_on_is_seen() {
        let stop = case_of(Kind::StopHost, false);
        assert_eq!(checked(&stop, &stop, |_| ()).failures, [""; 0]);
        let deafened = checked(&stop, &stop, |fixture| fixture.cosim.bench.deafen(0, true));
        assert!(deafened.stop_ms > 1_000.0, "{deafened:?}");
        let is_seen = |why: &String| why.contains("was on for");
        assert!(deafened.failures.iter().any(is_seen), "{deafened:?}");
    }

    #[test]
    fn a_board_with_other_limits_is_seen() {
        let case = |is_tight| Case {
            to_rad: [1.2; JOINTS],
            ..case_of(Kind::Goodbye, is_tight)
        };
        let outcome = checked(&case(true), &case(false), |fixture| {
            fixture.cosim.board.max_deviation = 10;
        });
        let seen = outcome.failures.join("; ");
        for words in ["counts from off", "was sent at", "N m, 0.8 allowed"] {
            assert!(seen.contains(words), "{seen}");
        }
    }

    #[test]
    fn a_wrong_name_and_a_missing_one_are_seen() {
        let goodbye = case_of(Kind::Goodbye, false);
        assert!(checked(&goodbye, &goodbye, |_| ()).is_fault_expected);
        let stopped = checked(&goodbye, &goodbye, |fixture| {
            fixture.cosim.is_stop_pressed = true;
        });
        let pin = enum_names::fault(Fault::EmergencyStop(StopSource::Pin));
        assert_eq!(
            (stopped.fault, stopped.is_fault_expected),
            (Some(pin), false)
        );
        // A host that is gone cannot stop anything.
        let stop = Case {
            scenario: Scenario::Idle,
            ..case_of(Kind::StopHost, false)
        };
        let ignored = checked(&stop, &stop, |fixture| {
            fixture.driver().inject(HostFault::Silent);
        });
        assert_eq!((ignored.fault, ignored.is_fault_expected), (None, false));
    }
}
