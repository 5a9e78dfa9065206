//! Motors off: disarmed, stopped, or a fault cleared.

use armbridge_client::fault_text;
use armbridge_client::refusal_text;
use armbridge_client::session::{ANSWER_TIMEOUT_US, Request, SERVO_TIMEOUT_US};
use armbridge_shared::link::message::{Command, Mode, Refusal};

use super::{Task, TaskError, View};

/// How far it has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Step {
    #[default]
    Greeting,
    /// Asked for, at this time.
    Asked(u64),
    Over,
}

/// Disarms, and leaves once the board has said that it is.
#[derive(Debug, Default)]
pub struct Disarm(Step);

impl Task for Disarm {
    fn look(&mut self, view: View<'_>) -> Result<(), TaskError> {
        match self.0 {
            Step::Greeting if !view.session.is_greeted() => {}
            Step::Greeting => {
                view.session
                    .request(view.now_us, Request::Command(Command::Idle));
                self.0 = Step::Asked(view.now_us);
            }
            Step::Asked(since_us) => match view.session.take_answer() {
                Some(Ok(())) => {
                    self.0 = Step::Over;
                    view.session.request(view.now_us, Request::Leave);
                }
                Some(Err(refusal)) => {
                    let why = refusal_text::in_words(refusal);
                    return Err(TaskError(format!("the board does not disarm: {why}")));
                }
                None => overdue(view.now_us, since_us, ANSWER_TIMEOUT_US, || {
                    "the board does not say that it has disarmed; switch its supply off".into()
                })?,
            },
            Step::Over => {}
        }
        Ok(())
    }

    fn disconnected(&mut self, _now_us: u64) {
        self.0 = Step::Greeting;
    }
}

/// Emergency stop: said at once, before the hello is answered, and until the board
/// says that it has stopped.
#[derive(Debug, Default)]
pub struct Stop(Step);

impl Task for Stop {
    fn look(&mut self, view: View<'_>) -> Result<(), TaskError> {
        match self.0 {
            Step::Greeting => {
                view.session.request(view.now_us, Request::Stop);
                self.0 = Step::Asked(view.now_us);
            }
            Step::Asked(_) if view.session.status().trip.is_some() => {
                self.0 = Step::Over;
                view.session.request(view.now_us, Request::Leave);
            }
            Step::Asked(since_us) => overdue(view.now_us, since_us, ANSWER_TIMEOUT_US, || {
                "stop was said, but the board does not say that it has stopped: press the switch \
                 at the board, or switch its supply off"
                    .into()
            })?,
            Step::Over => {}
        }
        Ok(())
    }

    fn disconnected(&mut self, _now_us: u64) {
        self.0 = Step::Greeting;
    }
}

/// Clears a fault, and waits until the servos are found again.
#[derive(Debug, Default)]
pub struct Clear(Step);

impl Task for Clear {
    fn look(&mut self, view: View<'_>) -> Result<(), TaskError> {
        let mode = view.session.status().mode();
        match self.0 {
            Step::Greeting if matches!(mode, Some(Mode::Fault(_))) => {
                view.session
                    .request(view.now_us, Request::Command(Command::ClearFault));
                self.0 = Step::Asked(view.now_us);
            }
            // Nothing to clear, or done.
            Step::Greeting | Step::Asked(_)
                if matches!(mode, Some(Mode::Idle | Mode::Passthrough)) =>
            {
                self.0 = Step::Over;
                view.session.request(view.now_us, Request::Leave);
            }
            Step::Asked(since_us) => {
                match view.session.take_answer() {
                    // The board soon reports that motors are off, or that they are not.
                    Some(Err(Refusal::NotOff)) => self.0 = Step::Greeting,
                    Some(Err(refusal)) => {
                        let why = refusal_text::in_words(refusal);
                        return Err(TaskError(format!("the fault is not cleared: {why}")));
                    }
                    Some(Ok(())) | None => {}
                }
                overdue(view.now_us, since_us, SERVO_TIMEOUT_US, || {
                    not_cleared(&view)
                })?;
            }
            Step::Greeting => overdue(view.now_us, 0, 2 * SERVO_TIMEOUT_US, || not_cleared(&view))?,
            Step::Over => {}
        }
        Ok(())
    }

    fn disconnected(&mut self, _now_us: u64) {
        self.0 = Step::Greeting;
    }
}

fn not_cleared(view: &View<'_>) -> String {
    let status = view.session.status();
    match (&status.trip, status.obstacle) {
        (Some(trip), _) => {
            let account = fault_text::in_words(trip);
            format!(
                "the fault came again: {}; {}",
                account.cause, account.advice
            )
        }
        (None, Some(obstacle)) => format!("the fault is cleared, but {obstacle}"),
        (None, None) => {
            "the fault is cleared, but the servos are not found: check their power".into()
        }
    }
}

fn overdue(
    now_us: u64,
    since_us: u64,
    longest_us: u64,
    why: impl FnOnce() -> String,
) -> Result<(), TaskError> {
    if now_us.saturating_sub(since_us) > longest_us {
        return Err(TaskError(why()));
    }
    Ok(())
}
