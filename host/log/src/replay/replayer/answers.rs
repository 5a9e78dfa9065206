//! Answers to commands: accepted commands are repeated, and refusals that depend on the loop's
//! state are compared.

use armbridge_client::{enum_names, refusal_text};
use armbridge_link::message::{Command, Mode, Moment, Refusal, Settings};

use super::super::board::Board;
use super::super::compare::Difference;
use super::super::loss::Loss;
use super::super::what_if;
use super::{Knowledge, ReplayError, Replayer};

impl Replayer {
    /// A command was accepted or refused, with this reply.
    pub(super) fn apply_answer(
        &mut self,
        sequence: u16,
        result: Result<(), Refusal>,
        moment: Moment,
        acts_us: u64,
    ) -> Result<(), ReplayError> {
        let start = self.start_points.remove(&sequence);
        let Some(command) = self.commands.remove(&sequence) else {
            // A refused command has no effect.
            if result.is_ok() {
                self.lose(Loss::OtherHost, 0);
            }
            return Ok(());
        };
        let command = self.change(command)?;
        let perform = |board: &mut Board| match (command, start) {
            (Command::Follow(motion), Some(start)) => board.follow(&motion, start, moment, acts_us),
            (command, _) => board.command(command, moment, acts_us),
        };
        let computed = match result {
            Ok(()) => perform(&mut self.board),
            Err(refusal) if is_by_loop(refusal) => perform(&mut self.board.clone()),
            Err(_) => return Ok(()),
        };
        if result.is_ok() && computed.is_ok() {
            match command {
                Command::Configure(setup) => self.settings.setup = setup,
                Command::Limit(limits) => self.settings.limits = limits,
                Command::Arm { .. } if moment.mode == Mode::Idle => self.restart(),
                command if command.is_drive() && moment.mode == Mode::Armed => self.restart(),
                _ => {}
            }
        }
        self.check_answer(enum_names::command(&command), moment, result, computed);
        Ok(())
    }

    /// The command, with the changed settings.
    fn change(&mut self, command: Command) -> Result<Command, ReplayError> {
        let settings = match command {
            Command::Configure(setup) => Settings {
                setup,
                ..self.settings
            },
            Command::Limit(limits) => Settings {
                limits,
                ..self.settings
            },
            _ => return Ok(command),
        };
        let changed = self.changes.apply(&settings)?;
        self.changed.extend(what_if::changed(&settings, &changed));
        Ok(match command {
            Command::Configure(_) => Command::Configure(changed.setup),
            Command::Limit(_) => Command::Limit(changed.limits),
            other => other,
        })
    }

    fn check_answer(
        &mut self,
        name: &str,
        moment: Moment,
        recorded: Result<(), Refusal>,
        computed: Result<(), Refusal>,
    ) {
        if self.knowledge != Knowledge::Full {
            return;
        }
        self.tally.answers += 1;
        if recorded == computed {
            return;
        }
        self.tally.answers_differing += 1;
        let text = |result: Result<(), Refusal>| match result {
            Ok(()) => "accepted".to_owned(),
            Err(refusal) => format!("refused: {}", refusal_text::in_words(refusal)),
        };
        self.tally.differ(|| {
            Some(Difference {
                tick: moment.tick,
                start_us: moment.at_us,
                field: format!("answer to {name}"),
                recorded: text(recorded),
                computed: text(computed),
            })
        });
    }
}

/// Whether the control loop, or the design of its gains, gives this refusal; others are given by
/// the supervisor, the bus or a queue, of which no record has the state.
const fn is_by_loop(refusal: Refusal) -> bool {
    match refusal {
        Refusal::Beyond { .. }
        | Refusal::Experiment(_)
        | Refusal::Late { .. }
        | Refusal::TooSlow { .. }
        | Refusal::OutOfRange
        | Refusal::NoGains
        | Refusal::Unstable { .. }
        | Refusal::UnstableObserver { .. } => true,
        Refusal::Faulted
        | Refusal::NotReady
        | Refusal::NotOff
        | Refusal::Disarmed
        | Refusal::OtherSession
        | Refusal::Stale
        | Refusal::NotIdle
        | Refusal::NotSaved
        | Refusal::SettingsLost
        | Refusal::Hot { .. }
        | Refusal::EncoderUnknown { .. }
        | Refusal::BeyondLimit { .. }
        | Refusal::MotorsUnchecked
        | Refusal::Unprepared
        | Refusal::Passthrough
        | Refusal::TooFast { .. }
        | Refusal::OtherEncoder { .. }
        | Refusal::Busy => false,
    }
}
