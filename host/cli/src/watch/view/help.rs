//! The help on keys, drawn over everything else.

use ratatui::Frame;
use ratatui::layout::{Constraint, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph};

use super::theme;

const KEYS: [(&str, &str); 13] = [
    (
        "space, s",
        "emergency stop, at once: torque off, a fault is latched",
    ),
    ("d", "disarm, at once: torque off, no fault; the arm falls"),
    (
        "p",
        "park: moves to the pose of park.angle_rad, lowered there",
    ),
    ("c", "clear a fault: the servos are looked for, then idle"),
    ("a", "arm: asks; torque may come on from then, but is zero"),
    (
        "r",
        "regulate: asks whether to hold here or to move upright",
    ),
    (
        "f",
        "float: asks; the arm weighs nothing, and a hand leads it",
    ),
    (
        "t",
        "teach: writes the motion of the last float to taught.csv",
    ),
    ("m", "motion: asks; the last float is replayed"),
    ("← →", "setpoint of joint 1, by 0.02 rad"),
    ("↓ ↑", "setpoint of joint 2, by 0.02 rad"),
    ("q, ctrl-c", "quit: parks or disarms first"),
    ("?", "this; any key closes it"),
];

/// Keys for hands on a simulated arm.
const HANDS: [(&str, &str); 2] = [
    (
        "1, 2",
        "simulated arm: push joint 1 or 2, 0.3 N m for 0.2 s",
    ),
    (
        "l",
        "simulated arm: lift it up again, and hold it until it is driven",
    ),
];

/// Draws it in the middle.
pub(super) fn draw(frame: &mut Frame<'_>, area: Rect, is_touchable: bool) {
    let hands = if is_touchable { &HANDS[..] } else { &[] };
    let keys = KEYS.iter().chain(hands);
    let mut lines: Vec<_> = keys
        .map(|(key, action)| {
            Line::from(vec![
                Span::from(format!(" {key:<10}")).style(theme::strong()),
                Span::from(*action),
            ])
        })
        .collect();
    lines.push(Line::default());
    lines.push(Line::from(
        " late: how late ticks start · bars: counts, logarithmic, last 10 000 ticks",
    ));
    lines.push(Line::from(
        " dropped: records not fetched in time · foreign: frames of another version",
    ));
    lines.push(Line::from(
        " unseen: events that this screen had no time for",
    ));
    let height = lines.len() as u16 + 2;
    let block = Block::bordered().title(Line::from(" keys ").style(theme::strong()));
    let place = area.centered(Constraint::Length(76), Constraint::Length(height));
    frame.render_widget(Clear, place);
    frame.render_widget(Paragraph::new(lines).block(block), place);
}
