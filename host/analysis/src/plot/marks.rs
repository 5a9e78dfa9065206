//! Marks on the time axis: pushes, commands and faults, and intervals without records.
//!
//! A line through every panel has its text in a lane above the first panel. A push shades its
//! duration in the panel of its joint.

use armbridge_client::enum_names;
use armbridge_log::simulation::Push;

use super::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use super::panel::{ALARM, FOURTH, GAP, MUTED, Panel};
use super::run::Run;

/// Smallest width of an interval's mark in px, so that a single missing record is visible.
const INTERVAL_PX: f64 = 1.6;

/// Baseline of the texts in figures of one run, in px.
pub(super) const LANE_PX: f64 = 51.0;

/// Smallest distance of lines in px.
const SPACING_PX: f64 = 4.0;

/// Font of small grey notes.
pub(super) const NOTE: Font = Font {
    size: 11.0,
    bold: false,
    colour: MUTED,
    anchor: Anchor::Start,
};

/// Kind of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MarkKind {
    /// External torque on a joint.
    Push,
    /// Command of the host.
    Command,
}

/// An event on the time axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mark {
    /// Time in s after time zero of the run.
    pub(super) time_s: f64,
    /// Duration in s.
    pub(super) duration_s: f64,
    /// Kind.
    pub(super) kind: MarkKind,
    /// Joint, counting from 0; none for both.
    pub(super) joint: Option<usize>,
    /// Short text.
    pub(super) text: String,
}

impl Mark {
    /// Push on the simulated arm.
    pub(super) fn push(time_s: f64, push: &Push) -> Self {
        let (torque_nm, joint) = (push.torque_nm, push.joint + 1);
        let text = format!("push {torque_nm:+.2} N m on joint {joint}");
        Self {
            time_s,
            duration_s: push.duration_ns as f64 * 1e-9,
            kind: MarkKind::Push,
            joint: Some(push.joint),
            text: text.replace('-', "−"),
        }
    }

    /// Command of the host.
    pub(super) fn command(time_s: f64, text: &str) -> Self {
        Self {
            time_s,
            duration_s: 0.0,
            kind: MarkKind::Command,
            joint: None,
            text: text.to_owned(),
        }
    }

    fn colour(&self) -> &'static str {
        match self.kind {
            MarkKind::Push => FOURTH,
            MarkKind::Command => MUTED,
        }
    }
}

/// Draws the marks of a panel: missing records, faults, pushes and commands.
pub(super) fn draw(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    draw_gaps(drawing, panel, run);
    let mut last = f64::NEG_INFINITY;
    for mark in shown(panel, run) {
        if mark.joint.is_some_and(|pushed| pushed != joint) {
            continue;
        }
        if mark.duration_s > 0.0 {
            let end_s = mark.time_s + mark.duration_s;
            interval(drawing, panel, [mark.time_s, end_s], mark.colour(), 0.18);
        }
        let (x, _) = panel.at(mark.time_s, panel.y.low);
        if x - last >= SPACING_PX {
            let stroke = Stroke {
                colour: mark.colour(),
                width: 0.9,
                dash: &[2.0, 3.0],
            };
            drawing.line((x, panel.frame.y), (x, panel.frame.bottom()), stroke);
            last = x;
        }
    }
    draw_faults(drawing, panel, run);
}

/// Writes the texts of pushes and commands beside each other on one line, above the panels.
pub(super) fn draw_texts(drawing: &mut Drawing, panel: &Panel, run: &Run, y: f64) {
    let mut free = panel.frame.x - 8.0;
    for mark in shown(panel, run) {
        let font = Font {
            colour: mark.colour(),
            ..NOTE
        };
        let (x, _) = panel.at(mark.time_s, panel.y.low);
        let width = font.width(&mark.text);
        let left = (x - 4.0).min(panel.frame.right() - width);
        if left >= free {
            drawing.text((left, y), &mark.text, font, false);
            free = left + width + 8.0;
        }
    }
}

/// Marks within the time axis.
fn shown<'a>(panel: &Panel, run: &'a Run) -> impl Iterator<Item = &'a Mark> + use<'a> {
    let range = panel.x.low..=panel.x.high;
    run.marks
        .iter()
        .filter(move |mark| range.contains(&mark.time_s))
}

/// Shades an interval of time.
fn interval(
    drawing: &mut Drawing,
    panel: &Panel,
    [from_s, to_s]: [f64; 2],
    colour: &'static str,
    opacity: f64,
) {
    let (left, top) = panel.at(from_s.max(panel.x.low), panel.y.high);
    let (right, bottom) = panel.at(to_s.min(panel.x.high), panel.y.low);
    let mark = Rect {
        x: left,
        y: top,
        w: (right - left).max(INTERVAL_PX),
        h: bottom - top,
    };
    drawing.rect(mark, colour, opacity);
}

/// Shades intervals without records.
pub(super) fn draw_gaps(drawing: &mut Drawing, panel: &Panel, run: &Run) {
    let mut marked = f64::NEG_INFINITY;
    for two in run.ticks.windows(2).filter(|two| !two[1].follows) {
        let [from_s, to_s] = [two[0].time_s, two[1].time_s];
        let (right, _) = panel.at(to_s, panel.y.low);
        // A gap within the previous mark is not visible.
        if right >= marked + INTERVAL_PX {
            interval(drawing, panel, [from_s, to_s], GAP, 1.0);
            marked = right.max(panel.at(from_s, panel.y.low).0 + INTERVAL_PX);
        }
    }
}

/// Shades the time spent in faults and names each.
pub(super) fn draw_faults(drawing: &mut Drawing, panel: &Panel, run: &Run) {
    let mut free = panel.frame.x;
    let fault_of = |tick: &super::reduce::Tick| enum_names::fault_of(tick.record.mode);
    for chunk in run.ticks.chunk_by(|a, b| fault_of(a) == fault_of(b)) {
        if let (Some(fault), Some(first), Some(last)) =
            (fault_of(&chunk[0]), chunk.first(), chunk.last())
        {
            let text = format!("fault: {}", fault.name());
            let span = [first.time_s, last.time_s];
            draw_fault(drawing, panel, span, &text, &mut free);
        }
    }
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
