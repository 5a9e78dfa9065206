//! Events of a run: commands, pushes, faults, modes, and messages of the board and the link.
//! The list is bounded for each kind; further ones are counted.

use std::collections::VecDeque;

use armbridge_client::event::EventKind;
use armbridge_client::{fault_text, params, refusal_text};
use armbridge_link::message::{Command, Mode, Moment, Refusal, Settings, ToBoard, ToHost, Trip};
use armbridge_log::event_text;
use armbridge_log::proto::Severity;
use armbridge_log::time_origin::RunTimes;
use serde::Serialize;

use super::sent::Sent;
use crate::plan_runner::action_text::command_text;

/// Limit of the commands: those of an hour with one every two seconds.
const COMMANDS_MAX: usize = 2_000;
/// Limit of each other kind.
const OTHERS_MAX: usize = 300;
/// Commands among which that of an acknowledgement is sought.
const UNANSWERED_MAX: usize = 32;
/// Settings of one command that are named.
const NAMED_MAX: usize = 3;

/// Kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    Command,
    Push,
    Fault,
    Mode,
    Board,
    Link,
}

/// Importance of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Level {
    Info,
    Warning,
    Error,
}

/// An event of the list.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Listed {
    /// In s.
    pub(super) time: f64,
    pub(super) kind: Kind,
    pub(super) level: Level,
    pub(super) text: String,
}

/// The list so far.
#[derive(Debug, Default)]
pub(super) struct EventList {
    listed: Vec<Listed>,
    counts: [usize; 6],
    left_out: usize,
    sent: VecDeque<Sent>,
    settings: Option<Settings>,
    mode: Option<Mode>,
    trip: Option<Trip>,
}

impl EventList {
    /// Adds an event other than a record.
    pub(super) fn add(&mut self, kind: &EventKind, times: &RunTimes) {
        let now_s = times.now_s();
        match kind {
            EventKind::Sent(sequence, ToBoard::Command(command)) => {
                self.command(*sequence, *command, now_s);
            }
            EventKind::Sent(_, ToBoard::Stop) => {
                self.push(
                    now_s,
                    Kind::Command,
                    Level::Warning,
                    "emergency stop".into(),
                );
            }
            EventKind::Received(_, ToHost::Settings(settings)) => self.settings = Some(*settings),
            EventKind::Received(
                _,
                ToHost::Ack {
                    sequence,
                    result,
                    moment,
                },
            ) => self.acknowledge(*sequence, *result, *moment, times),
            // It is repeated after a hello.
            EventKind::Received(_, ToHost::Tripped(trip)) if self.trip == Some(*trip) => {}
            EventKind::Received(_, ToHost::Tripped(trip)) => {
                self.trip = Some(*trip);
                let time_s = times.at_us(trip.at_us);
                self.push(time_s, Kind::Fault, Level::Error, fault_in_words(trip));
            }
            EventKind::Received(_, message) => self.message(message, now_s),
            EventKind::Lost(_, frames) => self.link(now_s, &format!("{frames} frames are lost")),
            EventKind::Damaged(..) => self.link(now_s, "a frame is damaged"),
            EventKind::Disconnected => self.link(now_s, "the link broke"),
            EventKind::Sent(..) => {}
        }
    }

    /// Adds a change of the mode, if it is one; returns whether it is.
    pub(super) fn mode(&mut self, mode: Mode, now_s: f64) -> bool {
        if self.mode == Some(mode) {
            return false;
        }
        self.mode = Some(mode);
        let level = match mode {
            Mode::Fault(_) => Level::Error,
            Mode::Degraded(_) => Level::Warning,
            _ => Level::Info,
        };
        let (name, meaning) = fault_text::mode(mode);
        self.push(now_s, Kind::Mode, level, format!("{name}: {meaning}"));
        true
    }

    /// Adds ticks without records.
    pub(super) fn gap(&mut self, ticks: u32, now_s: f64) {
        self.link(now_s, &format!("{ticks} ticks are not in the log"));
    }

    /// Adds an event.
    pub(super) fn push(&mut self, time: f64, kind: Kind, level: Level, text: String) {
        let most = if kind == Kind::Command {
            COMMANDS_MAX
        } else {
            OTHERS_MAX
        };
        let count = &mut self.counts[kind as usize];
        if *count == most {
            self.left_out += 1;
            return;
        }
        *count += 1;
        self.listed.push(Listed {
            time,
            kind,
            level,
            text,
        });
    }

    /// The list in order of time, and the number of events that are not in it.
    pub(super) fn finish(mut self) -> (Vec<Listed>, usize) {
        self.listed.sort_by(|a, b| a.time.total_cmp(&b.time));
        (self.listed, self.left_out)
    }

    fn link(&mut self, now_s: f64, text: &str) {
        self.push(now_s, Kind::Link, Level::Warning, text.into());
    }

    fn message(&mut self, message: &ToHost, now_s: f64) {
        let (_, severity, text) = event_text::describe(message);
        let level = match severity {
            Severity::Debug => return,
            Severity::Info => Level::Info,
            Severity::Warning => Level::Warning,
            Severity::Error => Level::Error,
        };
        self.push(now_s, Kind::Board, level, text);
    }

    fn command(&mut self, sequence: u16, command: Command, now_s: f64) {
        if let Some(last) = self.sent.back_mut() {
            if last.is_open && last.command == command {
                last.repeat(sequence);
                return;
            }
            let is_stream = matches!(
                (last.command, command),
                (Command::Stream { .. }, Command::Stream { .. })
            );
            if is_stream {
                last.stream(sequence, command);
                if let Some(entry) = last.place.and_then(|place| self.listed.get_mut(place)) {
                    entry.text = last.described();
                }
                return;
            }
        }
        let text = self.text(&command);
        let count = self.listed.len();
        self.push(now_s, Kind::Command, Level::Info, text.clone());
        if self.sent.len() == UNANSWERED_MAX {
            self.sent.pop_front();
        }
        let place = (self.listed.len() > count).then_some(count);
        self.sent
            .push_back(Sent::new(sequence, command, text, place));
    }

    fn acknowledge(
        &mut self,
        sequence: u16,
        result: Result<(), Refusal>,
        moment: Option<Moment>,
        times: &RunTimes,
    ) {
        let mut latest_first = self.sent.iter_mut().rev();
        let Some(sent) = latest_first.find(|sent| sent.is_answered_by(sequence)) else {
            return;
        };
        sent.is_open = matches!(result, Err(Refusal::Busy | Refusal::EncoderUnknown { .. }));
        let entry = sent.place.and_then(|place| self.listed.get_mut(place));
        let Some(entry) = entry else { return };
        // Before the first tick, the board's clock is not known. A stream begins with its first
        // point.
        if let Some(moment) = moment
            && self.mode.is_some()
            && !sent.is_accepted
        {
            entry.time = times.at_us(moment.at_us);
            sent.is_accepted = true;
        }
        if let Err(refusal) = result
            && !sent.is_open
        {
            sent.refuse(refusal_text::in_words(refusal));
            entry.text = sent.described();
            entry.level = Level::Warning;
        }
    }

    /// Text of a command; of one that changes settings, their names and values.
    fn text(&self, command: &Command) -> String {
        let after = self.settings.and_then(|settings| match *command {
            Command::Configure(setup) => Some(Settings { setup, ..settings }),
            Command::Limit(limits) => Some(Settings { limits, ..settings }),
            _ => None,
        });
        let (Some(before), Some(after)) = (self.settings, after) else {
            return match command {
                Command::Arm { .. } => "arm".into(),
                other => command_text(other),
            };
        };
        let changed = params::changed(&before, &after);
        let named = changed
            .iter()
            .take(NAMED_MAX)
            .map(|(parameter, value)| format!("{} = {}", parameter.key, params::to_text(value)));
        let named: Vec<_> = named.collect();
        match changed.len().saturating_sub(NAMED_MAX) {
            _ if named.is_empty() => "confirm the settings".into(),
            0 => format!("set {}", named.join(", ")),
            more => format!("set {} and {more} more", named.join(", ")),
        }
    }
}

/// A fault on one line, with its remedy.
pub(super) fn fault_in_words(trip: &Trip) -> String {
    let description = fault_text::in_words(trip);
    let measured = description
        .measured
        .map_or_else(String::new, |measured| format!(" ({measured})"));
    format!("{}{measured}; {}", description.cause, description.remedy)
}

#[cfg(test)]
mod tests {
    use armbridge_link::message::{Record, TickInput};

    use super::*;

    const HOLD: Command = Command::Regulate([0.1, -0.2]);

    fn sent(sequence: u16, command: Command) -> EventKind {
        EventKind::Sent(sequence, ToBoard::Command(command))
    }

    fn ack(sequence: u16, result: Result<(), Refusal>) -> EventKind {
        let moment = result.is_ok().then_some(Moment {
            tick: 5,
            is_decided: false,
            at_us: 1_500_000,
            mode: Mode::Armed,
        });
        EventKind::Received(
            0,
            ToHost::Ack {
                sequence,
                result,
                moment,
            },
        )
    }

    #[test]
    fn a_repeated_command_is_listed_once_where_it_was_accepted() {
        let mut times = RunTimes::default();
        times.add(&Record {
            input: TickInput {
                start_us: 500_000,
                ..TickInput::AT_REST
            },
            ..Record::NONE
        });
        let mut list = EventList::default();
        list.mode(Mode::Boot, times.now_s());
        for event in [
            sent(1, HOLD),
            ack(1, Err(Refusal::Busy)),
            sent(2, HOLD),
            ack(2, Ok(())),
            sent(3, Command::Save),
            ack(3, Err(Refusal::NotReady)),
        ] {
            list.add(&event, &times);
        }
        let (listed, left_out) = list.finish();
        assert_eq!((listed.len(), left_out), (3, 0));
        assert!(listed[1].text.starts_with("save the settings, refused: "));
        assert_eq!(listed[2].text, "hold at +0.10 and -0.20 rad");
        assert!((listed[2].time - 1.0).abs() < 1e-9);
    }

    #[test]
    fn streams_are_one_entry_and_floods_are_counted() {
        let (times, mut list) = (RunTimes::default(), EventList::default());
        for sequence in 0..5_000_u16 {
            let point = Command::Stream {
                at_us: sequence.into(),
                angle_rad: [0.0; 2],
                speed_rad_s: None,
            };
            list.add(&sent(sequence, point), &times);
            list.add(&EventKind::Disconnected, &times);
        }
        let (listed, left_out) = list.finish();
        assert_eq!(listed.len(), 1 + OTHERS_MAX);
        assert_eq!(left_out, 5_000 - OTHERS_MAX);
        assert_eq!(listed[0].text, "follow 5000 streamed points");
    }

    #[test]
    fn refused_points_of_a_stream_are_counted_with_the_last_reason() {
        let (times, mut list) = (RunTimes::default(), EventList::default());
        let point = |sequence: u16| {
            let point = Command::Stream {
                at_us: sequence.into(),
                angle_rad: [0.0; 2],
                speed_rad_s: None,
            };
            sent(sequence, point)
        };
        let [not_ready, stale] = [Refusal::NotReady, Refusal::Stale].map(Err);
        for event in [
            // Sequence numbers wrap, and other frames have some of them.
            point(65_534),
            ack(65_534, not_ready),
            point(0),
            point(1),
            // The reply to a point may arrive after the next has been sent.
            ack(0, Ok(())),
            ack(1, stale),
            sent(2, Command::Save),
            ack(2, Ok(())),
        ] {
            list.add(&event, &times);
        }
        let (listed, _) = list.finish();
        assert_eq!(listed.len(), 2);
        let reason = refusal_text::in_words(Refusal::Stale);
        let expected = format!("follow 3 streamed points, 2 refused: {reason}");
        assert_eq!(
            (&listed[0].text, listed[0].level),
            (&expected, Level::Warning)
        );
        assert_eq!(listed[1].text, "save the settings");
    }
}
