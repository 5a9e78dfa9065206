//! `phase`: speed over angle of each joint.
//!
//! The curve is not drawn again where it has already been, so the file of an hour is as
//! small as that of a minute.

use armbridge_client::enum_names;
use armbridge_shared::link::message::Record;

use super::axis::Axis;
use super::drawing::{Drawing, Rect, Stroke};
use super::figure;
use super::panel::{JOINT, Key, Panel, SETPOINT};
use super::run::Run;

pub(super) fn draw(run: &Run) -> Drawing {
    let mut drawing = figure(586.0, "Phase plane", run.facts);
    for (joint, colour) in JOINT.into_iter().enumerate() {
        let frame = Rect {
            x: 84.0 + 500.0 * joint as f64,
            y: 78.0,
            w: 432.0,
            h: 432.0,
        };
        let angle = |r: &Record| f64::from(r.angle_rad[joint]);
        let speed = |r: &Record| f64::from(r.speed_rad_s[joint]);
        let up = || run.shown().iter().filter(|r| enum_names::is_up(r.mode));
        let panel = Panel {
            frame,
            x: Axis::around(up().map(angle), 0.06),
            y: Axis::around(up().map(speed), 0.06),
        };
        let title = format!("Joint {}", joint + 1);
        panel.draw(
            &mut drawing,
            &title,
            Some("angle (rad)"),
            Some("speed (rad/s)"),
        );
        draw_joint(&mut drawing, &panel, run, joint, Stroke::solid(colour, 1.3));
    }
    drawing
}

fn draw_joint(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize, stroke: Stroke) {
    let state = |r: &Record| {
        let state = (
            f64::from(r.angle_rad[joint]),
            f64::from(r.speed_rad_s[joint]),
        );
        if enum_names::is_up(r.mode) {
            state
        } else {
            (f64::NAN, f64::NAN)
        }
    };
    let records = run.shown();
    // Ticks that are not consecutive make a gap.
    let states = records.iter().enumerate().flat_map(|(at, record)| {
        let gap = at > 0 && record.tick != records[at - 1].tick.wrapping_add(1);
        let gap = gap.then_some((f64::NAN, f64::NAN));
        gap.into_iter().chain([state(record)])
    });
    panel.trace(drawing, states, stroke);

    let setpoint = Stroke {
        dash: &[],
        ..SETPOINT
    };
    for interval in run.setpoint_intervals() {
        let reference = f64::from(interval.joints[joint].reference_rad);
        let (x, y) = panel.at(reference, 0.0);
        if (panel.frame.x..=panel.frame.right()).contains(&x) {
            drawing.cross((x, y), setpoint);
        }
    }
    let driven = records.iter().find(|r| r.mode.drive().is_some());
    if let Some(first) = driven.map(state)
        && first.0.is_finite()
        && first.1.is_finite()
    {
        drawing.ring(panel.at(first.0, first.1), stroke.colour);
    }
    let legend = [
        (Key::Line(stroke), "estimate"),
        (Key::Ring(stroke.colour), "first driven"),
        (Key::Cross(setpoint), "setpoint"),
    ];
    panel.legend(drawing, &legend);
}
