//! Commands and messages, each replayed at its place.

use armbridge_client::enum_names;
use armbridge_client::refusal_text;
use armbridge_link::message::{Command, Fault, Mode, Moment, Record, Refusal, Settings, Trip};

use super::super::compare::Difference;
use super::super::loss::Loss;
use super::super::pending::{PendingMessage, is_before};
use super::super::tick_facts;
use super::super::what_if;
use super::{ReplayError, Replayer};

impl Replayer {
    /// Replays a message whose place has come.
    pub(super) fn apply(&mut self, message: &PendingMessage) -> Result<(), ReplayError> {
        match *message {
            PendingMessage::Ack {
                sequence,
                result,
                moment,
            } => self.apply_answer(sequence, result, moment),
            PendingMessage::Departs { sequence, moment } => {
                match self.board.start_point(moment) {
                    Ok(start_point) => {
                        self.start_points.insert(sequence, start_point);
                    }
                    Err(refusal) => self.check_answer("follow", moment, Ok(()), Err(refusal)),
                }
                Ok(())
            }
            PendingMessage::Began {
                moment,
                settings,
                ended_by_goodbye,
            } => self.began(moment, settings, ended_by_goodbye),
            PendingMessage::Tripped(trip) => {
                self.tripped(&trip);
                Ok(())
            }
            PendingMessage::Found {
                firmware,
                baud,
                is_ready,
            } => {
                self.board.set_line(firmware, baud, is_ready);
                if !self.board.is_ticking() {
                    self.begin_ticking();
                }
                Ok(())
            }
            PendingMessage::Passthrough => {
                if self.board.mode() != Mode::Passthrough {
                    let tick = self.last.map_or(0, |last| last.tick);
                    let event = "a client of the transparent port took the bus".into();
                    self.tally.count_adopted(event, tick);
                    self.board.hand_over();
                }
                Ok(())
            }
        }
    }

    fn began(
        &mut self,
        moment: Moment,
        reported: Option<Settings>,
        ended_by_goodbye: bool,
    ) -> Result<(), ReplayError> {
        // The last tick that was decided before the hello.
        let decided = moment.tick.wrapping_sub(u32::from(!moment.is_decided));
        if let Some(last) = self
            .last
            .as_mut()
            .filter(|last| is_before(last.tick, decided))
        {
            let missing = decided.wrapping_sub(last.tick);
            last.tick = decided;
            self.lose(Loss::NoSession, missing);
        } else if self.last.is_none() && decided > 0 {
            self.lose(Loss::BeforeHello, 0);
        }
        if self.is_mode_unknown {
            self.board.forget();
        } else if ended_by_goodbye {
            self.board.goodbye();
        }
        if let Some(reported) = reported {
            let settings = self.changes.apply(&reported)?;
            self.changed.extend(what_if::changed(&reported, &settings));
            if settings != self.settings {
                self.board.set(&settings).map_err(ReplayError::Settings)?;
                self.settings = settings;
            }
            self.board.begin_session(moment);
            self.restart();
        }
        Ok(())
    }

    /// A goodbye is not acknowledged. One just before a tick shows in it: the
    /// motors were driven until then, and are off from its beginning.
    pub(super) fn apply_goodbye(&mut self, record: &Record) {
        let is_driven = self.board.mode().drive().is_some();
        if is_driven && tick_facts::is_off(record) && self.pending.has_goodbye(record) {
            self.board.goodbye();
        }
    }

    /// A command was accepted or refused, with this reply.
    fn apply_answer(
        &mut self,
        sequence: u16,
        result: Result<(), Refusal>,
        moment: Moment,
    ) -> Result<(), ReplayError> {
        let start_point = self.start_points.remove(&sequence);
        let Some(command) = self.commands.remove(&sequence) else {
            // A refused command has no effect.
            if result.is_ok() {
                self.lose(Loss::OtherHost, 0);
            }
            return Ok(());
        };
        if result.is_err() && !self.is_known() {
            return Ok(());
        }
        let command = self.change(command)?;
        let before = self.board.mode();
        let computed = match (command, start_point) {
            (Command::Follow(motion), Some(start_point)) => {
                self.board.follow(&motion, start_point, moment)
            }
            (Command::Follow(_), None) => self.board.start_point(moment).map(|_| ()),
            (command, _) => self.board.command(command, moment, result),
        };
        let is_check_begun = before == Mode::Idle && self.board.mode() == Mode::MotorCheck;
        if is_check_begun && self.recorded_mode.is_armed() && self.recorded_mode != Mode::MotorCheck
        {
            let event = "the motors had been checked before".into();
            self.tally.count_adopted(event, moment.tick);
            self.board.skip_motor_check();
        }
        if computed.is_ok() {
            match command {
                Command::Configure(setup) => self.settings.setup = setup,
                Command::Limit(limits) => self.settings.limits = limits,
                _ => {}
            }
        }
        let after = self.board.mode();
        let is_energised = match before {
            Mode::Idle => after == Mode::MotorCheck || after == Mode::Armed,
            Mode::Armed => after.drive().is_some(),
            _ => false,
        };
        if is_energised {
            self.restart();
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
        if !self.is_known() {
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

    /// The cause of a fault: one from outside the tick is applied here, any other must
    /// have been computed.
    fn tripped(&mut self, trip: &Trip) {
        self.is_stopped_by_fault = true;
        if tick_facts::is_external(trip.fault) {
            if !matches!(self.board.mode(), Mode::Fault(_)) {
                let event = format!("fault {}", enum_names::fault(trip.fault));
                self.tally.count_adopted(event, trip.tick);
                self.board.trip(trip);
            }
            return;
        }
        // The moment at which silence was detected is not known, nor that of corruption.
        let is_checked = !matches!(trip.fault, Fault::HostSilent | Fault::Corrupted);
        // Repeated after a hello, it may be older than the known state.
        let is_known = self.is_known() && is_checked;
        let cause = self.board.cause();
        let Some(cause) = cause.filter(|cause| is_known && cause.tick == trip.tick) else {
            return;
        };
        self.tally.answers += 1;
        let values = |trip: &Trip| {
            let bits = [trip.value, trip.limit].map(f32::to_bits);
            (trip.fault, trip.joint, trip.tick, bits)
        };
        if values(trip) != values(&cause) {
            self.tally.answers_differing += 1;
            let text = |trip: &Trip| {
                let Trip {
                    joint,
                    value,
                    limit,
                    ..
                } = trip;
                let fault = enum_names::fault(trip.fault);
                let joint = joint.map_or_else(String::new, |joint| {
                    format!(" of joint {}", u16::from(joint) + 1)
                });
                // Enough digits to distinguish two neighbouring numbers.
                format!("{fault}{joint}, {value:?} beyond {limit:?}")
            };
            self.tally.differ(|| {
                Some(Difference {
                    tick: trip.tick,
                    start_us: trip.at_us,
                    field: "reason of the fault".into(),
                    recorded: text(trip),
                    computed: text(&cause),
                })
            });
        }
    }
}
