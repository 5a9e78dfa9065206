//! `angles`: samples, estimate and setpoint of both joints.

use armbridge_client::enum_names;
use armbridge_log::summary::{JointSummary, SETTLED_RAD};
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Drive, Record, Sample};

use super::axis::Axis;
use super::decimate::distinct;
use super::drawing::{Drawing, Stroke};
use super::figure;
use super::panel::{ALARM, GAP, GOOD, JOINT, JOINT_TINT, Key, MUTED, Panel, SETPOINT};
use super::run::{NOTE, Run, SetpointInterval};

/// Smallest distance in px of the lines between setpoints.
const SPACING_PX: f64 = 12.0;

/// Estimates.
const ESTIMATE_WIDTH: f64 = 1.7;

pub(super) fn draw(run: &Run) -> Drawing {
    let mut drawing = figure(640.0, "Joint angles", run.facts);
    let intervals = run.setpoint_intervals();
    for joint in 0..JOINTS {
        let panel = Panel::angle(&mut drawing, joint, run.time_axis(), angle_axis(run, joint));
        draw_joint(&mut drawing, &panel, run, joint);
        draw_setpoints(&mut drawing, &panel, &intervals, joint);
        draw_motion(&mut drawing, &panel, run, joint);
        run.draw_faults(&mut drawing, &panel);
    }
    drawing
}

/// Axis that contains all curves, with space for text above them.
fn angle_axis(run: &Run, joint: usize) -> Axis {
    let shown = run.shown().iter().filter(|r| enum_names::is_up(r.mode));
    let shown = shown.flat_map(|record| {
        let reference = f64::from(record.reference_rad[joint]);
        [
            reference - 1.5 * SETTLED_RAD,
            reference + 1.5 * SETTLED_RAD,
            f64::from(record.angle_rad[joint]),
            run.measured_rad(record, joint),
        ]
    });
    let axis = Axis::around(shown, 0.05);
    Axis {
        high: axis.high + 0.14 * (axis.high - axis.low),
        ..axis
    }
}

fn draw_joint(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    run.draw_gaps(drawing, panel);
    let samples = run.over_time(|r| run.measured_rad(r, joint));
    panel.dots(
        drawing,
        samples.filter(|(_, angle)| angle.is_finite()),
        JOINT_TINT[joint],
    );
    let estimate = Stroke::solid(JOINT[joint], ESTIMATE_WIDTH);
    let angle = |r: &Record| {
        if enum_names::is_up(r.mode) {
            f64::from(r.angle_rad[joint])
        } else {
            f64::NAN
        }
    };
    panel.curve(drawing, run.over_time(angle), estimate);

    let mut legend = vec![
        (Key::Dots(JOINT_TINT[joint]), "encoder"),
        (Key::Line(estimate), "estimate"),
        (Key::Line(SETPOINT), "setpoint"),
        (Key::Band(GOOD), "±20 mrad"),
    ];
    let is_missing = |r: &Record| {
        if enum_names::is_up(r.mode) && matches!(r.samples[joint], Sample::Missing(_)) {
            panel.y.low
        } else {
            f64::NAN
        }
    };
    let missing = run.over_time(is_missing).filter(|(_, low)| low.is_finite());
    let missing = distinct(missing.map(|(time, low)| panel.at(time, low)));
    if !missing.is_empty() {
        let stroke = Stroke::solid(ALARM, 1.2);
        let marks = missing.iter().map(|&(x, y)| vec![(x, y), (x, y - 8.0)]);
        drawing.polyline(marks.collect(), stroke);
        legend.push((Key::Line(stroke), "missing sample"));
    }
    if run.has_gaps() {
        legend.push((Key::Area(GAP), "no records"));
    }
    panel.legend(drawing, &legend);
}

/// Draws the moving reference.
fn draw_motion(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    let reference = |r: &Record| match r.mode.drive() {
        Some(Drive::Track | Drive::Hold) => f64::from(r.reference_rad[joint]),
        _ => f64::NAN,
    };
    panel.curve(drawing, run.over_time(reference), SETPOINT);
}

/// Draws the setpoints, the bands in which a joint counts as settled, and the results.
fn draw_setpoints(
    drawing: &mut Drawing,
    panel: &Panel,
    intervals: &[SetpointInterval],
    joint: usize,
) {
    let mut path = Vec::new();
    for interval in intervals {
        let JointSummary {
            reference_rad,
            settling_time_s,
            steady_state_error_mrad,
            ..
        } = interval.joints[joint];
        let reference = f64::from(reference_rad);
        let (from, to) = (
            interval.from_s.max(panel.x.low),
            interval.to_s.min(panel.x.high),
        );
        let (low, high) = (reference - SETTLED_RAD, reference + SETTLED_RAD);
        panel.area(drawing, (from, low), (to, high), GOOD, 0.14);
        // Intervals that do not touch are not joined.
        let is_next = path
            .last()
            .is_none_or(|(end, _): &(f64, f64)| from - end < 1e-3);
        path.extend((!is_next).then_some((from, f64::NAN)));
        path.extend([(from, reference), (to, reference)]);

        let settled = settling_time_s.map_or("does not settle".to_owned(), |s| {
            format!("settled in {s:.2} s")
        });
        let rest = format!("{steady_state_error_mrad:+.1} mrad").replace('-', "−");
        let long = format!("{settled}, rests {rest} off");
        let short = format!("{settled}, {rest}");
        let (left, right) = (panel.at(from, low).0 + 7.0, panel.at(to, low).0);
        // Only a text that fits between this setpoint and the next.
        let fits = |text: &&String| left + NOTE.width(text) < right;
        if let Some(text) = [&long, &short, &settled].into_iter().find(fits) {
            drawing.note((left, panel.frame.y + 16.0), text, NOTE);
        }
    }
    let mut drawn = panel.frame.x;
    for interval in intervals.iter().skip(1) {
        let (x, _) = panel.at(interval.from_s, panel.y.low);
        // Closer lines would hide the curve.
        if x - drawn < SPACING_PX {
            continue;
        }
        drawn = x;
        let stroke = Stroke {
            colour: MUTED,
            width: 0.8,
            dash: &[1.0, 3.0],
        };
        drawing.line((x, panel.frame.y), (x, panel.frame.bottom()), stroke);
    }
    panel.curve(drawing, path.into_iter(), SETPOINT);
}
