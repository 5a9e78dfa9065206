//! Friction over speed: what of motor, gravity and inertia is left of the torque over short
//! stretches in which a joint slides, and the curve that was found.

use armbridge_shared::JOINTS;

use super::super::arm::{Joint, Known};
use super::super::checks::Checks;
use super::super::diagnose::Bump;
use super::super::fit_result::Found;
use super::super::quantity::Quantity;
use crate::plot::axis::Axis;
use crate::plot::drawing::{Drawing, Rect, Stroke};
use crate::plot::panel::{FRAME, INK, JOINT, JOINT_TINT, Key, LIMIT, Panel};
use crate::plot::titled;

/// Half a stretch, and from one to the next, in ticks.
const HALF: usize = 60;
const STRIDE: usize = 30;
const TOP: f64 = 78.0;
const HEIGHT: f64 = 340.0;
const FOUND: Stroke = Stroke::solid(INK, 1.8);
const ZERO: Stroke = Stroke::solid(FRAME, 1.2);

/// The picture.
pub(super) fn draw(found: &Found, checks: &Checks, known: &Known) -> Drawing {
    let mut drawing = titled(
        TOP + HEIGHT + 52.0,
        "Friction against speed",
        "a dot: motor torque less gravity and inertia, over an eighth of a second",
    );
    for joint in 0..JOINTS {
        let points = points(found, checks, known, joint);
        let number = |quantity| found.number(joint, quantity).0;
        let viscous = number(Quantity::Viscous);
        let model = Joint::of(known, &found.at, joint);
        let line = |v: f64| viscous * v + model.dry(v) * v.signum();
        let x = Axis::around(points.iter().map(|point| point.0).chain([-0.5, 0.5]), 0.05);
        let ends = [x.low, x.high, -1e-9, 1e-9].map(line);
        let panel = Panel {
            frame: Rect {
                x: 84.0 + 496.0 * joint as f64,
                y: TOP,
                w: 420.0,
                h: HEIGHT,
            },
            x,
            y: Axis::around(ends.into_iter(), 0.12),
        };
        let title = format!("Joint {}", joint + 1);
        let y_title = if joint == 0 { "friction (N m)" } else { "" };
        panel.draw(&mut drawing, &title, Some("speed (rad/s)"), Some(y_title));
        panel.level(&mut drawing, 0.0, ZERO);
        panel.dots(&mut drawing, points.iter().copied(), JOINT_TINT[joint]);
        let products = points.iter().map(|(v, torque)| v * torque).sum::<f64>();
        let squares = points.iter().map(|(v, _)| v * v).sum::<f64>();
        let alone = [x.low, x.high].map(|v| (v, v * products / squares));
        panel.curve(&mut drawing, alone.into_iter(), LIMIT);
        for part in [[x.low, -1e-9], [1e-9, x.high]] {
            let along = |i: u8| part[0] + (part[1] - part[0]) * f64::from(i) / 100.0;
            let curve = (0..=100).map(|i| (along(i), line(along(i))));
            panel.curve(&mut drawing, curve, FOUND);
        }
        let keys = [
            (Key::Dots(JOINT[joint]), "measured"),
            (Key::Line(FOUND), "found"),
            (Key::Line(LIMIT), "viscous alone"),
        ];
        panel.legend(&mut drawing, &keys);
    }
    drawing
}

/// Speeds in rad/s and friction torques in N m of a joint's windows.
fn points(found: &Found, checks: &Checks, known: &Known, joint: usize) -> Vec<(f64, f64)> {
    let bump = Bump::new(HALF);
    let model = Joint::of(known, &found.at, joint);
    let number = |quantity| found.number(joint, quantity).0;
    let viscous = number(Quantity::Viscous);
    let delay_ticks = model.delay_ticks(known).round() as i64;
    let of_joint = checks
        .followed
        .iter()
        .filter(|followed| followed.window.joint == joint);
    let mut points = Vec::new();
    for followed in of_joint {
        let trace = &checks.traces[followed.window.trace];
        let end = (followed.window.first + followed.window.len).saturating_sub(bump.len());
        for first in (followed.window.first..end).step_by(STRIDE) {
            let state = |tick: usize| trace.smooth[tick][joint];
            let push = |tick: usize| {
                let [q, v] = state(tick);
                model.push(q, v, trace.smooth[tick][1 - joint])
            };
            let speed = |tick: usize| state(tick)[1];
            let turns = |tick: usize| speed(tick) * speed(first) <= 0.0;
            if (first..first + bump.len()).any(turns) {
                continue;
            }
            let v = bump.mean(first, speed);
            let given = bump.mean(first, |tick| {
                let pwm = trace.pwm_at(tick as i64 - delay_ticks, joint);
                push(tick).0 + viscous * state(tick)[1] + model.torque(pwm)
            });
            let mass = push(first + HALF).1;
            let needed = mass * bump.rate(first, |tick| state(tick)[1]) / known.period_s;
            points.push((v, given - needed));
        }
    }
    points
}
