//! Figure of the step responses.

use armbridge_link::message::Setup;
use armbridge_servo::JOINTS;

use super::step::{Point, Responses, SHOWN_S, STEP_RAD};
use crate::plot::WIDTH;
use crate::plot::axis::Axis;
use crate::plot::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use crate::plot::panel::{ALARM, INK, JOINT, Key, MUTED, Panel, SETPOINT};

/// Time shown before the step, in s.
const BEFORE_S: f64 = 0.1;
/// Height of the figure in px.
const HEIGHT: f64 = 620.0;
/// Stroke of the linear loop.
const LINEAR: Stroke = Stroke {
    colour: INK,
    width: 1.2,
    dash: &[2.0, 3.0],
};

type Quantity = fn(&Point) -> [f64; JOINTS];

pub(super) fn figure(setup: &Setup, responses: &Responses) -> Drawing {
    let mut drawing = Drawing::new(WIDTH, HEIGHT);
    let bold = Font {
        size: 17.0,
        bold: true,
        colour: INK,
        anchor: Anchor::Start,
    };
    let [first, second] = STEP_RAD;
    let title = format!("Step to {first} and {second} rad");
    drawing.text((24.0, 32.0), &title, bold, false);
    let light = Font {
        size: 12.5,
        bold: false,
        colour: if responses.fault.is_some() {
            ALARM
        } else {
            MUTED
        },
        anchor: Anchor::End,
    };
    let ended = responses.fault.map_or_else(String::new, |fault| {
        format!(" · ended by the fault \"{fault}\"")
    });
    let conditions = format!(
        "simulated: bench with dry friction and sensor noise · period {} µs{ended}",
        setup.period_us
    );
    drawing.text((WIDTH - 24.0, 32.0), &conditions, light, false);
    let rows: [(&str, Quantity); 2] = [
        ("angle (rad)", |point| point.angle_rad),
        ("torque (N m)", |point| point.torque_nm),
    ];
    for (row, (title, quantity)) in rows.into_iter().enumerate() {
        for joint in 0..JOINTS {
            draw(&mut drawing, responses, (row, joint), title, quantity);
        }
    }
    drawing
}

fn draw(
    drawing: &mut Drawing,
    responses: &Responses,
    (row, joint): (usize, usize),
    title: &str,
    quantity: Quantity,
) {
    let shown = |points: &[Point]| {
        let shown = points
            .iter()
            .filter(|point| (-BEFORE_S..=SHOWN_S).contains(&point.at_s));
        shown
            .map(|point| (point.at_s, quantity(point)[joint]))
            .collect::<Vec<_>>()
    };
    let (linear, bench) = (shown(&responses.linear), shown(&responses.bench));
    let values = linear.iter().chain(&bench).map(|(_, value)| *value);
    let is_angle = row == 0;
    let panel = Panel {
        frame: Rect {
            x: 84.0 + 482.0 * joint as f64,
            y: 84.0 + 262.0 * row as f64,
            w: 440.0,
            h: 212.0,
        },
        x: Axis::linear(-BEFORE_S, SHOWN_S),
        y: Axis::around(values.chain([0.0]), 0.08),
    };
    let last = row == 1;
    let head = if is_angle {
        format!("Joint {}", joint + 1)
    } else {
        String::new()
    };
    let y_title = (joint == 0).then_some(title);
    // The joints' scales differ, so both have labels.
    panel.draw(
        drawing,
        &head,
        last.then_some("time since the step (s)"),
        Some(y_title.unwrap_or("")),
    );
    let arm = Stroke::solid(JOINT[joint], 1.7);
    if is_angle {
        let (begin, end) = (
            panel.at(0.0, 0.0),
            panel.at(SHOWN_S, STEP_RAD[joint].into()),
        );
        let corners = vec![panel.at(-BEFORE_S, 0.0), begin, (begin.0, end.1), end];
        drawing.polyline(vec![corners], SETPOINT);
        let entries = [
            (Key::Line(SETPOINT), "setpoint"),
            (Key::Line(arm), "true arm"),
            (Key::Line(LINEAR), "linear loop"),
        ];
        panel.legend(drawing, &entries);
    }
    panel.curve(drawing, bench.into_iter(), arm);
    panel.curve(drawing, linear.into_iter(), LINEAR);
}
