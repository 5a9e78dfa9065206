//! Colours, all among the eight that every terminal has, and none of them the only
//! sign of anything.

use ratatui::style::{Color, Modifier, Style};

/// The estimated angle.
pub(super) const ANGLE: Color = Color::Cyan;
/// The setpoint.
pub(super) const SETPOINT: Color = Color::Yellow;

/// Normal values.
pub(super) fn good() -> Style {
    Style::new().fg(Color::Green)
}

/// Warnings.
pub(super) fn warn() -> Style {
    Style::new().fg(Color::Yellow).add_modifier(Modifier::BOLD)
}

/// Errors and faults.
pub(super) fn bad() -> Style {
    Style::new().fg(Color::Red).add_modifier(Modifier::BOLD)
}

/// Secondary text: axes, units, numbers that are old.
pub(super) fn faint() -> Style {
    Style::new().add_modifier(Modifier::DIM)
}

/// Primary text.
pub(super) fn strong() -> Style {
    Style::new().add_modifier(Modifier::BOLD)
}

/// A word on its own ground.
pub(super) fn badge(style: Style) -> Style {
    style.add_modifier(Modifier::REVERSED | Modifier::BOLD)
}
