//! A run as figures see it: records with their times, and what part is shown.

use armbridge_client::enum_names;
use armbridge_log::run_info::RunFacts;
use armbridge_log::summary::{JointSummary, SegmentSummary, segments};
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Record, Sample};

use super::axis::Axis;
use super::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use super::panel::{ALARM, GAP, MUTED, Panel};

/// Narrowest mark of a gap in px, so that a single missing record is seen.
const GAP_PX: f64 = 1.6;

/// A run and the part of it that is shown.
#[derive(Debug)]
pub(super) struct Run<'a> {
    pub(super) facts: &'a RunFacts,
    pub(super) records: &'a [Record],
    /// Time of each record in s after the first; it goes on over a reset of the
    /// board, whose clock begins anew.
    times: Vec<f64>,
    /// First and last time that is shown, in s.
    window: [f64; 2],
}

/// A setpoint, how well each joint went there, and when that was in s.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) from_s: f64,
    pub(super) to_s: f64,
    pub(super) joints: [JointSummary; JOINTS],
}

impl<'a> Run<'a> {
    /// A run of which everything is shown, or what lies between two times.
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

    /// The records that are shown.
    pub(super) fn shown(&self) -> &'a [Record] {
        let (from, to) = self.places();
        &self.records[from..to]
    }

    fn places(&self) -> (usize, usize) {
        let [from_s, to_s] = self.window;
        let from = self.times.partition_point(|time| *time < from_s);
        let to = self.times.partition_point(|time| *time <= to_s);
        (from.min(to), to)
    }

    /// A quantity of each tick that is shown, over time; not a number between
    /// ticks that do not follow each other.
    pub(super) fn over_time(
        &self,
        quantity: impl Fn(&Record) -> f64,
    ) -> impl Iterator<Item = (f64, f64)> {
        let (from, to) = self.places();
        (from..to).flat_map(move |at| {
            let record = &self.records[at];
            let gap = at > from && !follows(&self.records[at - 1], record);
            let gap = gap.then_some((self.times[at], f64::NAN));
            gap.into_iter().chain([(self.times[at], quantity(record))])
        })
    }

    /// The setpoints that are shown.
    pub(super) fn parts(&self) -> Vec<Part> {
        let [shown_from, shown_to] = self.window;
        let period_s = f64::from(self.facts.period_us) * 1e-6;
        let parts = segments(self.records).into_iter().filter_map(|segment| {
            let from_s = self.times[segment.ticks.start];
            let to_s = self.times[segment.ticks.end - 1] + period_s;
            (to_s > shown_from && from_s < shown_to).then(|| Part {
                from_s,
                to_s,
                joints: SegmentSummary::of(self.records, &segment, self.facts).joints,
            })
        });
        parts.collect()
    }

    /// Angle by the encoder in rad; NaN where its sample is missing.
    pub(super) fn measured_rad(&self, record: &Record, joint: usize) -> f64 {
        match record.samples[joint] {
            Sample::Counts(count) => self.facts.angle_rad(joint, count),
            Sample::Missing(_) => f64::NAN,
        }
    }

    /// Whether records are missing among those that are shown.
    pub(super) fn has_gaps(&self) -> bool {
        self.shown()
            .windows(2)
            .any(|two| !follows(&two[0], &two[1]))
    }

    /// Shades where there are no records.
    pub(super) fn draw_gaps(&self, drawing: &mut Drawing, panel: &Panel) {
        let (from, to) = self.places();
        let mut marked = f64::NEG_INFINITY;
        for at in from + 1..to {
            if follows(&self.records[at - 1], &self.records[at]) {
                continue;
            }
            let (left, top) = panel.at(self.times[at - 1], panel.y.high);
            let (right, bottom) = panel.at(self.times[at], panel.y.low);
            // What lies within the mark before it cannot be seen.
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
        let (from, to) = self.places();
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

/// Whether one record is that of the tick after another.
fn follows(before: &Record, after: &Record) -> bool {
    after.tick == before.tick.wrapping_add(1)
}

/// One fault; `free` is where nothing is written yet.
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
    // In the shade, unless the frame ends too soon.
    let mut left = x + 7.0;
    if left + width > panel.frame.right() {
        left = x - 7.0 - width;
    }
    if left >= *free {
        drawing.note((left, panel.frame.y + 34.0), text, font);
        *free = left + width + 7.0;
    }
}

/// Small grey words inside a panel.
pub(super) const NOTE: Font = Font {
    size: 11.0,
    bold: false,
    colour: MUTED,
    anchor: Anchor::Start,
};
