//! `angles`: samples, estimate and setpoint of both joints.

use armbridge_client::enum_names;
use armbridge_log::record_values::{angle_rad, reference_rad};
use armbridge_log::summary::{JointSummary, SETTLED_RAD};

use super::axis::Axis;
use super::decimate::distinct;
use super::drawing::{Anchor, Drawing, Font, Stroke};
use super::marks::NOTE;
use super::panel::{ALARM, GAP, GOOD, JOINT, JOINT_TINT, Key, MUTED, Panel, SETPOINT};
use super::reduce::missing;
use super::run::Run;
use super::{figure, marks, panel};

/// Smallest distance in px of the lines between setpoints.
const SPACING_PX: f64 = 12.0;

/// Estimates.
const ESTIMATE_WIDTH: f64 = 1.7;

/// Curve of another run, drawn in grey behind that of the run.
const BEHIND: Stroke = Stroke::solid("#98a2ad", 1.7);

/// Time in s before the end of a setpoint at which the error at rest is noted.
const BEFORE_END_S: f64 = 0.25;

pub(super) fn draw(run: &Run) -> Drawing {
    let joints = run.facts.joints();
    let mut drawing = figure(panel::height(joints), "Joint angles", &run.facts);
    let behind = run.behind.as_deref();
    for joint in 0..joints {
        let axis = angle_axis([run].into_iter().chain(behind), joint);
        let panel = Panel::angle(&mut drawing, joint, joints, run.time_axis(), axis);
        marks::draw(&mut drawing, &panel, run, joint);
        if joint == 0 {
            marks::draw_texts(&mut drawing, &panel, run, marks::LANE_PX);
        }
        if let Some(behind) = behind {
            panel.curve(
                &mut drawing,
                behind.over_time(|r| angle_rad(r, joint)),
                BEHIND,
            );
        }
        draw_joint(&mut drawing, &panel, run, joint);
        draw_setpoints(&mut drawing, &panel, run, joint);
        draw_reference(&mut drawing, &panel, run, joint);
        if let Some(behind) = behind {
            draw_notes(&mut drawing, &panel, [run, behind], joint);
        }
    }
    drawing
}

/// Notes on the curves: the run's settling times, and how far the run behind it rests off where it
/// does not settle.
fn draw_notes(drawing: &mut Drawing, panel: &Panel, [run, behind]: [&Run; 2], joint: usize) {
    for interval in run.setpoint_intervals() {
        if let Some(time_s) = interval.joints[joint].settling_time_s {
            let at_s = interval.start_s + time_s;
            let text = format!("{time_s:.2} s");
            draw_note(drawing, panel, run, joint, (at_s, &text, JOINT[joint]));
        }
    }
    for interval in behind.setpoint_intervals() {
        let result = &interval.joints[joint];
        if result.settling_time_s.is_none() {
            let at_s = (interval.end_s - BEFORE_END_S).max(interval.start_s);
            let text = format!("{:.0} mrad", result.steady_state_error_mrad.abs());
            draw_note(drawing, panel, behind, joint, (at_s, &text, MUTED));
        }
    }
}

/// Rings a point of a curve, and writes a text beside it where no curve is: that of the run beyond
/// the band of the setpoint, that of the run behind it away from the setpoint.
fn draw_note(
    drawing: &mut Drawing,
    panel: &Panel,
    run: &Run,
    joint: usize,
    (at_s, text, colour): (f64, &str, &'static str),
) {
    let angle = run.value_at(at_s, |r| angle_rad(r, joint));
    let setpoint = run.value_at(at_s, |r| reference_rad(r, joint));
    if !(angle.is_finite() && setpoint.is_finite()) {
        return;
    }
    panel.ring(drawing, (at_s, angle), colour);
    let font = Font {
        size: 12.5,
        bold: true,
        colour,
        anchor: Anchor::Middle,
    };
    let is_behind = colour == MUTED;
    let beyond = setpoint - (angle - setpoint).signum() * SETTLED_RAD;
    let (x, y) = panel.at(at_s, if is_behind { angle } else { beyond });
    let is_above = (angle >= setpoint) == is_behind;
    let baseline = if is_above { y - 9.0 } else { y + 19.0 };
    let baseline = baseline.clamp(panel.frame.y + 14.0, panel.frame.bottom() - 6.0);
    let half = font.width(text) / 2.0;
    let x = x.clamp(panel.frame.x + half, panel.frame.right() - half);
    drawing.text((x, baseline), text, font, false);
}

/// Axis that contains all curves, with space for text above them.
fn angle_axis<'a>(runs: impl Iterator<Item = &'a Run>, joint: usize) -> Axis {
    let values = runs.flat_map(|run| {
        let shown = run.records().filter(|r| enum_names::is_up(r.mode));
        shown.flat_map(move |record| {
            let reference = f64::from(record.output.reference_rad[joint]);
            [
                reference - 1.5 * SETTLED_RAD,
                reference + 1.5 * SETTLED_RAD,
                f64::from(record.output.angle_rad[joint]),
                run.measured_rad(record, joint),
            ]
        })
    });
    let axis = Axis::around(values, 0.05);
    Axis {
        high: axis.high + 0.14 * (axis.high - axis.low),
        ..axis
    }
}

fn draw_joint(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    let samples = run.over_time(|r| run.measured_rad(r, joint));
    panel.dots(
        drawing,
        samples.filter(|(_, angle)| angle.is_finite()),
        JOINT_TINT[joint],
    );
    let estimate = Stroke::solid(JOINT[joint], ESTIMATE_WIDTH);
    panel.curve(drawing, run.over_time(|r| angle_rad(r, joint)), estimate);

    let mut legend = vec![
        (Key::Dots(JOINT_TINT[joint]), "encoder"),
        (Key::Line(estimate), "estimate"),
        (Key::Line(SETPOINT), "setpoint"),
        (Key::Band(GOOD), "±20 mrad"),
    ];
    let behind = run.behind.as_deref();
    let behind = behind.map(|behind| format!("control {}", behind.control()));
    legend.extend(behind.iter().map(|name| (Key::Line(BEHIND), name.as_str())));
    let missing = run.over_time(|r| missing(r, joint) * panel.y.low);
    let missing = missing.filter(|(_, low)| low.is_finite());
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

/// Draws the reference.
fn draw_reference(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    let reference = run.over_time(|r| reference_rad(r, joint));
    panel.curve(drawing, reference, SETPOINT);
}

/// Draws the setpoints, the bands in which a joint counts as settled, and the results.
fn draw_setpoints(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    let mut drawn = panel.frame.x;
    for (place, interval) in run.setpoint_intervals().enumerate() {
        let JointSummary {
            reference_rad,
            settling_time_s,
            steady_state_error_mrad,
            ..
        } = interval.joints[joint];
        let reference = f64::from(reference_rad);
        let (from, to) = (
            interval.start_s.max(panel.x.low),
            interval.end_s.min(panel.x.high),
        );
        let (low, high) = (reference - SETTLED_RAD, reference + SETTLED_RAD);
        panel.area(drawing, (from, low), (to, high), GOOD, 0.14);
        let (x, _) = panel.at(interval.start_s, panel.y.low);
        // Closer lines would hide the curve.
        if place > 0 && x - drawn >= SPACING_PX {
            drawn = x;
            let stroke = Stroke {
                colour: MUTED,
                width: 0.8,
                dash: &[1.0, 3.0],
            };
            drawing.line((x, panel.frame.y), (x, panel.frame.bottom()), stroke);
        }

        let settled = settling_time_s.map_or("does not settle".to_owned(), |s| {
            format!("settled in {s:.2} s")
        });
        let rest = format!("{steady_state_error_mrad:+.1} mrad").replace('-', "−");
        let long = format!("{settled}, rests {rest} off");
        let short = format!("{settled}, {rest}");
        let (left, right) = (panel.at(from, low).0 + 7.0, panel.at(to, low).0);
        // Only a text that fits between this setpoint and the next.
        let fits = |text: &&String| left + NOTE.width(text) < right;
        let text = [&long, &short, &settled].into_iter().find(fits);
        if let Some(text) = text.filter(|_| run.behind.is_none()) {
            drawing.note((left, panel.frame.y + 16.0), text, NOTE);
        }
    }
}
