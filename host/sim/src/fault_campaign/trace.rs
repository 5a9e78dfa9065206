//! Trace of a case: its events as text, line by line.

use std::fmt::Write;

use armbridge_link::message::Mode;

use super::case::Case;
use super::expect;
use super::fixture::Fixture;
use super::injection::{Injection, Origin};
use super::outcome::Outcome;
use super::requirement::{FaultExpectation, fault_expectation};

/// Text of a case; none is formatted if it is off.
#[derive(Debug, Default)]
pub(super) struct Trace {
    is_off: bool,
    lines: String,
}

impl Trace {
    pub(super) fn off() -> Self {
        Self {
            is_off: true,
            ..Self::default()
        }
    }

    pub(super) fn text(self) -> String {
        self.lines
    }

    fn line(&mut self, line: &str) {
        self.lines.push_str(line);
        self.lines.push('\n');
    }

    pub(super) fn append(&mut self, now_us: u64, text: impl FnOnce() -> String) {
        if !self.is_off {
            // Writing to a string cannot fail.
            let _ = writeln!(self.lines, "{:>9.3} ms  {}", now_us as f64 * 1e-3, text());
        }
    }

    pub(super) fn begin(&mut self, case: &Case) {
        let friction = if case.friction { "with" } else { "without" };
        let limits = if case.is_tight { ", tight limits" } else { "" };
        let obstacles = if case.is_obstructed {
            ", between obstacles"
        } else {
            ""
        };
        let led = if case.is_led { ", led by a hand" } else { "" };
        self.line(&format!(
            "seed {}: {}, {}, {}, {friction} friction, noise of {:.2} counts{limits}{obstacles}{led}",
            case.seed,
            case.activity.name(),
            case.bus,
            case.set_up,
            case.noise_counts
        ));
        for injection in &case.injections {
            let expected = expect::expected(injection.kind, case.servos());
            let names: Vec<&str> = expected.faults.iter().map(|fault| fault.name()).collect();
            let (kind, names) = (injection.kind, names.join(", "));
            let since = match injection.origin {
                Origin::PowerUp => " from power-up on",
                Origin::Ready => "",
            };
            let kind = format!("{kind}{since}");
            self.line(&match fault_expectation(injection, case) {
                FaultExpectation::Required => format!("{kind}: fault {names} required"),
                FaultExpectation::Allowed => format!("{kind}: no fault, or {names}"),
                FaultExpectation::Forbidden => format!("{kind}: no fault permitted"),
            });
            self.line(&format!("  {}", expected.reason));
        }
    }

    pub(super) fn injection(&mut self, now_us: u64, injection: &Injection) {
        self.append(now_us, || {
            let Injection {
                kind,
                lasts_us,
                servo,
                amount,
                late_us,
                ..
            } = injection;
            let lasts = if *lasts_us > 1 << 40 {
                "until removed".into()
            } else {
                format!("for {:.3} ms", *lasts_us as f64 * 1e-3)
            };
            format!("{kind} {lasts}, servo {servo}, amount {amount:.4}, late {late_us} µs")
        });
    }

    pub(super) fn mode_change(
        &mut self,
        now_us: u64,
        from: Mode,
        to: Mode,
        fixture: &mut Fixture<'_>,
    ) {
        if self.is_off {
            return;
        }
        let record = fixture.driver().record;
        let trip = fixture.driver().trip;
        self.append(now_us, || {
            let state = record.map_or_else(String::new, |record| {
                format!(
                    "; tick {}, q {:.3?} rad, dq {:.2?} rad/s, PWM {:?}, {:?}",
                    record.tick,
                    record.output.angle_rad,
                    record.output.speed_rad_s,
                    record.input.pwm_in_force,
                    record.input.samples
                )
            });
            let why = match (to, trip) {
                (Mode::Fault(_), Some(trip)) => format!("; {trip:?}"),
                _ => String::new(),
            };
            format!("{from:?} -> {to:?}{why}{state}")
        });
    }

    pub(super) fn end(&mut self, outcome: &Outcome) {
        let verdict = if outcome.is_fault_expected {
            "expected"
        } else {
            "unexpected"
        };
        let detected = outcome.detected_ms.map_or_else(
            || "not detected".to_owned(),
            |ms| format!("detected after {ms:.3} ms"),
        );
        self.line(&format!(
            "fault {}, {verdict}; {detected}, motors off after {:.3} ms, contact at \
             {:.2} rad/s, far from the reference for {:.1} ms",
            outcome.fault.as_deref().unwrap_or("none"),
            outcome.stop_ms,
            outcome.contact_rad_s,
            outcome.far_ms
        ));
        // Counted apart in a campaign's report.
        let verdict = if outcome.is_guarded {
            "FAILED"
        } else {
            "FAILED, boards do not detect this kind yet"
        };
        for failure in &outcome.failures {
            self.line(&format!("{verdict}: {failure}"));
        }
    }
}
