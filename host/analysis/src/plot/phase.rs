//! `phase`: speed over angle of each joint.
//!
//! The curve is not drawn again where it has already been, see
//! [`trace`](super::trace), so the file of an hour is as small as that of a minute.

use super::axis::Axis;
use super::drawing::{Drawing, Rect, Stroke};
use super::figure;
use super::panel::{JOINT, Key, Panel, SETPOINT};
use super::run::{Curve, Run};

pub(super) fn draw(run: &Run) -> Drawing {
    let mut drawing = figure(586.0, "Phase plane", &run.facts);
    let driven = run.records().find(|r| r.mode.drive().is_some());
    for (joint, colour) in JOINT.into_iter().enumerate() {
        let curve = &run.phase[joint];
        let panel = panel(&mut drawing, 78.0, joint, [curve]);
        let stroke = Stroke::solid(colour, 1.3);
        panel.trace(&mut drawing, points(curve), stroke);
        let setpoint = Stroke {
            dash: &[],
            ..SETPOINT
        };
        for interval in run.setpoint_intervals() {
            let reference = f64::from(interval.joints[joint].reference_rad);
            panel.cross(&mut drawing, (reference, 0.0), setpoint);
        }
        if let Some(first) = driven {
            let state = [first.output.angle_rad, first.output.speed_rad_s]
                .map(|pair| f64::from(pair[joint]));
            panel.ring(&mut drawing, state.into(), colour);
        }
        let legend = [
            (Key::Line(stroke), "estimate"),
            (Key::Ring(colour), "first driven"),
            (Key::Cross(setpoint), "setpoint"),
        ];
        panel.legend(&mut drawing, &legend);
    }
    drawing
}

/// Draws the frame of a joint's plane, around all curves.
pub(super) fn panel<'a>(
    drawing: &mut Drawing,
    top: f64,
    joint: usize,
    curves: impl IntoIterator<Item = &'a Curve>,
) -> Panel {
    let frame = Rect {
        x: 84.0 + 500.0 * joint as f64,
        y: top,
        w: 432.0,
        h: 432.0,
    };
    let points: Vec<_> = curves.into_iter().flat_map(points).collect();
    let panel = Panel {
        frame,
        x: Axis::around(points.iter().map(|(angle, _)| *angle), 0.06),
        y: Axis::around(points.iter().map(|(_, speed)| *speed), 0.06),
    };
    panel.draw(
        drawing,
        &format!("Joint {}", joint + 1),
        Some("angle (rad)"),
        Some("speed (rad/s)"),
    );
    panel
}

/// Points of a curve, with a gap after each piece.
pub(super) fn points(curve: &Curve) -> impl Iterator<Item = (f64, f64)> {
    let gap = (f64::NAN, f64::NAN);
    let pieces = curve.iter();
    pieces.flat_map(move |piece| piece.iter().copied().chain([gap]))
}
