//! Colours, all among the eight that every terminal has, and none of them the only
//! sign of anything.

use ratatui::style::{Color, Modifier, Style};

/// The estimated angle.
pub(super) const ANGLE: Color = Color::Cyan;
/// The setpoint.
pub(super) const SETPOINT: Color = Color::Yellow;

/// What is in order.
pub(super) fn good() -> Style {
    Style::new().fg(Color::Green)
}

/// What wants a look.
pub(super) fn warn() -> Style {
    Style::new().fg(Color::Yellow).add_modifier(Modifier::BOLD)
}

/// What is wrong.
pub(super) fn bad() -> Style {
    Style::new().fg(Color::Red).add_modifier(Modifier::BOLD)
}

/// What is read second: axes, units, numbers that are old.
pub(super) fn faint() -> Style {
    Style::new().add_modifier(Modifier::DIM)
}

/// What is read first.
pub(super) fn strong() -> Style {
    Style::new().add_modifier(Modifier::BOLD)
}

/// A word on its own ground.
pub(super) fn badge(style: Style) -> Style {
    style.add_modifier(Modifier::REVERSED | Modifier::BOLD)
}
