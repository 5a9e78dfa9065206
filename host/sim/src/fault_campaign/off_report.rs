//! Judge of the board's reports on motors that must be off.
//!
//! A person may reach for the arm because the board says that a joint is
//! [off](OffState::Off). So no motor that is reported as such may be on for longer than
//! [`Case::stop_us`] without a break, from the report to the next one or to the end of the mode
//! in which it was made. Times in which a servo cannot be reached count too: what the board
//! cannot know it must not report. Of two servos with one id it hears either, and can know of
//! neither: their reports are not judged. "Unconfirmed" and "out of reach" claim nothing.

use armbridge_link::message::{Mode, OffReport, OffState};
use armbridge_servo::JOINTS;

use super::case::Case;
use super::fixture::Fixture;
use super::kind::Kind;
use super::outcome::Outcome;

/// A report, with its time in µs and the mode in which it was made.
#[derive(Clone, Copy, Debug)]
struct Claim {
    report: OffReport,
    mode: Mode,
    since_us: u64,
}

/// See the [module](self).
#[derive(Debug)]
pub(super) struct OffReportJudge {
    claim: Option<Claim>,
    allowed_us: u64,
    /// A servo answers for another.
    has_duplicate: bool,
}

impl OffReportJudge {
    pub(super) fn new(case: &Case) -> Self {
        Self {
            claim: None,
            allowed_us: case.stop_us(),
            has_duplicate: case.has(Kind::DuplicateId),
        }
    }

    /// Time in µs since when the board reports that not every motor is known to be off.
    pub(super) fn unconfirmed_since_us(&self) -> Option<u64> {
        let is_off = |claim: &Claim| claim.report.joints == [OffState::Off; JOINTS];
        let claim = self.claim.filter(|claim| !is_off(claim))?;
        Some(claim.since_us)
    }

    /// Compares the report in force with the motors.
    pub(super) fn observe(&mut self, fixture: &mut Fixture<'_>, outcome: &mut Outcome) {
        let (now_us, mode) = (fixture.now_us(), fixture.mode());
        let is_down = fixture.is_down();
        if let Some(report) = fixture.cosim.board.off_report.take() {
            self.claim = Some(Claim {
                report,
                mode,
                since_us: now_us,
            });
        }
        self.claim = self.claim.filter(|claim| claim.mode == mode && !is_down);
        let Some(claim) = self.claim else {
            return;
        };
        for (servo, state) in claim.report.joints.into_iter().enumerate() {
            let on_us = fixture.on_since_us(servo);
            let is_overdue =
                on_us.is_some_and(|on_us| now_us > claim.since_us.max(on_us) + self.allowed_us);
            if state == OffState::Off && is_overdue && !self.has_duplicate {
                outcome.fail(format!("motor {servo} was on and reported as off"));
            }
        }
    }
}
