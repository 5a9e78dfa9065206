//! Figure of friction against speed: torque of the motor less gravity and inertia over short
//! segments in which a joint slides, and the estimated curve. Friction of the load on the gears is
//! left out: it depends on more than the speed.

use super::super::arm::{JointModel, KnownParameters};
use super::super::checks::Checks;
use super::super::diagnose::Bump;
use super::super::fit_result::FitResult;
use super::super::quantity::Quantity;
use crate::plot::axis::Axis;
use crate::plot::drawing::{Drawing, Rect, Stroke};
use crate::plot::panel::{FRAME, INK, JOINT, JOINT_TINT, Key, LIMIT, Panel};
use crate::plot::titled;

/// Half the length of a segment, and distance between segments, in ticks.
const HALF: usize = 60;
const STRIDE: usize = 30;
const TOP: f64 = 78.0;
const HEIGHT: f64 = 340.0;
const MODEL: Stroke = Stroke::solid(INK, 1.8);
const ZERO: Stroke = Stroke::solid(FRAME, 1.2);

/// Draws the figure.
pub(super) fn draw(fit: &FitResult, checks: &Checks, known: &KnownParameters) -> Drawing {
    let mut drawing = titled(
        TOP + HEIGHT + 52.0,
        "Friction against speed",
        "a dot: motor torque less gravity and inertia, over an eighth of a second",
    );
    for joint in 0..known.joints {
        let friction_points = friction_points(fit, checks, known, joint);
        let estimate = |quantity| fit.estimate(joint, quantity).0;
        let viscous = estimate(Quantity::Viscous);
        let model = JointModel::from_coordinates(known, &fit.coordinates, joint);
        let line = |v: f64| viscous * v + model.dry_friction(v) * v.signum();
        let x = Axis::around(
            friction_points
                .iter()
                .map(|point| point.0)
                .chain([-0.5, 0.5]),
            0.05,
        );
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
        panel.dots(
            &mut drawing,
            friction_points.iter().copied(),
            JOINT_TINT[joint],
        );
        let products = friction_points
            .iter()
            .map(|(v, torque)| v * torque)
            .sum::<f64>();
        let squares = friction_points.iter().map(|(v, _)| v * v).sum::<f64>();
        let alone = [x.low, x.high].map(|v| (v, v * products / squares));
        panel.curve(&mut drawing, alone.into_iter(), LIMIT);
        for part in [[x.low, -1e-9], [1e-9, x.high]] {
            let along = |i: u8| part[0] + (part[1] - part[0]) * f64::from(i) / 100.0;
            let curve = (0..=100).map(|i| (along(i), line(along(i))));
            panel.curve(&mut drawing, curve, MODEL);
        }
        let keys = [
            (Key::Dots(JOINT[joint]), "measured"),
            (Key::Line(MODEL), "model"),
            (Key::Line(LIMIT), "viscous alone"),
        ];
        panel.legend(&mut drawing, &keys);
    }
    drawing
}

/// Speeds in rad/s and friction torques in N m of a joint's windows.
fn friction_points(
    fit: &FitResult,
    checks: &Checks,
    known: &KnownParameters,
    joint: usize,
) -> Vec<(f64, f64)> {
    let bump = Bump::new(HALF);
    let model = JointModel::from_coordinates(known, &fit.coordinates, joint);
    let estimate = |quantity| fit.estimate(joint, quantity).0;
    let viscous = estimate(Quantity::Viscous);
    let delay_ticks = model.delay_ticks(known).round() as i64;
    let of_joint = checks
        .rollouts
        .iter()
        .filter(|rollout| rollout.window.joint == joint);
    let mut friction_points = Vec::new();
    for rollout in of_joint {
        let trace = &checks.traces[rollout.window.trace];
        let end = (rollout.window.first + rollout.window.len).saturating_sub(bump.len());
        for first in (rollout.window.first..end).step_by(STRIDE) {
            let state = |tick: usize| trace.states[tick][joint];
            let passive = |tick: usize| {
                let [q, v] = state(tick);
                model.passive_dynamics(q, v, trace.states[tick][1 - joint])
            };
            let speed = |tick: usize| state(tick)[1];
            let reverses = |tick: usize| speed(tick) * speed(first) <= 0.0;
            if (first..first + bump.len()).any(reverses) {
                continue;
            }
            let v = bump.mean(first, speed);
            let explained = bump.mean(first, |tick| {
                let pwm = trace.pwm_at(tick as i64 - delay_ticks, joint);
                let motor = model.motor_torque(pwm);
                let [q, v] = state(tick);
                let load = model.load_friction(q, v, trace.states[tick][1 - joint], motor);
                passive(tick).0 + viscous * v + motor - load * v.signum()
            });
            let inertia = passive(first + HALF).1;
            let inertial = inertia * bump.rate(first, |tick| state(tick)[1]) / known.period_s;
            friction_points.push((v, explained - inertial));
        }
    }
    friction_points
}
