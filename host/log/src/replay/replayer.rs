//! Events in, ticks out: does everything again in the order in which the board did
//! it, and knows what it does not know.

mod commands;
mod conclusions;

use std::collections::HashMap;

use armbridge_client::event::{Direction, Event, EventKind};
use armbridge_client::refusal_text;
use armbridge_shared::control_loop::reference::StartPoint;
use armbridge_shared::link::message::{Command, Mode, Record, Refusal, Settings, ToBoard, ToHost};

use self::conclusions::Conclusions;
use super::board::Board;
use super::compare;
use super::pending::{Note, Notes, Place, is_before};
use super::report::{Report, Tally};
use super::tick_facts::{self, HostEvent};
use super::what_if::{ChangeError, Changes, Sums};

/// How much is known of the board.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Knowledge {
    /// Less than all, for this reason.
    Part(String),
    /// It has begun anew, and is known entirely from the first tick with all samples
    /// on; until then this is why not.
    Anew(String),
    /// Everything.
    Full,
}

/// Why a log cannot be replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReplayError {
    /// The other settings make no sense.
    #[error(transparent)]
    Change(#[from] ChangeError),
    /// There is no controller for them.
    #[error("the board would not take these settings: {}", refusal_text::in_words(*.0))]
    Settings(Refusal),
}

/// Replays a log, event by event, in little memory.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each says something else that is true until the next tick"
)]
pub struct Replayer {
    board: Board,
    /// What the replay computes with, and what the board told.
    settings: Settings,
    told: Option<Settings>,
    changes: Changes,
    changed: Vec<String>,
    knowledge: Knowledge,
    /// Nothing is known of the mode, not even from the tick before.
    is_strange: bool,
    asked: HashMap<u16, Command>,
    departures: HashMap<u16, StartPoint>,
    has_left: bool,
    notes: Notes,
    conclusions: Conclusions,
    /// A record is looked at when the next has come: what belongs before it may come
    /// just after it.
    held: Option<Record>,
    /// The tick before, and when the next was planned then.
    last: Option<Record>,
    planned_us: u64,
    /// A fault has changed the plan since.
    is_stopped: bool,
    /// So has bring-up.
    is_lined_up: bool,
    frames_lost: bool,
    tally: Tally,
    sums: Sums,
}

impl Replayer {
    /// Replays with the recorded settings, changed by these.
    ///
    /// # Errors
    /// If there is no controller for the default settings.
    pub fn new(changes: Changes) -> Result<Self, ReplayError> {
        let settings = Settings::default();
        Ok(Self {
            board: Board::new(&settings).map_err(ReplayError::Settings)?,
            settings,
            told: None,
            changes,
            changed: Vec::new(),
            knowledge: Knowledge::Part("the log begins without a hello".into()),
            is_strange: true,
            asked: HashMap::new(),
            departures: HashMap::new(),
            has_left: false,
            notes: Notes::default(),
            conclusions: Conclusions::default(),
            held: None,
            last: None,
            planned_us: 0,
            is_stopped: false,
            is_lined_up: false,
            frames_lost: false,
            tally: Tally::default(),
            sums: Sums::default(),
        })
    }

    /// Takes what happened next on the link.
    ///
    /// # Errors
    /// If settings cannot be changed as asked for.
    pub fn take(&mut self, event: &Event) -> Result<(), ReplayError> {
        match event.kind {
            EventKind::Sent(sequence, ToBoard::Command(command)) => {
                self.asked.insert(sequence, command);
            }
            EventKind::Sent(_, ToBoard::Goodbye) => self.has_left = true,
            EventKind::Received(sequence, message) => self.receive(sequence, message)?,
            EventKind::Lost(Direction::ToHost, frames) => {
                self.flush()?;
                self.lose("frames of the board were lost on the link", 0);
                self.frames_lost = frames > 0;
            }
            EventKind::Disconnected => {
                self.flush()?;
                self.lose("the connection broke", 0);
                self.asked.clear();
                self.departures.clear();
                self.notes.clear();
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
                let held = self.held.replace(record);
                held.map_or(Ok(()), |held| self.tick(&held))?;
            }
            ToHost::Ack {
                sequence,
                result,
                moment: Some(moment),
            } => self.notes.push(Note::Ack {
                sequence,
                result,
                moment,
            }),
            // It never got to the tick, if it is not a copy of one that may have.
            ToHost::Ack {
                sequence,
                result,
                moment: None,
            } => {
                if result != Err(Refusal::Stale) {
                    self.asked.remove(&sequence);
                    self.departures.remove(&sequence);
                }
            }
            ToHost::Departs { sequence, moment } => {
                self.notes.push(Note::Departs { sequence, moment });
            }
            ToHost::Began(moment) => {
                let newest = self.held.or(self.last);
                if newest.is_some_and(|record| is_before(moment.tick, record.tick)) {
                    self.flush()?;
                    self.lose("the board began anew", 0);
                    self.last = None;
                }
                self.notes.push(Note::Began {
                    moment,
                    settings: self.told,
                    has_left: std::mem::take(&mut self.has_left),
                });
            }
            ToHost::Settings(settings) => self.told = Some(settings),
            ToHost::Found {
                firmware,
                baud,
                is_ready,
            } => self.notes.push(Note::Found {
                firmware,
                baud,
                is_ready,
            }),
            ToHost::Passthrough => self.notes.push(Note::Passthrough),
            ToHost::Tripped(trip) => self.notes.push(Note::Tripped(trip)),
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
    /// If settings cannot be changed as asked for.
    pub fn finish(mut self) -> Result<Report, ReplayError> {
        self.flush()?;
        while let Some(note) = self.notes.next(Place::End, true) {
            self.apply(&note)?;
        }
        let what_if = (!self.changes.is_empty())
            .then(|| self.sums.result(self.changed, self.tally.answers_differing));
        Ok(self.tally.report(self.asked.len() as u64, what_if))
    }

    /// Records read so far.
    pub fn records(&self) -> u64 {
        self.tally.records
    }

    fn flush(&mut self) -> Result<(), ReplayError> {
        self.held.take().map_or(Ok(()), |held| self.tick(&held))
    }

    /// Something is not known any more, with so many ticks before the next.
    fn lose(&mut self, reason: &str, missing: u32) {
        let next = self.last.map_or(0, |last| last.tick.wrapping_add(1));
        self.tally
            .lose(reason, next.wrapping_sub(missing), missing.into());
        self.knowledge = Knowledge::Part(reason.to_owned());
        self.is_strange = true;
    }

    /// The board began anew: nothing of before matters.
    fn begin_anew(&mut self) {
        if let Knowledge::Part(reason) = &mut self.knowledge {
            self.knowledge = Knowledge::Anew(std::mem::take(reason));
        }
    }

    fn begin_ticking(&mut self) {
        self.board.begin_ticking();
        self.is_lined_up = true;
        // Where the mode is not known, bring-up may have been long ago.
        if !self.is_strange {
            self.begin_anew();
        }
    }

    fn is_known(&self) -> bool {
        self.knowledge == Knowledge::Full
    }

    /// Everything up to the decision of this record's tick, and what comes of it.
    fn tick(&mut self, record: &Record) -> Result<(), ReplayError> {
        self.tally.records += 1;
        let is_elsewhere = self.last.is_some_and(|last| {
            let is_planned = matches!(last.mode, Mode::Fault(_)) || self.is_stopped;
            !is_planned && tick_facts::planned_us(record) != self.planned_us
        });
        let is_due = is_elsewhere || !self.board.is_ticking() || self.tally.records == 1;
        while let Some(note) = self.notes.next(Place::Between(record), is_due) {
            self.apply(&note)?;
        }
        self.look_for_gap(record);
        if !self.board.is_ticking() {
            self.begin_ticking();
        } else if is_elsewhere && self.is_known() && !self.is_stopped && !self.is_lined_up {
            let what = "the bus was somebody else's for a while".into();
            self.tally.count_adopted(what, record.tick);
            self.board.begin_again();
        }
        (self.is_stopped, self.is_lined_up) = (false, false);
        self.apply_goodbye(record);
        self.board.begin(record);
        self.planned_us = self.board.planned_us();
        while let Some(note) = self.notes.next(Place::Within(record), false) {
            self.apply(&note)?;
        }
        self.decide(record);
        self.check_conclusions(record);
        let since_us = self.last.map_or(0, |last| {
            let lasts_us = record.start_us.saturating_sub(last.start_us);
            // Not what lies between two runs of a board.
            lasts_us.min(1_000_000)
        });
        self.tally.span_us += since_us;
        self.last = Some(*record);
        Ok(())
    }

    fn look_for_gap(&mut self, record: &Record) {
        let Some(last) = self.last.as_mut() else {
            return;
        };
        let before = record.tick.wrapping_sub(1);
        let missing = before.wrapping_sub(std::mem::replace(&mut last.tick, before));
        let dropped = record.dropped.wrapping_sub(last.dropped);
        let is_told = std::mem::take(&mut self.frames_lost);
        // A tick is never decided if the bus is given away in the middle of it.
        let is_given_away = missing == 1 && !self.board.is_ticking();
        if missing == 0 || is_given_away {
            return;
        }
        if is_told {
            self.lose("frames of the board were lost on the link", missing);
        } else if dropped > 0 {
            self.lose("the board dropped records that nobody fetched", missing);
        } else {
            self.lose("records are missing in the log", missing);
        }
    }

    fn decide(&mut self, record: &Record) {
        let is_known = self.is_known();
        if !is_known {
            if self.is_strange {
                self.board.assume(record);
            }
            self.board.assume_before(record);
        }
        let heard = self.board.host_event(record.mode);
        let computed = self.board.decide(record, heard);
        match &self.knowledge {
            Knowledge::Anew(_) if tick_facts::is_complete(record) && tick_facts::is_off(record) => {
                self.knowledge = Knowledge::Full;
            }
            Knowledge::Anew(reason) | Knowledge::Part(reason) => {
                // It began anew under a torque that is not known.
                if tick_facts::is_complete(record) {
                    self.knowledge = Knowledge::Part(reason.clone());
                }
            }
            Knowledge::Full => {}
        }
        self.is_strange = false;
        if let Knowledge::Anew(reason) | Knowledge::Part(reason) = &self.knowledge {
            self.tally.skip(reason, record.tick);
            self.board.resume_from(record);
            return;
        }
        let is_by_itself = self.conclusions.is_by_itself(&mut self.board, record.tick);
        if !is_by_itself {
            self.note_heard(heard, record);
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

    fn note_heard(&mut self, heard: HostEvent, record: &Record) {
        let what = match heard {
            HostEvent::Nothing => return,
            HostEvent::Silence => "the host was silent: braked, or let go",
            HostEvent::LongSilence => "the host was silent for too long: fault host_silent",
            HostEvent::Corruption => "numbers in memory changed: fault corrupted",
        };
        self.tally.count_adopted(what.into(), record.tick);
    }
}
