//! `torque`: torque decided and torque sent to each servo, with the servos' limits.
//!
//! The servo receives a PWM value. Its torque, by the joint's calibration, is that decided in
//! the tick before, plus what is added against friction, limited and rounded to counts; the
//! axis on the right has the values themselves. Of an arm that floats there is only what is sent:
//! no controller has decided a part of it.

use armbridge_link::message::{Drive, Record};
use armbridge_log::run_info::PWM_MAX;
use armbridge_servo::Pwm;

use super::axis::Axis;
use super::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use super::panel::{FRAME, JOINT, JOINT_TINT, Key, LABEL, LIMIT, Panel};
use super::run::Run;
use super::{figure, marks, panel};

/// PWM values on the axis.
const PWM_TICKS: [u16; 5] = [0, 500, 1000, 1500, PWM_MAX];

pub(super) fn draw(run: &Run) -> Drawing {
    let joints = run.facts.joints();
    let mut drawing = figure(panel::height(joints), "Joint torque", &run.facts);
    let limits = run.facts.torque_limits_nm;
    // All joints on one scale, so that they can be compared.
    let y = Axis::around(limits.into_iter().take(joints).flatten(), 0.05);
    for joint in 0..joints {
        let frame = Rect {
            w: 872.0,
            ..Rect::row(78.0 + 270.0 * joint as f64, 224.0)
        };
        let panel = Panel {
            frame,
            x: run.time_axis(),
            y,
        };
        let x_title = (joint + 1 == joints).then_some("time (s)");
        let title = format!("Joint {}", joint + 1);
        panel.draw(&mut drawing, &title, x_title, Some("torque (N m)"));
        draw_pwm_axis(&mut drawing, &panel, run, joint);
        marks::draw(&mut drawing, &panel, run, joint);
        if joint == 0 {
            marks::draw_texts(&mut drawing, &panel, run, marks::LANE_PX);
        }
        panel.level(&mut drawing, 0.0, Stroke::solid(FRAME, 1.2));
        for limit in limits[joint] {
            panel.level(&mut drawing, limit, LIMIT);
        }
        let sent = Stroke::solid(JOINT_TINT[joint], 1.6);
        let decided = Stroke::solid(JOINT[joint], 1.3);
        let torque = run.over_time(|r| torque_nm(run, joint, r.input.pwm_in_force[joint]));
        panel.curve(&mut drawing, torque, sent);
        let torque = run.over_time(|r| decided_nm(r, joint));
        panel.curve(&mut drawing, torque, decided);
        let legend = [
            (Key::Line(decided), "decided by the controller"),
            (Key::Line(sent), "sent, with friction feed-forward"),
            (Key::Line(LIMIT), "saturation"),
        ];
        panel.legend(&mut drawing, &legend);
    }
    drawing
}

/// Torque in N m that a controller has decided; NaN of an arm that floats.
fn decided_nm(record: &Record, joint: usize) -> f64 {
    if record.mode.drive() == Some(Drive::Float) {
        return f64::NAN;
    }
    record.output.torque_nm[joint].into()
}

/// Torque in N m of a PWM value, by the calibration of the joint.
fn torque_nm(run: &Run, joint: usize, pwm: u16) -> f64 {
    let torque_nm = |pwm| f64::from(run.facts.setup.joints[joint].torque(pwm));
    Pwm::new(pwm).map_or(f64::NAN, torque_nm)
}

/// Draws the PWM values that have the torques of the panel's axis.
fn draw_pwm_axis(drawing: &mut Drawing, panel: &Panel, run: &Run, joint: usize) {
    let right = panel.frame.right();
    let font = Font {
        anchor: Anchor::Start,
        ..LABEL
    };
    for pwm in PWM_TICKS {
        let (_, y) = panel.at(panel.x.high, torque_nm(run, joint, pwm));
        drawing.line((right, y), (right + 4.0, y), Stroke::solid(FRAME, 1.0));
        drawing.text((right + 8.0, y + 4.0), &pwm.to_string(), font, false);
    }
    let middle = panel.frame.y + panel.frame.h / 2.0;
    drawing.text((right + 58.0, middle), "PWM (counts)", LABEL, true);
}
