//! `path`: angle of joint 2 over that of joint 1, reference and estimate, on equal scales.

use super::axis::Axis;
use super::drawing::{Drawing, Rect, Stroke};
use super::figure;
use super::panel::{JOINT, Key, Panel, SETPOINT};
use super::phase::points;
use super::run::{Curve, Run};

/// Smallest side of the plane in rad.
const SIDE_RAD: f64 = 0.02;

pub(super) fn draw(run: &Run) -> Drawing {
    let mut drawing = figure(700.0, "Path", &run.facts);
    let panel = panel(&mut drawing, 78.0, [&run.path_curve, &run.reference_curve]);
    let estimate = Stroke::solid(JOINT[0], 1.4);
    panel.trace(&mut drawing, points(&run.path_curve), estimate);
    draw_reference(&mut drawing, &panel, run);
    draw_start(&mut drawing, &panel, run, JOINT[0]);
    let legend = [
        (Key::Line(estimate), "estimate"),
        (Key::Line(SETPOINT), "reference"),
        (Key::Ring(JOINT[0]), "first driven"),
    ];
    panel.legend(&mut drawing, &legend);
    drawing
}

/// Draws the reference, and a cross at each setpoint.
pub(super) fn draw_reference(drawing: &mut Drawing, panel: &Panel, run: &Run) {
    panel.trace(drawing, points(&run.reference_curve), SETPOINT);
    let cross = Stroke {
        dash: &[],
        ..SETPOINT
    };
    for interval in run.setpoint_intervals() {
        let [q1, q2] = [0, 1].map(|joint| f64::from(interval.joints[joint].reference_rad));
        panel.cross(drawing, (q1, q2), cross);
    }
}

/// Draws a ring where the arm is first driven.
pub(super) fn draw_start(drawing: &mut Drawing, panel: &Panel, run: &Run, colour: &'static str) {
    let driven = run.records().find(|r| r.mode.drive().is_some());
    if let Some(first) = driven {
        panel.ring(
            drawing,
            first.output.angle_rad.map(f64::from).into(),
            colour,
        );
    }
}

/// Draws the frame around all curves; a rad is as long on both axes.
pub(super) fn panel<'a>(
    drawing: &mut Drawing,
    top: f64,
    curves: impl IntoIterator<Item = &'a Curve>,
) -> Panel {
    let frame = Rect::row(top, 564.0);
    let points: Vec<_> = curves.into_iter().flat_map(points).collect();
    let x = Axis::around(points.iter().map(|(q1, _)| *q1), 0.06);
    let y = Axis::around(points.iter().map(|(_, q2)| *q2), 0.06);
    // The axis with less room has the scale of the other.
    let rad_per_px = |axis: Axis, px: f64| (axis.high - axis.low).max(SIDE_RAD) / px;
    let rad_per_px = rad_per_px(x, frame.w).max(rad_per_px(y, frame.h));
    let widened = |axis: Axis, px: f64| {
        let (middle, half) = (f64::midpoint(axis.low, axis.high), 0.5 * px * rad_per_px);
        Axis::linear(middle - half, middle + half)
    };
    let panel = Panel {
        frame,
        x: widened(x, frame.w),
        y: widened(y, frame.h),
    };
    panel.draw(
        drawing,
        "Joint 2 over joint 1, equal scales",
        Some("angle of joint 1 (rad)"),
        Some("angle of joint 2 (rad)"),
    );
    panel
}
