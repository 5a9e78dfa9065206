//! Replayer: repeats the inputs of a board in their order, and tracks whether its state is
//! known.

mod answers;
mod state;

use std::collections::{BTreeMap, HashMap};

use armbridge_board::tick::reference::StartPoint;
use armbridge_client::event::{Direction, Event, EventKind};
use armbridge_client::refusal_text;
use armbridge_link::message::{Command, Moment, Record, Refusal, Settings, ToBoard, ToHost};
use armbridge_servo::Pwm;

use super::board::Board;
use super::compare;
use super::edits::{Edit, Edits, is_before};
use super::loss::Loss;
use super::report::{Report, Tally};
use super::what_if::{self, ChangeError, Changes, Sums};

/// Knowledge of the loop's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Knowledge {
    /// Incomplete, for this reason.
    Part(Loss),
    /// A hello or arming has restarted the loop: known from the first tick on that has all
    /// samples, with motors off. The reason holds until then.
    Restarted(Loss),
    /// Complete.
    Full,
}

/// Reason for which a log cannot be replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReplayError {
    /// The other settings are not valid.
    #[error(transparent)]
    Change(#[from] ChangeError),
    /// There is no controller for them.
    #[error("the board would not take these settings: {}", refusal_text::in_words(*.0))]
    Settings(Refusal),
}

/// Replays a log, event by event, in little memory.
pub struct Replayer {
    board: Board,
    /// Settings of the replay, and those last reported by the board.
    settings: Settings,
    reported: Option<Settings>,
    changes: Changes,
    changed: BTreeMap<&'static str, String>,
    knowledge: Knowledge,
    commands: HashMap<u16, Command>,
    start_points: HashMap<u16, StartPoint>,
    edits: Edits,
    /// Latest record, processed when the next one has arrived: a message that precedes it
    /// may arrive just after it.
    waiting: Option<Record>,
    last: Option<Record>,
    frames_lost: bool,
    tally: Tally,
    sums: Sums,
}

impl Replayer {
    /// A replay with the recorded settings, and these changes.
    ///
    /// # Errors
    /// If there is no controller for the default settings.
    pub fn new(changes: Changes) -> Result<Self, ReplayError> {
        let settings = Settings::default();
        Ok(Self {
            board: Board::new(&settings).map_err(ReplayError::Settings)?,
            settings,
            reported: None,
            changes,
            changed: BTreeMap::new(),
            knowledge: Knowledge::Part(Loss::NoHello),
            commands: HashMap::new(),
            start_points: HashMap::new(),
            edits: Edits::default(),
            waiting: None,
            last: None,
            frames_lost: false,
            tally: Tally::default(),
            sums: Sums::default(),
        })
    }

    /// Processes the next event of the link.
    ///
    /// # Errors
    /// If the changed settings are not valid.
    pub fn take(&mut self, event: &Event) -> Result<(), ReplayError> {
        match event.kind {
            EventKind::Sent(sequence, ToBoard::Command(command)) => {
                self.commands.insert(sequence, command);
            }
            EventKind::Received(_, message) => self.receive(&message)?,
            EventKind::Lost(Direction::ToHost, frames) => {
                self.flush()?;
                self.lose(Loss::Frames, 0);
                self.frames_lost = frames > 0;
            }
            EventKind::Disconnected => {
                self.flush()?;
                self.lose(Loss::Disconnection, 0);
                self.commands.clear();
                self.start_points.clear();
                self.edits.clear();
            }
            EventKind::Sent(
                _,
                ToBoard::Hello(_) | ToBoard::Heartbeat | ToBoard::Stop | ToBoard::Goodbye,
            )
            | EventKind::Lost(Direction::ToBoard, _)
            | EventKind::Damaged(..) => {}
        }
        Ok(())
    }

    fn receive(&mut self, message: &ToHost) -> Result<(), ReplayError> {
        match *message {
            ToHost::Record(record) => {
                if let Some(waiting) = self.waiting.replace(record) {
                    self.tick(&waiting)?;
                }
            }
            ToHost::Ack {
                sequence,
                result,
                moment: Some(moment),
            } => self.edits.push(moment, Edit::Answer { sequence, result }),
            // It never reached the tick, unless it is a copy of one that did.
            ToHost::Ack {
                sequence,
                result,
                moment: None,
            } => {
                if result != Err(Refusal::Stale) {
                    self.commands.remove(&sequence);
                    self.start_points.remove(&sequence);
                }
            }
            ToHost::Departs { sequence, moment } => {
                self.edits.push(moment, Edit::Departs { sequence });
            }
            ToHost::Began(moment) => {
                let newest = self.waiting.or(self.last);
                if newest.is_some_and(|record| is_before(moment.tick, record.tick)) {
                    self.flush()?;
                    self.lose(Loss::Restart, 0);
                    self.last = None;
                }
                let settings = self.reported.map(Box::new);
                self.edits.push(moment, Edit::Began { settings });
            }
            ToHost::Settings(settings) => self.reported = Some(settings),
            ToHost::Hello(_)
            | ToHost::Absent { .. }
            | ToHost::Found { .. }
            | ToHost::Mixed(_)
            | ToHost::Unprepared { .. }
            | ToHost::Passthrough
            | ToHost::Port(_)
            | ToHost::Board(_)
            | ToHost::Tripped(_)
            | ToHost::Off(_)
            | ToHost::Concluded(_)
            | ToHost::Temperature { .. } => {}
        }
        Ok(())
    }

    /// Ends the replay.
    ///
    /// # Errors
    /// If the changed settings are not valid.
    pub fn finish(mut self) -> Result<Report, ReplayError> {
        self.flush()?;
        let acts_us = self.last.map_or(0, |last| last.input.acts_us());
        while let Some((moment, edit)) = self.edits.next(None) {
            self.apply(moment, edit, acts_us)?;
        }
        let what_if = (!self.changes.is_empty())
            .then(|| self.sums.result(self.changed, self.tally.answers_differing));
        Ok(self.tally.report(self.commands.len() as u64, what_if))
    }

    /// Records read so far.
    pub fn records(&self) -> u64 {
        self.tally.records
    }

    fn flush(&mut self) -> Result<(), ReplayError> {
        let waiting = self.waiting.take();
        waiting.map_or(Ok(()), |record| self.tick(&record))
    }

    /// Marks the state as incomplete, after this many missing ticks.
    fn lose(&mut self, reason: Loss, missing: u32) {
        let next = self.last.map_or(0, |last| last.tick.wrapping_add(1));
        self.tally
            .lose(reason, next.wrapping_sub(missing), missing.into());
        self.knowledge = Knowledge::Part(reason);
    }

    /// Replays everything up to the decision of this record's tick, and compares.
    fn tick(&mut self, record: &Record) -> Result<(), ReplayError> {
        self.tally.records += 1;
        while let Some((moment, edit)) = self.edits.next(Some(record.tick)) {
            let begun = self.last.filter(|_| moment.tick != record.tick);
            let acts_us = begun.unwrap_or(*record).input.acts_us();
            self.apply(moment, edit, acts_us)?;
        }
        self.detect_gap(record);
        self.decide(record);
        let since_us = self.last.map_or(0, |last| {
            let lasts_us = record.input.start_us.saturating_sub(last.input.start_us);
            // Without the time between two runs of a board.
            lasts_us.min(1_000_000)
        });
        self.tally.span_us += since_us;
        self.last = Some(*record);
        Ok(())
    }

    fn detect_gap(&mut self, record: &Record) {
        let Some(last) = self.last else {
            return;
        };
        let missing = record.tick.wrapping_sub(1).wrapping_sub(last.tick);
        let dropped = record.dropped.wrapping_sub(last.dropped);
        let is_reported = std::mem::take(&mut self.frames_lost);
        // A tick within which the bus is handed over is not decided, and bring-up follows.
        let is_handed_over = missing == 1 && record.input.is_first;
        if missing == 0 || is_handed_over {
            return;
        }
        let reason = match dropped {
            _ if is_reported => Loss::Frames,
            0 => Loss::Records,
            _ => Loss::Dropped,
        };
        self.last = Some(Record {
            tick: record.tick.wrapping_sub(1),
            ..last
        });
        self.lose(reason, missing);
    }

    /// The loop restarts: earlier edits have no effect.
    fn restart(&mut self) {
        if let Knowledge::Part(reason) = self.knowledge {
            self.knowledge = Knowledge::Restarted(reason);
        }
    }

    fn decide(&mut self, record: &Record) {
        // Bring-up restarts the loop, with motors off.
        if record.input.is_first && self.reported.is_some() {
            self.knowledge = Knowledge::Full;
        }
        let is_off = record.input.pwm_in_force == [Pwm::OFF.counts(); 2];
        let mut input = record.input;
        if !self.changes.is_empty() && !is_off {
            input.pwm_in_force = self.board.pwm();
        }
        let decided = self.board.pwm();
        let is_sent = is_off || input.pwm_in_force == decided;
        let output = self.board.step(&input);
        let is_complete = input.samples.iter().all(|sample| sample.counts().is_some());
        match self.knowledge {
            Knowledge::Restarted(_) if is_complete && is_off => self.knowledge = Knowledge::Full,
            // A torque that is not known is part of the first estimate.
            Knowledge::Restarted(reason) if is_complete => {
                self.knowledge = Knowledge::Part(reason);
            }
            Knowledge::Full | Knowledge::Part(_) | Knowledge::Restarted(_) => {}
        }
        if let Knowledge::Part(reason) | Knowledge::Restarted(reason) = self.knowledge {
            self.tally.skip(reason, record.tick);
            return;
        }
        self.tally.compared += 1;
        if !(is_sent && compare::is_same(&record.output, &output)) {
            self.tally.differing += 1;
            self.tally
                .differ(|| compare::difference(record, decided, &output));
        }
        if !self.changes.is_empty() {
            self.sums.add(record, &output);
        }
    }

    /// Applies an edit whose place has come; the tick under way acts at `acts_us`.
    fn apply(&mut self, moment: Moment, edit: Edit, acts_us: u64) -> Result<(), ReplayError> {
        match edit {
            Edit::Answer { sequence, result } => {
                self.apply_answer(sequence, result, moment, acts_us)
            }
            Edit::Departs { sequence } => {
                let start_point = self.board.start_point(moment, acts_us);
                self.start_points.insert(sequence, start_point);
                Ok(())
            }
            Edit::Began { settings } => self.began(moment, settings.as_deref()),
        }
    }

    fn began(&mut self, moment: Moment, reported: Option<&Settings>) -> Result<(), ReplayError> {
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
        let Some(reported) = reported else {
            return Ok(());
        };
        let settings = self.changes.apply(reported)?;
        self.changed.extend(what_if::changed(reported, &settings));
        if settings != self.settings {
            self.board = Board::new(&settings).map_err(ReplayError::Settings)?;
            self.settings = settings;
        }
        self.board.begin_session(moment.mode);
        if moment.mode.drive().is_none() {
            self.restart();
        }
        Ok(())
    }
}
