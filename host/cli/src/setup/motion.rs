//! The first motion: the motor check of the board, then the arm held where it is.

use armbridge_client::LinkError;

use super::{Error, Setup, drive, is_over};
use crate::board_tasks::TaskError;
use crate::board_tasks::arm::{Arm, Outcome};
use crate::finding::Finding;

/// After a failed motion.
const AGAIN: &str = "once it is mended, and the fault cleared (`armbridge clear`): armbridge setup";

impl Setup<'_> {
    /// Arms, once the person agrees, and holds the arm.
    pub(super) fn direction(&mut self) -> Result<Finding, Error> {
        if self.needs_wheel_mode
            && !self.may(
                "Stock servos are set to wheel mode, X servos to PWM control mode, which they keep",
            )?
        {
            return Ok(declined());
        }
        let hold_s = self.options.hold.as_secs_f64();
        let answer = self.ask(&format!(
            "Put the arm upright, so that it stands by itself, clear of everything. A hand at the\n\
             switch of the servos' supply. Each motor moves its joint by 3 counts either way, and\n\
             the board holds the arm where it is for {hold_s} s. Then motors go off: take hold of\n\
             the arm before it falls. Let go of it and press Enter, or n [Y/n]"
        ))?;
        if !matches!(answer.as_str(), "" | "y" | "yes") {
            return Ok(declined());
        }
        let arm = Arm::new(Some(self.options.hold), self.needs_wheel_mode).holding();
        let arm = match drive(self.options, arm) {
            Ok(host) => host.task,
            Err(LinkError::Host(error)) if !is_over(&error) => {
                return Ok(Finding::missing(error.to_string(), AGAIN));
            }
            Err(error) => return Err(error.into()),
        };
        let ending = arm.outcome().unwrap_or(&Outcome::Released);
        let Some([first, second]) = arm.held_at_rad() else {
            return Ok(Finding::missing(ending.in_words(), AGAIN));
        };
        let held_s = arm.held().as_secs_f64();
        self.hold = Some(match ending {
            Outcome::Disarmed if arm.held() >= self.options.hold => Finding::Ok(format!(
                "{held_s:.1} s at {first:+.3} and {second:+.3} rad, within {:.0} mrad; motors off",
                1e3 * arm.strayed_rad()
            )),
            Outcome::Disarmed => return Err(TaskError::Interrupted.into()),
            _ => Finding::missing(ending.in_words(), AGAIN),
        });
        Ok(Finding::Ok(
            "both motors turn their joints the right way".into(),
        ))
    }

    /// The hold of the same arming.
    pub(super) fn hold(&mut self) -> Finding {
        self.hold.take().unwrap_or_else(declined)
    }
}

fn declined() -> Finding {
    Finding::missing(
        "declined: nothing has moved",
        "armbridge setup, when it may",
    )
}
