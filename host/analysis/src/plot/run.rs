//! Data of a run for the figures: records with their times, and the time window.

use armbridge_client::enum_names;
use armbridge_log::run_info::RunFacts;
use armbridge_log::summary::{JointSummary, SegmentSummary, segments};
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Record, Sample};

use super::axis::Axis;
use super::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use super::panel::{ALARM, GAP, MUTED, Panel};

/// Smallest width of a gap's mark in px, so that a single missing record is visible.
const GAP_PX: f64 = 1.6;

/// A run and the window shown.
#[derive(Debug)]
pub(super) struct Run<'a> {
    pub(super) facts: &'a RunFacts,
    pub(super) records: &'a [Record],
    /// Time of each record in s after the first; it continues after a reset of the
    /// board, which restarts the board's clock.
    times: Vec<f64>,
    /// First and last time shown, in s.
    window: [f64; 2],
}

/// Time interval of a setpoint in s, with the result of each joint.
#[derive(Debug)]
pub(super) struct SetpointInterval {
    pub(super) from_s: f64,
    pub(super) to_s: f64,
    pub(super) joints: [JointSummary; JOINTS],
}

impl<'a> Run<'a> {
    /// Run with a window from `from_s` to `to_s`; `None` for the ends of the run.
    pub(super) fn new(
        facts: &'a RunFacts,
        records: &'a [Record],
        from_s: Option<f64>,
        to_s: Option<f64>,
    ) -> Self {
        let period_s = f64::from(facts.period_us) * 1e-6;
        let mut times = Vec::with_capacity(records.len());
        let (mut before_s, mut origin_us) = (0.0, 0);
        for (at, record) in records.iter().enumerate() {
            match at.checked_sub(1).map(|last| (records[last], times[last])) {
                None => origin_us = record.start_us,
                Some((last, last_s)) if record.start_us < last.start_us => {
                    (before_s, origin_us) = (last_s + period_s, record.start_us);
                }
                Some(_) => {}
            }
            times.push(before_s + (record.start_us - origin_us) as f64 * 1e-6);
        }
        let end_s = times.last().map_or(1.0, |last| last + period_s);
        let from_s = from_s.unwrap_or(0.0);
        // A window must have some width to be drawn.
        let to_s = to_s.unwrap_or(end_s).max(from_s + period_s);
        Self {
            facts,
            records,
            times,
            window: [from_s, to_s],
        }
    }

    /// The time axis.
    pub(super) fn time_axis(&self) -> Axis {
        let [low, high] = self.window;
        Axis::linear(low, high)
    }

    /// Records in the window.
    pub(super) fn shown(&self) -> &'a [Record] {
        let (from, to) = self.index_range();
        &self.records[from..to]
    }

    fn index_range(&self) -> (usize, usize) {
        let [from_s, to_s] = self.window;
        let from = self.times.partition_point(|time| *time < from_s);
        let to = self.times.partition_point(|time| *time <= to_s);
        (from.min(to), to)
    }

    /// A quantity over time in s of each tick in the window, with NaN between ticks that
    /// are not consecutive.
    pub(super) fn over_time(
        &self,
        quantity: impl Fn(&Record) -> f64,
    ) -> impl Iterator<Item = (f64, f64)> {
        let (from, to) = self.index_range();
        (from..to).flat_map(move |at| {
            let record = &self.records[at];
            let gap = at > from && !follows(&self.records[at - 1], record);
            let gap = gap.then_some((self.times[at], f64::NAN));
            gap.into_iter().chain([(self.times[at], quantity(record))])
        })
    }

    /// The setpoints that are shown.
    pub(super) fn setpoint_intervals(&self) -> Vec<SetpointInterval> {
        let [shown_from, shown_to] = self.window;
        let period_s = f64::from(self.facts.period_us) * 1e-6;
        let intervals = segments(self.records).into_iter().filter_map(|segment| {
            let from_s = self.times[segment.ticks.start];
            let to_s = self.times[segment.ticks.end - 1] + period_s;
            (to_s > shown_from && from_s < shown_to).then(|| SetpointInterval {
                from_s,
                to_s,
                joints: SegmentSummary::evaluate(self.records, &segment, self.facts).joints,
            })
        });
        intervals.collect()
    }

    /// Angle by the encoder in rad; NaN if the sample is missing.
    pub(super) fn measured_rad(&self, record: &Record, joint: usize) -> f64 {
        match record.samples[joint] {
            Sample::Counts(count) => self.facts.angle_rad(joint, count),
            Sample::Missing(_) => f64::NAN,
        }
    }

    /// Whether records are missing in the window.
    pub(super) fn has_gaps(&self) -> bool {
        self.shown()
            .windows(2)
            .any(|two| !follows(&two[0], &two[1]))
    }

    /// Shades intervals without records.
    pub(super) fn draw_gaps(&self, drawing: &mut Drawing, panel: &Panel) {
        let (from, to) = self.index_range();
        let mut marked = f64::NEG_INFINITY;
        for at in from + 1..to {
            if follows(&self.records[at - 1], &self.records[at]) {
                continue;
            }
            let (left, top) = panel.at(self.times[at - 1], panel.y.high);
            let (right, bottom) = panel.at(self.times[at], panel.y.low);
            // A gap within the previous mark is not visible.
            if right < marked + GAP_PX {
                continue;
            }
            marked = right.max(left + GAP_PX);
            let mark = Rect {
                x: left,
                y: top,
                w: marked - left,
                h: bottom - top,
            };
            drawing.rect(mark, GAP, 1.0);
        }
    }

    /// Shades the time spent in faults and names each.
    pub(super) fn draw_faults(&self, drawing: &mut Drawing, panel: &Panel) {
        let (from, to) = self.index_range();
        let mut at = from;
        let mut free = panel.frame.x;
        let alike =
            |a: &Record, b: &Record| enum_names::fault_of(a.mode) == enum_names::fault_of(b.mode);
        for chunk in self.records[from..to].chunk_by(alike) {
            let span = [self.times[at], self.times[at + chunk.len() - 1]];
            at += chunk.len();
            if let Some(fault) = enum_names::fault_of(chunk[0].mode) {
                let text = format!("fault: {}", enum_names::fault(fault));
                draw_fault(drawing, panel, span, &text, &mut free);
            }
        }
    }
}

/// Whether two records are those of consecutive ticks.
fn follows(before: &Record, after: &Record) -> bool {
    after.tick == before.tick.wrapping_add(1)
}

/// Draws one fault; `free` is the left end of the space without text.
fn draw_fault(
    drawing: &mut Drawing,
    panel: &Panel,
    [from, to]: [f64; 2],
    text: &str,
    free: &mut f64,
) {
    panel.area(
        drawing,
        (from, panel.y.low),
        (to, panel.y.high),
        ALARM,
        0.08,
    );
    let font = Font {
        size: 11.5,
        bold: true,
        colour: ALARM,
        anchor: Anchor::Start,
    };
    let (x, bottom) = panel.at(from, panel.y.low);
    let x = x.max(panel.frame.x);
    drawing.line((x, panel.frame.y), (x, bottom), Stroke::solid(ALARM, 1.2));
    let width = font.width(text);
    // Right of the line if there is room, else left.
    let mut left = x + 7.0;
    if left + width > panel.frame.right() {
        left = x - 7.0 - width;
    }
    if left >= *free {
        drawing.note((left, panel.frame.y + 34.0), text, font);
        *free = left + width + 7.0;
    }
}

/// Font of small grey notes inside a panel.
pub(super) const NOTE: Font = Font {
    size: 11.0,
    bold: false,
    colour: MUTED,
    anchor: Anchor::Start,
};
