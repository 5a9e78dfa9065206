//! `tracking`: error of each joint against its reference.
//!
//! The upper panel shows the full error; the lower one enlarges small errors, with the band
//! in which a joint counts as settled and a mark where it settles.

use armbridge_log::summary::{JointSummary, SETTLED_RAD};
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::Record;

use super::axis::Axis;
use super::drawing::{Drawing, Rect, Stroke};
use super::figure;
use super::panel::{GAP, GOOD, JOINT, Key, Panel};
use super::run::{NOTE, Run, SetpointInterval};

/// Half the enlarged axis in units of the band, if the error at rest is within it.
const ENLARGED: f64 = 1.6;

/// Largest error at rest in mrad that extends the enlarged axis.
const MAX_REST_MRAD: f64 = 80.0;

/// Smallest distance in px of the settling marks.
const SPACING_PX: f64 = 12.0;

/// Stroke of zero.
const ZERO: Stroke = Stroke {
    colour: super::panel::FRAME,
    width: 1.2,
    dash: &[],
};

pub(super) fn draw(run: &Run) -> Drawing {
    let mut drawing = figure(860.0, "Tracking error", run.facts);
    let intervals = run.setpoint_intervals();
    for joint in 0..JOINTS {
        let y = 78.0 + 384.0 * joint as f64;
        let full = Rect::row(y, 120.0);
        let enlarged = Rect {
            y: y + 158.0,
            h: 178.0,
            ..full
        };
        let x = run.time_axis();
        let all = run.shown().iter().map(|record| error_mrad(record, joint));
        let around_zero = all.chain([-1.0, 1.0]);
        let panel = Panel {
            frame: full,
            x,
            y: Axis::around(around_zero, 0.08),
        };
        let title = format!("Joint {}: estimate minus reference", joint + 1);
        panel.draw(&mut drawing, &title, None, Some("error (mrad)"));
        draw_error(&mut drawing, &panel, run, joint);
        legend(&mut drawing, &panel, run, joint);
        run.draw_faults(&mut drawing, &panel);

        let half_mrad = enlarged_mrad(&intervals, joint);
        let panel = Panel {
            frame: enlarged,
            x,
            // Text is written above.
            y: Axis::linear(-half_mrad, 1.3 * half_mrad),
        };
        let last = joint + 1 == JOINTS;
        let x_title = last.then_some("time (s)");
        panel.draw(
            &mut drawing,
            "the same, enlarged",
            x_title,
            Some("error (mrad)"),
        );
        draw_error(&mut drawing, &panel, run, joint);
        draw_intervals(&mut drawing, &panel, &intervals, joint);
    }
    drawing
}

/// Estimate minus reference in mrad; NaN while the arm is not driven.
fn error_mrad(record: &Record, joint: usize) -> f64 {
    if record.mode.drive().is_none() {
        return f64::NAN;
    }
    1e3 * (f64::from(record.angle_rad[joint]) - f64::from(record.reference_rad[joint]))
}

/// Half the enlarged axis in mrad: the band, and every small error at rest.
fn enlarged_mrad(intervals: &[SetpointInterval], joint: usize) -> f64 {
    let rests = intervals
        .iter()
        .map(|interval| interval.joints[joint].steady_state_error_mrad);
    let half_mrad = rests.map(f64::abs).filter(|rest| *rest < MAX_REST_MRAD);
    half_mrad.fold(1e3 * SETTLED_RAD * ENLARGED, |half_mrad, rest| {
        half_mrad.max(1.2 * rest)
    })
}

fn draw_error(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    let band = 1e3 * SETTLED_RAD;
    let ends = (panel.x.low, panel.x.high);
    panel.area(drawing, (ends.0, -band), (ends.1, band), GOOD, 0.12);
    run.draw_gaps(drawing, panel);
    panel.level(drawing, 0.0, ZERO);
    let error = run.over_time(|record| error_mrad(record, joint));
    panel.curve(drawing, error, Stroke::solid(JOINT[joint], 1.4));
}

fn legend(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    let mut legend = vec![
        (Key::Line(Stroke::solid(JOINT[joint], 1.4)), "error"),
        (Key::Band(GOOD), "±20 mrad"),
        (Key::Ring(GOOD), "settled"),
    ];
    if run.has_gaps() {
        legend.push((Key::Area(GAP), "no records"));
    }
    panel.legend(drawing, &legend);
}

/// Draws the settling mark, settling time and error at rest of each setpoint.
fn draw_intervals(
    drawing: &mut Drawing,
    panel: &Panel,
    intervals: &[SetpointInterval],
    joint: usize,
) {
    let (mut free, mut marked) = (panel.frame.x, f64::NEG_INFINITY);
    for interval in intervals {
        let JointSummary {
            settling_time_s,
            steady_state_error_mrad: rest_mrad,
            ..
        } = interval.joints[joint];
        let from = interval.from_s.max(panel.x.low);
        let to = interval.to_s.min(panel.x.high);
        let settled = settling_time_s.map(|time| interval.from_s + time);
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
        let left = panel.at(from, 0.0).0 + 7.0;
        if left >= free && left + NOTE.width(&words) < panel.at(to, 0.0).0 {
            drawing.note((left, panel.frame.y + 16.0), &words, NOTE);
            free = left + NOTE.width(&words);
        }
    }
}
