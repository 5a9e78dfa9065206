//! One pass over a log for the page: curves, poses, events and results, in bounded memory.

use std::path::Path;

use armbridge_client::simulation::{Push, TrueState};
use armbridge_client::{LinkStats, enum_names};
use armbridge_link::message::{Record, Settings};
use armbridge_log::record_values::{self, in_closed_loop, once_up};
use armbridge_log::recording::{ReadError, Reader};
use armbridge_log::run_info::RunFacts;
use armbridge_log::summary::{Summary, Tally};
use armbridge_log::time_origin::RunTimes;
use armbridge_servo::JOINTS;

use super::events::{EventList, Kind, Level, Listed};
use super::rows::{Kept, Rows};

/// Intervals in faults and without records that are shaded; further ones are not.
const SHADED_MAX: usize = 500;

/// A quantity of each joint.
pub(super) struct Quantity {
    /// Its name in the page's data, before the joint's number.
    pub(super) name: &'static str,
    /// It is shown of the second run too.
    pub(super) is_compared: bool,
    /// Its value; NaN where there is none.
    get: fn(&Record, usize) -> f64,
}

/// Name of the true angle of a simulated arm, whose quantity is last.
pub(super) const TRUE_ANGLE: &str = "true_angle";

/// Encoder counts, which the page shows as angles.
pub(super) const ENCODER: &str = "encoder";

/// Quantities in the order of the rows.
pub(super) const QUANTITIES: [Quantity; 8] = [
    quantity(ENCODER, false, record_values::count),
    quantity("angle", true, record_values::angle_rad),
    quantity("reference", true, record_values::reference_rad),
    quantity("error", true, record_values::error_rad),
    quantity("speed", true, |record, joint| {
        once_up(record, record.output.speed_rad_s[joint])
    }),
    quantity("reference_speed", false, |record, joint| {
        in_closed_loop(record, record.output.reference_speed_rad_s[joint])
    }),
    quantity("torque", true, |record, joint| {
        once_up(record, record.output.torque_nm[joint])
    }),
    quantity("disturbance", false, |record, joint| {
        once_up(record, record.output.disturbance_nm[joint])
    }),
];

/// Quantities of a pose: angles, then reference angles.
const POSE: [usize; 2] = [1, 2];

const fn quantity(
    name: &'static str,
    is_compared: bool,
    get: fn(&Record, usize) -> f64,
) -> Quantity {
    Quantity {
        name,
        is_compared,
        get,
    }
}

/// Contents of a log for the page. Times are in s after the arm is armed.
#[derive(Debug)]
pub(super) struct Collected {
    /// The run, by the settings in force.
    pub(super) facts: RunFacts,
    pub(super) settings: Option<Settings>,
    /// Damage of the log, each in one sentence.
    pub(super) damage: Vec<String>,
    pub(super) summary: Summary,
    /// All quantities and the true angle, joint by joint.
    pub(super) rows: Rows,
    /// Angles and reference angles at an even rate.
    pub(super) poses: Rows,
    /// Time in s, after the first tick, at which the arm is armed.
    pub(super) zero_s: f64,
    /// Time of the last tick.
    pub(super) end_s: f64,
    pub(super) events: Vec<Listed>,
    pub(super) events_left_out: usize,
    /// Start of each mode.
    pub(super) modes: Vec<(f64, &'static str)>,
    /// Intervals without records.
    pub(super) gaps: Vec<[f64; 2]>,
    /// Pushes on a simulated arm.
    pub(super) pushes: Vec<ShownPush>,
}

/// A push with its start in s after the arm is armed.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownPush {
    pub(super) start_s: f64,
    pub(super) push: Push,
}

/// State of the pass.
struct Pass {
    times: RunTimes,
    tally: Tally,
    rows: Rows,
    poses: Rows,
    events: EventList,
    modes: Vec<(f64, &'static str)>,
    gaps: Vec<[f64; 2]>,
    pushes: Vec<ShownPush>,
    last: Option<(u32, f64)>,
    row: Vec<f32>,
}

impl Collected {
    /// Reads a log up to its first damage.
    pub(super) fn read(path: &Path) -> Result<Self, ReadError> {
        let mut log = Reader::open(path)?.rows();
        let mut pass = Pass::new();
        while let Some((event, truth)) = log.next_event() {
            match event.record() {
                Some(record) => pass.tick(&record, truth.as_ref(), log.pushes_begun(&record)),
                None => pass.events.add(&event.kind, &pass.times),
            }
        }
        let log = log.reader();
        let facts = log.facts().clone();
        let covered_s = pass.times.now_s();
        let summary = pass
            .tally
            .summary(&facts, LinkStats::default(), covered_s, 0.0);
        let zero_s = pass.times.origin_s().unwrap_or(0.0);
        let (mut events, events_left_out) = pass.events.finish();
        for event in &mut events {
            // A command may be sent before the first tick, or accepted after the last.
            event.time = event.time.clamp(0.0, covered_s) - zero_s;
        }
        for (start_s, _) in &mut pass.modes {
            *start_s -= zero_s;
        }
        for end_s in pass.gaps.as_flattened_mut() {
            *end_s -= zero_s;
        }
        for push in &mut pass.pushes {
            push.start_s -= zero_s;
        }
        Ok(Self {
            settings: log.settings().copied(),
            damage: log.damage().to_vec(),
            facts,
            summary,
            rows: pass.rows,
            poses: pass.poses,
            zero_s,
            end_s: pass.times.now_s() - zero_s,
            events,
            events_left_out,
            modes: pass.modes,
            gaps: pass.gaps,
            pushes: pass.pushes,
        })
    }
}

impl Pass {
    fn new() -> Self {
        let quantities = (QUANTITIES.len() + 1) * JOINTS;
        Self {
            times: RunTimes::default(),
            tally: Tally::default(),
            rows: Rows::new(Kept::Extremes, quantities),
            poses: Rows::new(Kept::First, POSE.len() * JOINTS),
            events: EventList::default(),
            modes: Vec::new(),
            gaps: Vec::new(),
            pushes: Vec::new(),
            last: None,
            row: Vec::with_capacity(quantities),
        }
    }

    fn push(&mut self, push: &Push) {
        self.tally.push(push);
        let start_s = self.times.at_us(push.start_ns / 1_000);
        let text = format!(
            "push on joint {}: {:+.2} N m for {:.2} s",
            push.joint + 1,
            push.torque_nm,
            push.duration_ns as f64 * 1e-9
        );
        self.events.push(start_s, Kind::Push, Level::Info, text);
        let push = *push;
        self.pushes.push(ShownPush { start_s, push });
    }

    /// Adds the next tick, and the pushes that have begun since the one before.
    fn tick(&mut self, record: &Record, truth: Option<&TrueState>, begun: &[Push]) {
        let time_s = self.times.add(record);
        for push in begun {
            self.push(push);
        }
        if let Some((tick, last_s)) = self.last
            && record.tick.wrapping_sub(tick) != 1
        {
            let missing = record.tick.saturating_sub(tick).saturating_sub(1);
            if missing > 0 {
                self.events.gap(missing, last_s);
            }
            if self.gaps.len() < SHADED_MAX {
                self.gaps.push([last_s, time_s]);
            }
            self.rows.add_gap(f64::midpoint(last_s, time_s));
        }
        self.last = Some((record.tick, time_s));
        if self.events.mode(record.mode, time_s) && self.modes.len() < SHADED_MAX {
            self.modes.push((time_s, enum_names::mode(record.mode)));
        }
        self.tally.add(record);
        self.row.clear();
        for quantity in &QUANTITIES {
            self.row
                .extend((0..JOINTS).map(|joint| (quantity.get)(record, joint) as f32));
        }
        self.row
            .extend(truth.map_or([f32::NAN; JOINTS], |truth| truth.angle_rad));
        self.rows.add(time_s, &self.row);
        let pose = POSE.map(|quantity| [0, 1].map(|joint| self.row[quantity * JOINTS + joint]));
        self.poses.add(time_s, pose.as_flattened());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_log::write_log;
    use armbridge_link::message::TickInput;

    #[test]
    fn a_push_before_the_first_tick_has_its_own_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        let records = [17_000, 18_000, 19_000].map(|start_us| Record {
            tick: start_us as u32 / 1_000,
            input: TickInput {
                start_us,
                ..TickInput::AT_REST
            },
            ..Record::NONE
        });
        let push = Push {
            joint: 1,
            torque_nm: 0.5,
            start_ns: 7_000_000,
            duration_ns: 1_000_000,
        };
        write_log(&path, &[push], &records);
        let run = Collected::read(&path).unwrap();
        assert!(
            (run.pushes[0].start_s + 0.01).abs() < 1e-9,
            "{:?}",
            run.pushes
        );
    }
}
