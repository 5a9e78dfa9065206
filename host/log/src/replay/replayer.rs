//! Replayer: repeats all inputs of a board in their order, and tracks which of them are
//! known.

mod commands;
mod conclusions;

use std::collections::{BTreeMap, HashMap};

use armbridge_board::control_loop::reference::StartPoint;
use armbridge_client::event::{Direction, Event, EventKind};
use armbridge_client::refusal_text;
use armbridge_link::message::{Command, Mode, Record, Refusal, Settings, ToBoard, ToHost};

use self::conclusions::Conclusions;
use super::board::Board;
use super::compare;
use super::loss::Loss;
use super::pending::{PendingMessage, PendingMessages, Place, is_before};
use super::report::{Report, Tally};
use super::tick_facts::{self, HostEvent};
use super::what_if::{ChangeError, Changes, Sums};

/// Knowledge of the board's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Knowledge {
    /// Incomplete, for this reason.
    Part(Loss),
    /// The board has restarted, and is known completely from the first tick with all samples
    /// on; the reason holds until then.
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
#[expect(
    clippy::struct_excessive_bools,
    reason = "independent flags, valid until the next tick"
)]
pub struct Replayer {
    board: Board,
    /// Settings of the replay, and those of the board.
    settings: Settings,
    reported: Option<Settings>,
    changes: Changes,
    changed: BTreeMap<&'static str, String>,
    knowledge: Knowledge,
    /// The mode is unknown, also from the tick before.
    is_mode_unknown: bool,
    commands: HashMap<u16, Command>,
    start_points: HashMap<u16, StartPoint>,
    ended_by_goodbye: bool,
    pending: PendingMessages,
    conclusions: Conclusions,
    /// Latest record, processed when the next one has arrived: a message that precedes it
    /// may arrive just after it.
    pending_record: Option<Record>,
    /// The tick before, and the planned start of the next.
    last: Option<Record>,
    planned_us: u64,
    /// A fault has changed the planned start.
    is_stopped_by_fault: bool,
    /// Bring-up has changed the planned start.
    is_restarted_by_bring_up: bool,
    frames_lost: bool,
    /// Mode after the present tick, as recorded.
    recorded_mode: Mode,
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
            is_mode_unknown: true,
            commands: HashMap::new(),
            start_points: HashMap::new(),
            ended_by_goodbye: false,
            pending: PendingMessages::default(),
            conclusions: Conclusions::default(),
            pending_record: None,
            last: None,
            planned_us: 0,
            is_stopped_by_fault: false,
            is_restarted_by_bring_up: false,
            frames_lost: false,
            recorded_mode: Mode::Boot,
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
            EventKind::Sent(_, ToBoard::Goodbye) => self.ended_by_goodbye = true,
            EventKind::Received(sequence, message) => self.receive(sequence, message)?,
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
                self.pending.clear();
            }
            EventKind::Sent(_, ToBoard::Hello(_) | ToBoard::Heartbeat | ToBoard::Stop)
            | EventKind::Lost(Direction::ToBoard, _)
            | EventKind::Damaged(..) => {}
        }
        Ok(())
    }

    fn receive(&mut self, _sequence: u16, message: ToHost) -> Result<(), ReplayError> {
        match message {
            ToHost::Record(record) => {
                let pending_record = self.pending_record.replace(record);
                pending_record.map_or(Ok(()), |pending_record| self.tick(&pending_record))?;
            }
            ToHost::Ack {
                sequence,
                result,
                moment: Some(moment),
            } => self.pending.push(PendingMessage::Ack {
                sequence,
                result,
                moment,
            }),
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
                self.pending
                    .push(PendingMessage::Departs { sequence, moment });
            }
            ToHost::Began(moment) => {
                let newest = self.pending_record.or(self.last);
                if newest.is_some_and(|record| is_before(moment.tick, record.tick)) {
                    self.flush()?;
                    self.lose(Loss::Restart, 0);
                    self.last = None;
                }
                self.pending.push(PendingMessage::Began {
                    moment,
                    settings: self.reported,
                    ended_by_goodbye: std::mem::take(&mut self.ended_by_goodbye),
                });
            }
            ToHost::Settings(settings) => self.reported = Some(settings),
            ToHost::Found {
                firmware,
                baud,
                is_ready,
            } => self.pending.push(PendingMessage::Found {
                firmware,
                baud,
                is_ready,
            }),
            ToHost::Passthrough => self.pending.push(PendingMessage::Passthrough),
            ToHost::Tripped(trip) => self.pending.push(PendingMessage::Tripped(trip)),
            ToHost::Concluded(conclusion) => self.conclusions.receive(conclusion),
            ToHost::Hello(_)
            | ToHost::Absent { .. }
            | ToHost::Mixed(_)
            | ToHost::Unprepared { .. }
            | ToHost::Port(_)
            | ToHost::Board(_)
            | ToHost::Off(_)
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
        while let Some(message) = self.pending.next(Place::End, true) {
            self.apply(&message)?;
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
        self.pending_record
            .take()
            .map_or(Ok(()), |pending_record| self.tick(&pending_record))
    }

    /// Marks the state as incomplete, after this many missing ticks.
    fn lose(&mut self, reason: Loss, missing: u32) {
        let next = self.last.map_or(0, |last| last.tick.wrapping_add(1));
        self.tally
            .lose(reason, next.wrapping_sub(missing), missing.into());
        self.knowledge = Knowledge::Part(reason);
        self.is_mode_unknown = true;
    }

    /// The board restarted: earlier events have no effect.
    fn restart(&mut self) {
        if let Knowledge::Part(reason) = self.knowledge {
            self.knowledge = Knowledge::Restarted(reason);
        }
    }

    fn begin_ticking(&mut self) {
        self.board.begin_ticking();
        self.is_restarted_by_bring_up = true;
        // Where the mode is not known, bring-up may be long past.
        if !self.is_mode_unknown {
            self.restart();
        }
    }

    fn is_known(&self) -> bool {
        self.knowledge == Knowledge::Full
    }

    /// Replays everything up to the decision of this record's tick, and compares.
    fn tick(&mut self, record: &Record) -> Result<(), ReplayError> {
        self.tally.records += 1;
        self.recorded_mode = record.mode;
        let is_off_schedule = self.last.is_some_and(|last| {
            let is_planned = matches!(last.mode, Mode::Fault(_)) || self.is_stopped_by_fault;
            !is_planned && tick_facts::planned_us(record) != self.planned_us
        });
        let is_due = is_off_schedule || self.tally.records == 1;
        // What ends the ticks is followed by bring-up, which has no tick of its own.
        while let Some(message) = {
            let is_due = is_due || !self.board.is_ticking();
            self.pending.next(Place::Between(record), is_due)
        } {
            self.apply(&message)?;
        }
        self.detect_gap(record);
        if !self.board.is_ticking() {
            self.begin_ticking();
        } else if is_off_schedule
            && self.is_known()
            && !self.is_stopped_by_fault
            && !self.is_restarted_by_bring_up
        {
            let event = "another client had the bus for a while".into();
            self.tally.count_adopted(event, record.tick);
            self.board.begin_again();
        }
        (self.is_stopped_by_fault, self.is_restarted_by_bring_up) = (false, false);
        self.apply_goodbye(record);
        self.board.begin(record);
        self.planned_us = self.board.planned_us();
        while let Some(message) = self.pending.next(Place::Within(record), false) {
            self.apply(&message)?;
        }
        self.decide(record);
        self.check_conclusions(record);
        let since_us = self.last.map_or(0, |last| {
            let lasts_us = record.start_us.saturating_sub(last.start_us);
            // Without the time between two runs of a board.
            lasts_us.min(1_000_000)
        });
        self.tally.span_us += since_us;
        self.last = Some(*record);
        Ok(())
    }

    fn detect_gap(&mut self, record: &Record) {
        let Some(last) = self.last.as_mut() else {
            return;
        };
        let before = record.tick.wrapping_sub(1);
        let missing = before.wrapping_sub(std::mem::replace(&mut last.tick, before));
        let dropped = record.dropped.wrapping_sub(last.dropped);
        let is_reported = std::mem::take(&mut self.frames_lost);
        // A tick is not decided if the bus is handed over within it.
        let is_handed_over = missing == 1 && !self.board.is_ticking();
        if missing == 0 || is_handed_over {
            return;
        }
        if is_reported {
            self.lose(Loss::Frames, missing);
        } else if dropped > 0 {
            self.lose(Loss::Dropped, missing);
        } else {
            self.lose(Loss::Records, missing);
        }
    }

    fn decide(&mut self, record: &Record) {
        let is_known = self.is_known();
        if !is_known {
            if self.is_mode_unknown {
                self.board.assume(record);
            }
            self.board.assume_before(record);
        }
        let event = self.board.host_event(record.mode);
        let computed = self.board.decide(record, event);
        match self.knowledge {
            Knowledge::Restarted(_)
                if tick_facts::is_complete(record) && tick_facts::is_off(record) =>
            {
                self.knowledge = Knowledge::Full;
            }
            Knowledge::Restarted(reason) | Knowledge::Part(reason) => {
                // It restarted under a torque that is not known.
                if tick_facts::is_complete(record) {
                    self.knowledge = Knowledge::Part(reason);
                }
            }
            Knowledge::Full => {}
        }
        self.is_mode_unknown = false;
        if let Knowledge::Restarted(reason) | Knowledge::Part(reason) = self.knowledge {
            self.tally.skip(reason, record.tick);
            self.board.resume_from(record);
            return;
        }
        let ended_by_board = self
            .conclusions
            .ended_by_board(&mut self.board, record.tick);
        if !ended_by_board {
            self.count_host_event(event, record);
        }
        self.tally.compared += 1;
        if !compare::same(record, &computed) {
            self.tally.differing += 1;
            self.tally.differ(|| compare::difference(record, &computed));
        }
        if !self.changes.is_empty() {
            self.sums.add(record, &computed);
        }
    }

    fn count_host_event(&mut self, event: HostEvent, record: &Record) {
        let text = match event {
            HostEvent::None => return,
            HostEvent::Silence => "the host was silent: braked, or torque off",
            HostEvent::LongSilence => "the host was silent for too long: fault host_silent",
            HostEvent::Corruption => "memory was corrupted: fault corrupted",
        };
        self.tally.count_adopted(text.into(), record.tick);
    }
}
