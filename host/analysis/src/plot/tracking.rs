//! `tracking`: error of each joint against its reference.
//!
//! Where an error is large at times, such as after a step of the setpoint, a second panel
//! enlarges the small errors. The results of each setpoint are in a strip above the curve.

use armbridge_log::record_values::error_rad;
use armbridge_log::summary::{JointSummary, SETTLED_RAD, SegmentSummary};

use super::axis::Axis;
use super::drawing::{Drawing, Rect, Stroke};
use super::marks::NOTE;
use super::panel::{GAP, GOOD, JOINT, Key, Panel};
use super::run::Run;
use super::{figure, marks, panel};

/// Half the enlarged axis in units of the band, if the error at rest is within it.
const ENLARGED: f64 = 1.6;

/// Largest error at rest in mrad that extends the enlarged axis.
const MAX_REST_MRAD: f64 = 80.0;

/// Smallest factor by which the enlarged axis magnifies; with less, one panel shows all.
const MAGNIFIED: f64 = 2.0;

/// Smallest distance in px of the settling marks.
const SPACING_PX: f64 = 12.0;

/// Height in px of the strip with the results.
const STRIP_PX: f64 = 18.0;

/// Stroke of zero.
pub(super) const ZERO: Stroke = Stroke {
    colour: super::panel::FRAME,
    width: 1.2,
    dash: &[],
};

pub(super) fn draw(run: &Run) -> Drawing {
    let joints = run.facts.joints();
    let axes: Vec<_> = (0..joints).map(|joint| Axes::new(run, joint)).collect();
    let is_enlarged = axes.iter().any(|axes| axes.enlarged.is_some());
    let height = panel::height(joints)
        + if is_enlarged {
            110.0 * joints as f64
        } else {
            0.0
        };
    let mut drawing = figure(height, "Tracking error", &run.facts);
    let rows = (height - 92.0) / joints as f64;
    for (joint, axes) in axes.into_iter().enumerate() {
        let top = 78.0 + rows * joint as f64;
        let last = joint + 1 == joints;
        let title = format!("Joint {}: estimate minus reference", joint + 1);
        // The strip is above the last panel of the joint.
        let space = rows - 48.0 - STRIP_PX;
        let mut panel = Panel {
            frame: Rect::row(top + STRIP_PX, space),
            x: run.time_axis(),
            y: axes.full,
        };
        if joint == 0 {
            marks::draw_texts(&mut drawing, &panel, run, marks::LANE_PX);
        }
        let Some(enlarged) = axes.enlarged else {
            draw_panel(&mut drawing, &panel, run, joint, &title, last, STRIP_PX);
            draw_intervals(&mut drawing, &panel, run, joint);
            continue;
        };
        panel.frame = Rect::row(top, 0.4 * (space - 36.0));
        draw_panel(&mut drawing, &panel, run, joint, &title, false, 0.0);
        panel.frame = Rect::row(panel.frame.bottom() + 36.0 + STRIP_PX, 0.6 * (space - 36.0));
        panel.y = enlarged;
        let title = "the same, enlarged";
        draw_panel(&mut drawing, &panel, run, joint, title, last, STRIP_PX);
        draw_intervals(&mut drawing, &panel, run, joint);
    }
    drawing
}

/// Axes of a joint.
struct Axes {
    /// All of the error.
    full: Axis,
    /// The small errors, unless the full axis shows them as well.
    enlarged: Option<Axis>,
}

impl Axes {
    fn new(run: &Run, joint: usize) -> Self {
        let all = run.records().map(|record| 1e3 * error_rad(record, joint));
        let full = Axis::around(all.chain([-1.0, 1.0]), 0.08);
        let half_mrad = enlarged_mrad(run.setpoint_intervals(), joint);
        let is_larger = full.high - full.low > MAGNIFIED * 2.0 * half_mrad;
        Self {
            full,
            enlarged: is_larger.then(|| Axis::linear(-half_mrad, half_mrad)),
        }
    }
}

/// Half the enlarged axis in mrad: the band, and every small error at rest.
fn enlarged_mrad<'a>(intervals: impl Iterator<Item = &'a SegmentSummary>, joint: usize) -> f64 {
    let rests = intervals.map(|interval| interval.joints[joint].steady_state_error_mrad);
    let half_mrad = rests.map(f64::abs).filter(|rest| *rest < MAX_REST_MRAD);
    half_mrad.fold(1e3 * SETTLED_RAD * ENLARGED, |half_mrad, rest| {
        half_mrad.max(1.2 * rest)
    })
}

/// Draws a panel with its title and legend `raised` px above it.
fn draw_panel(
    drawing: &mut Drawing,
    panel: &Panel,
    run: &Run,
    joint: usize,
    title: &str,
    last: bool,
    raised: f64,
) {
    let x_title = last.then_some("time (s)");
    panel.draw(drawing, "", x_title, Some("error (mrad)"));
    let mut above = *panel;
    above.frame.y -= raised;
    above.title(drawing, title);
    let stroke = Stroke::solid(JOINT[joint], 1.4);
    let mut legend = vec![
        (Key::Line(stroke), "error"),
        (Key::Band(GOOD), "±20 mrad"),
        (Key::Ring(GOOD), "settled"),
    ];
    if run.has_gaps() {
        legend.push((Key::Area(GAP), "no records"));
    }
    above.legend(drawing, &legend);

    let band = 1e3 * SETTLED_RAD;
    let ends = (panel.x.low, panel.x.high);
    panel.area(drawing, (ends.0, -band), (ends.1, band), GOOD, 0.12);
    marks::draw(drawing, panel, run, joint);
    panel.level(drawing, 0.0, ZERO);
    let error = run.over_time(|record| 1e3 * error_rad(record, joint));
    panel.curve(drawing, error, stroke);
}

/// Draws the settling mark of each setpoint, and its settling time and error at rest in the
/// strip above the panel.
fn draw_intervals(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    let (mut free, mut marked) = (panel.frame.x, f64::NEG_INFINITY);
    for interval in run.setpoint_intervals() {
        let JointSummary {
            settling_time_s,
            steady_state_error_mrad: rest_mrad,
            ..
        } = interval.joints[joint];
        let from = interval.start_s.max(panel.x.low);
        let to = interval.end_s.min(panel.x.high);
        let settled = settling_time_s.map(|time| interval.start_s + time);
        if let Some(at) = settled.filter(|at| (panel.x.low..=panel.x.high).contains(at)) {
            let centre = panel.at(at, 0.0);
            // Closer marks would hide the curve.
            if centre.0 - marked > SPACING_PX {
                drawing.ring(centre, GOOD);
                marked = centre.0;
            }
        }
        let words = match settling_time_s {
            Some(time) => format!("settled in {time:.2} s, rests {rest_mrad:+.1} mrad off"),
            None => format!("does not settle, {rest_mrad:+.1} mrad off"),
        };
        let words = words.replace('-', "−");
        let left = panel.at(from, 0.0).0.max(panel.frame.x);
        let right = panel.at(to, 0.0).0;
        if left >= free && left + NOTE.width(&words) < right {
            drawing.text((left, panel.frame.y - 6.0), &words, NOTE, false);
            free = left + NOTE.width(&words);
        }
    }
}
