//! `torque`: torque and PWM sent to the servos, and their limits.

use armbridge_log::run_info::{PWM_MAX, PWM_OFF};

use super::axis::Axis;
use super::drawing::{Drawing, Rect, Stroke};
use super::figure;
use super::panel::{JOINT, Key, LIMIT, Panel};
use super::run::Run;

/// Stroke of the PWM of a servo that is off.
const OFF: Stroke = Stroke {
    colour: super::panel::FRAME,
    width: 1.2,
    dash: &[],
};

pub(super) fn draw(run: &Run) -> Drawing {
    let facts = run.facts;
    let mut drawing = figure(640.0, "Joint torque and PWM", facts);
    let pwm = Axis::linear(-0.05 * f64::from(PWM_MAX), 1.05 * f64::from(PWM_MAX));
    // Both joints on one scale, so that they can be compared.
    let torque = Axis::around(facts.torque_limits_nm.into_iter().flatten(), 0.05);
    let x = run.time_axis();
    for (joint, colour) in JOINT.into_iter().enumerate() {
        let left = 84.0 + 478.0 * joint as f64;
        let first = joint == 0;
        let line = Stroke::solid(colour, 1.3);

        let frame = Rect {
            x: left,
            y: 78.0,
            w: 454.0,
            h: 224.0,
        };
        let panel = Panel {
            frame,
            x,
            y: torque,
        };
        let title = format!("Joint {}: torque", joint + 1);
        panel.draw(&mut drawing, &title, None, first.then_some("torque (N m)"));
        run.draw_gaps(&mut drawing, &panel);
        panel.level(&mut drawing, 0.0, OFF);
        for limit in facts.torque_limits_nm[joint] {
            panel.level(&mut drawing, limit, LIMIT);
        }
        panel.curve(
            &mut drawing,
            run.over_time(|r| f64::from(r.torque_nm[joint])),
            line,
        );
        run.draw_faults(&mut drawing, &panel);
        panel.legend(
            &mut drawing,
            &[
                (Key::Line(line), "decided"),
                (Key::Line(LIMIT), "saturation"),
            ],
        );

        let frame = Rect { y: 348.0, ..frame };
        let panel = Panel { frame, x, y: pwm };
        let title = format!("Joint {}: PWM", joint + 1);
        panel.draw(
            &mut drawing,
            &title,
            Some("time (s)"),
            first.then_some("PWM (counts)"),
        );
        run.draw_gaps(&mut drawing, &panel);
        panel.level(&mut drawing, f64::from(PWM_OFF), OFF);
        for limit in [0.0, f64::from(PWM_MAX)] {
            panel.level(&mut drawing, limit, LIMIT);
        }
        panel.curve(
            &mut drawing,
            run.over_time(|r| f64::from(r.pwm_in_force[joint])),
            line,
        );
        run.draw_faults(&mut drawing, &panel);
        panel.legend(
            &mut drawing,
            &[(Key::Line(line), "in force"), (Key::Line(OFF), "off")],
        );
    }
    drawing
}
