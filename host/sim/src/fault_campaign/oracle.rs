//! Oracle: runs a case and checks the requirements.
//!
//! ```text
//! power-up     ready     first fault ... last     removed      cleared
//! | 3 s at most | up to 4 s | up to 0.1 s | 1.5 s   |   0.2 s    | 3 s at most, 0.3 s after
//!   or: first fault
//! ```
//!
//! Motors, modes and the true arm are checked at every event on the bench, not at ticks,
//! from power-up to the end.

use armbridge_link::message::{Drive, Fault, Mode, SettingsFrom};
use armbridge_servo::JOINTS;

use super::activity::Activity;
use super::case::Case;
use super::expect;
use super::fixture::Fixture;
use super::injection::{Injection, Origin};
use super::kind::Kind;
use super::off_report::OffReportJudge;
use super::outcome::Outcome;
use super::park::{self, ParkJudge, is_parking};
use super::requirement::{FaultExpectation, fault_expectation};
use super::supply::SupplyJudge;
use super::trace::Trace;
use super::truth::Truth;

/// Until the activity runs, in µs: bring-up takes 20 ms at 1 Mbaud, and preparation of stock
/// servos on a slow bus a second.
const READY_US: u64 = 5_000_000;
/// From the removal of the faults to the end, in µs.
const SETTLE_US: u64 = 200_000;
/// Until a cleared board is idle again, in µs. A hot Morpheus servo reads its temperature every
/// 0.8 s, and the board asks for it every 0.5 s.
const CLEAR_US: u64 = 3_000_000;
/// Observation after that, in µs: motors stay off.
const END_US: u64 = 300_000;
/// Time in µs by which a torque may outlive the age of its command: a clock that jumps, and
/// the ticks.
const AGE_SLACK_US: u64 = 200_000;
/// Far more events than a case can have: six or seven a tick.
const EVENTS_MAX: u32 = 500_000;
/// Torque that a PWM's rounding adds, in N m: a count is 1.2 mN m.
const ROUNDING_NM: f32 = 0.002;

/// Runner of a case.
pub(super) struct CaseRunner<'a, 'b> {
    case: &'b Case,
    fixture: Fixture<'a>,
    trace: &'b mut Trace,
    outcome: Outcome,
    truth: Truth,
    off_report: OffReportJudge,
    supply: SupplyJudge,
    park: ParkJudge,
    mode: Mode,
    /// Since when no motor may be on, in µs.
    undriven_us: Option<u64>,
    fault: Option<(Fault, u64)>,
    /// It may be one for the noise alone.
    is_noise_fault: bool,
    first_us: Option<u64>,
    /// Time in µs since when the session that armed is over, by a goodbye or a hello.
    ended_us: Option<u64>,
    /// A motor's PWM exceeded the limits.
    is_pwm_exceeded: bool,
    events: u32,
}

impl<'a, 'b> CaseRunner<'a, 'b> {
    pub(super) fn new(case: &'b Case, fixture: Fixture<'a>, trace: &'b mut Trace) -> Self {
        Self {
            case,
            mode: fixture.mode(),
            truth: Truth::new(case, &fixture),
            off_report: OffReportJudge::new(case),
            supply: SupplyJudge::new(case),
            park: ParkJudge::default(),
            fixture,
            trace,
            outcome: Outcome::new(case),
            undriven_us: Some(0),
            fault: None,
            is_noise_fault: false,
            first_us: None,
            ended_us: None,
            is_pwm_exceeded: false,
            events: 0,
        }
    }

    /// Runs the case to its end.
    pub(super) fn run(mut self) -> Outcome {
        let is_ready = self.bring_up();
        let has_early = self.has_injections(Origin::PowerUp);
        if !has_early && !self.is_noise_fault && (!is_ready || self.fault.is_some()) {
            let why = format!("not ready: {}", self.state_text());
            return self.outcome.failed(why);
        }
        self.observe_injections();
        self.check_fault();
        let now_us = self.fixture.now_us();
        if let Some(off) = self.fixture.driver().off {
            self.trace
                .append(now_us, || format!("report of the board: {off:?}"));
        }
        self.trace
            .append(now_us, || "all faults are removed".into());
        self.fixture.repair();
        self.run_until(now_us + SETTLE_US, |_| false);
        self.fixture.replace_servos();
        self.clear();
        let now_us = self.fixture.now_us();
        self.run_until(now_us + END_US, |_| false);
        self.check_motors();
        self.outcome
    }

    fn has_injections(&self, origin: Origin) -> bool {
        self.case.injections.iter().any(|it| it.origin == origin)
    }

    /// Runs from power-up, with the faults of that time, until the activity runs. Returns
    /// whether it does.
    fn bring_up(&mut self) -> bool {
        if self.has_injections(Origin::PowerUp) {
            self.inject(Origin::PowerUp, 0, READY_US);
        }
        let is_ready = self.run_until(READY_US, |runner| runner.fixture.is_working());
        let ready_us = self.fixture.now_us();
        if is_ready && self.case.is_led {
            self.fixture.lead();
        }
        let text = if is_ready {
            "the activity runs"
        } else {
            "the activity does not begin"
        };
        self.trace.append(ready_us, || text.into());
        is_ready
    }

    /// Injects the faults that come after that, and observes.
    fn observe_injections(&mut self) {
        let ready_us = self.fixture.now_us();
        let late = self
            .case
            .injections
            .iter()
            .filter(|it| it.origin == Origin::Ready);
        let last_us = late.map(|it| it.after_us).max().unwrap_or(0);
        let until_us = ready_us + last_us + self.case.observation_us();
        self.inject(Origin::Ready, ready_us, until_us);
        self.run_until(until_us, |_| false);
        self.run_until(until_us + park::ENDS_US, |runner| !is_parking(runner.mode));
    }

    /// Starts the faults of this origin and ends them, as long as they end before that time.
    fn inject(&mut self, origin: Origin, from_us: u64, until_us: u64) {
        let injections = &self.case.injections;
        let mut steps: Vec<(u64, bool, usize)> = injections
            .iter()
            .enumerate()
            .filter(|(_, injection)| injection.origin == origin)
            .flat_map(|(index, injection)| {
                let begin_us = from_us + injection.after_us;
                let end_us = begin_us.saturating_add(injection.lasts_us);
                [(begin_us, true, index), (end_us, false, index)]
            })
            .collect();
        steps.sort_unstable_by_key(|(at_us, is_begin, _)| (*at_us, !is_begin));
        for (at_us, is_begin, index) in steps {
            if at_us >= until_us {
                break;
            }
            self.run_until(at_us, |_| false);
            if let Some(injection) = injections.get(index) {
                self.apply(injection, is_begin);
            }
        }
    }

    /// Starts or ends an injection.
    fn apply(&mut self, injection: &Injection, is_begin: bool) {
        let now_us = self.fixture.now_us();
        if is_begin {
            self.trace.injection(now_us, injection);
            if self.fixture.is_fault_free && self.fault.is_some() && !self.is_noise_fault {
                let why = format!("a fault before anything was wrong: {}", self.state_text());
                self.outcome.fail(why);
            }
            self.first_us.get_or_insert(now_us);
            let is_heard = self.case.injections.iter().all(|it| !it.kind.is_of_link());
            let is_end = matches!(injection.kind, Kind::Goodbye | Kind::HostHello);
            if self.mode.is_armed() && is_end && is_heard {
                self.ended_us = Some(now_us);
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
            if let (Mode::Fault(fault), None) = (mode, self.fault) {
                self.fault = Some((fault, now_us));
                let is_in_check = self.mode == Mode::MotorCheck;
                self.is_noise_fault = expect::is_noise_fault(fault, is_in_check, self.case);
            }
            self.mode = mode;
        }
        if self.fixture.is_permitted() {
            self.undriven_us = None;
        } else {
            self.undriven_us.get_or_insert(now_us);
        }
        if self
            .ended_us
            .is_some_and(|at_us| now_us > at_us + self.case.stop_us())
            && mode.is_armed()
            && !is_parking(mode)
        {
            self.outcome
                .fail("still armed after the end of the session".into());
        }
        self.park.observe(now_us, mode, &mut self.outcome);
        let age_us = now_us.saturating_sub(self.fixture.driver().torque_us);
        let allowed_us = u64::from(self.case.limits().torque_age_ms) * 1_000 + AGE_SLACK_US;
        if mode.drive() == Some(Drive::Torque) && age_us > allowed_us && !self.fixture.is_down() {
            self.outcome.fail("a torque outlived its command".into());
        }
        let is_foreign = self.fixture.is_foreign();
        let allowed = self.case.limits().pwm_counts;
        for servo in 0..JOINTS {
            if let Some(since_us) = self.undriven_us {
                let overdue_ms = self.fixture.overdue_us(servo, since_us) as f64 * 1e-3;
                self.outcome.stop_ms = self.outcome.stop_ms.max(overdue_ms);
            }
            let max_deviation = self.fixture.cosim.bench.take_most_counts(servo);
            if max_deviation > allowed && !is_foreign && !self.is_pwm_exceeded {
                self.is_pwm_exceeded = true;
                let why =
                    format!("motor {servo} was {max_deviation} counts from off, at {now_us} µs");
                self.outcome.fail(why);
            }
        }
        self.truth.observe(&mut self.fixture, &mut self.outcome);
        self.off_report
            .observe(&mut self.fixture, &mut self.outcome);
        let unconfirmed_us = self.off_report.unconfirmed_since_us();
        self.supply
            .observe(&self.fixture, unconfirmed_us, &mut self.outcome);
    }

    /// Mode and trip as text.
    fn state_text(&mut self) -> String {
        let trip = self.fixture.driver().trip;
        let fault = trip.map_or_else(String::new, |trip| format!(", {trip:?}"));
        let refusal = self.fixture.driver().refusal;
        let refusal = refusal.map_or_else(String::new, |why| format!(", refused: {why:?}"));
        format!("{:?}{fault}{refusal}", self.mode)
    }

    /// Whether the case requires a fault of this injection, after what is known of the board.
    fn expectation(&mut self, injection: &Injection) -> FaultExpectation {
        let board = self.fixture.driver().board;
        let is_saved = board.is_some_and(|board| board.settings == SettingsFrom::Saved);
        if injection.kind == Kind::FlashRot && is_saved {
            // The damaged byte was not among those in use.
            return FaultExpectation::Forbidden;
        }
        fault_expectation(injection, self.case)
    }

    /// Compares the fault, or the refusal to arm, with the expected ones.
    fn check_fault(&mut self) {
        let case = self.case;
        let injections = case.injections.iter();
        let expectations: Vec<(Kind, FaultExpectation)> = injections
            .map(|it| (it.kind, self.expectation(it)))
            .collect();
        let driver = self.fixture.driver();
        let (refusal, armed_us) = (driver.refusal, driver.armed_us);
        let is_allowed = |expectation| expectation != FaultExpectation::Forbidden;
        let is_of_start = case.injections.iter().all(|it| it.kind.is_from_start());
        let from_us = if is_of_start { armed_us } else { self.first_us };
        let outcome = &mut self.outcome;
        match (self.fault, refusal) {
            (Some((fault, at_us)), _) => {
                let is_of_kind = expectations.iter().any(|(kind, expectation)| {
                    expect::is_fault_expected(*kind, fault, case) && is_allowed(*expectation)
                });
                outcome.is_fault_expected = is_of_kind || self.is_noise_fault;
                outcome.fault = Some(fault.name().into());
                let from_us = from_us.or(self.first_us).unwrap_or(0);
                outcome.detected_ms = Some(at_us.saturating_sub(from_us) as f64 * 1e-3);
            }
            (None, Some(refusal))
                if expectations
                    .iter()
                    .any(|(kind, _)| expect::is_refusal_expected(*kind, refusal)) =>
            {
                outcome.fault = Some(format!("refused: {refusal:?}"));
            }
            (None, _) => {
                let is_required =
                    |(_, it): &(Kind, FaultExpectation)| *it == FaultExpectation::Required;
                // "Nothing" is a name for an arm that has come to no harm.
                outcome.is_fault_expected =
                    !expectations.iter().any(is_required) && !outcome.is_harmed;
            }
        }
    }

    /// Clears the fault, and checks that the board becomes idle, as one without a fault must.
    fn clear(&mut self) {
        // A board that has restarted has no fault any more.
        let is_cleared = matches!(self.mode, Mode::Fault(_)) && self.case.is_cleared;
        if is_cleared {
            let now_us = self.fixture.now_us();
            self.trace
                .append(now_us, || "the host clears the fault".into());
            self.fixture.driver().clear();
        } else if !matches!(self.mode, Mode::Boot | Mode::Passthrough) {
            return;
        }
        let now_us = self.fixture.now_us();
        // Stock servos are set up again, and the host may go on from there.
        let is_up = |runner: &mut Self| match runner.mode {
            Mode::Idle => true,
            mode => !is_cleared && mode.is_armed(),
        };
        let is_back = self.run_until(now_us + CLEAR_US, is_up);
        self.outcome.is_cleared = is_cleared.then_some(is_back);
        if !is_back {
            let why = format!("not idle after all was repaired: {}", self.state_text());
            self.outcome.fail(why);
        }
    }

    /// Checks PWM, torque and stop time against the limits.
    fn check_motors(&mut self) {
        let outcome = &mut self.outcome;
        if outcome.stop_ms > self.case.stop_us() as f64 * 1e-3 {
            outcome.fail(format!("a motor was on for {:.1} ms", outcome.stop_ms));
        }
        let is_configured = self.case.is_configured();
        if let Some((at_us, counts)) = self.fixture.cosim.board.beyond {
            outcome.fail(format!(
                "a PWM {counts} counts from off was sent at {at_us} µs"
            ));
        }
        // A record has the torque without that against friction.
        let [limit_nm, _] = self.case.limits().torque_nm;
        let allowed_nm = limit_nm + self.case.setup().friction_nm[0];
        let driver = self.fixture.driver();
        // A torque that is computed from corrupted parameters is not checked, nor that of an arm that
        // floats, of which a record has the part that the model explains; the PWM is.
        let is_computed_right =
            is_configured && !self.case.has(Kind::Corrupt) && self.case.activity != Activity::Float;
        if driver.max_torque_nm > allowed_nm + ROUNDING_NM && is_computed_right {
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
mod tests;
