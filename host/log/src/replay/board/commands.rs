//! Inputs from outside the tick: commands, sessions, faults.

use armbridge_board::bridge::command::{ValidatedCommand, validate};
use armbridge_board::control_loop::Violation;
use armbridge_board::control_loop::limits::MOTION;
use armbridge_board::control_loop::reference::{StartPoint, TimedTrajectory, refusal};
use armbridge_board::supervisor::Event;
use armbridge_control::trajectory::Trajectory;
use armbridge_link::message::{Command, Moment, Refusal, Trip};
use armbridge_link::motion::Motion;

use super::Board;

impl Board {
    /// Replays a hello.
    pub(in crate::replay) fn begin_session(&mut self, moment: Moment) {
        self.set_time(moment);
        self.core.begin_session();
        self.drain();
    }

    /// Replays a goodbye.
    pub(in crate::replay) fn goodbye(&mut self) {
        self.apply(Event::Disarm);
    }

    /// Gives the bus to a client of the transparent port.
    pub(in crate::replay) fn hand_over(&mut self) {
        self.apply(Event::ClientCame);
    }

    /// Takes it back when the client has left.
    pub(super) fn return_bus(&mut self) {
        self.apply(Event::ClientLeft);
    }

    fn apply(&mut self, event: Event) {
        // Never refused.
        let _ = self.core.apply(event);
        self.drain();
    }

    /// Replays a fault whose cause is not in the records; see
    /// [`is_external`](crate::replay::tick_facts::is_external).
    pub(in crate::replay) fn trip(&mut self, trip: &Trip) {
        self.core.set_time(trip.at_us);
        self.core.trip(Violation {
            fault: trip.fault,
            joint: trip.joint,
            value: trip.value,
            limit: trip.limit,
        });
        self.drain();
    }

    /// The start point of a motion that is commanded at this moment.
    ///
    /// # Errors
    /// The board's [`Refusal`].
    pub(in crate::replay) fn start_point(&mut self, moment: Moment) -> Result<StartPoint, Refusal> {
        self.set_time(moment);
        self.core.start_point()
    }

    /// Plans the motion, and commands it at this moment.
    ///
    /// # Errors
    /// The board's [`Refusal`].
    pub(in crate::replay) fn follow(
        &mut self,
        motion: &Motion,
        start: StartPoint,
        moment: Moment,
    ) -> Result<(), Refusal> {
        let trajectory = Trajectory::plan(start.from, &motion.shape(), &MOTION)
            .map_err(|error| refusal(&error))?;
        let motion = TimedTrajectory {
            trajectory,
            starts_us: start.at_us,
        };
        self.perform(ValidatedCommand::Follow(motion), moment)
    }

    /// Replays any other command, accepted at this moment. A fault cannot be cleared before
    /// the motors are known to be off, which no record shows: `recorded` is the reply of the
    /// recorded board.
    ///
    /// # Errors
    /// The board's [`Refusal`].
    pub(in crate::replay) fn command(
        &mut self,
        command: Command,
        moment: Moment,
        recorded: Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        self.bus.is_stop_settled = recorded != Err(Refusal::NotOff);
        self.bus.hot_joint = match recorded {
            Err(Refusal::Hot { joint }) => Some(joint),
            _ => None,
        };
        // It depends on all samples of the session, some of which may be missing.
        self.bus.encoder_refusal = recorded.err().filter(|refusal| {
            matches!(
                refusal,
                Refusal::EncoderUnknown { .. } | Refusal::BeyondLimit { .. }
            )
        });
        let session = match command {
            // The session has been checked.
            Command::Arm { session } => session,
            _ => 0,
        };
        self.perform(validate(command, session, None)?, moment)
    }

    fn perform(&mut self, command: ValidatedCommand, moment: Moment) -> Result<(), Refusal> {
        self.set_time(moment);
        let result = self.core.command(command, self.bus);
        self.drain();
        result
    }

    fn set_time(&mut self, moment: Moment) {
        self.core.set_time(moment.at_us);
    }
}
