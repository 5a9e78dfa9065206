//! Draws what the dashboard knows. Pure: the same model and keys are the same picture.
//!
//! ```text
//! which link                                                     how it does
//! mode, fault, what to do                                     one to three lines
//! ┌ joint 1 ───────────────────────────┐┌ joint 2 ───────────────────────────┐
//! │ plot, estimate, torque             ││                                    │
//! ├ link ────────────────┬ bus ────────┴┴───────┬ tick timing ───────────────┤
//! └──────────────────────┴──────────────────────┴────────────────────────────┘
//! question or answer
//! keys
//! ```

mod head;
mod health;
mod help;
mod joint;
mod plot;
mod theme;

use armbridge_link::message::Refusal;
use armbridge_log::text_table;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Text};
use ratatui::widgets::{Paragraph, Wrap};

use super::keys::Keys;
use super::model::Model;

/// The least there must be, in columns and rows.
const LEAST: (u16, u16) = (80, 24);
/// Height in rows from which the boxes below are higher.
const HIGH: u16 = 34;

/// Keys, in the last line.
const KEYS: &str =
    " space STOP  a arm  r regulate  ←→↑↓ setpoint  d disarm  c clear  ? help  q quit";

/// Draws it all; `what` names the link and the world behind it.
pub fn draw(frame: &mut Frame<'_>, model: &Model, keys: &Keys, link_name: &str) {
    let area = frame.area();
    if area.width < LEAST.0 || area.height < LEAST.1 {
        too_small(frame, area, model, keys.is_observer());
        return;
    }
    let mut state = head::state(model, keys.is_observer());
    state.extend(keys.role.and_then(head::observer));
    let below = if area.height < HIGH { 7 } else { 10 };
    let conversation = conversation(model, keys, area.width.into());
    let [title, top, joints, health, answer, last] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(state.len() as u16),
        Constraint::Min(10),
        Constraint::Length(below),
        Constraint::Length(conversation.len() as u16),
        Constraint::Length(1),
    ])
    .areas(area);
    frame.render_widget(head::title(model, keys.role, link_name, area.width), title);
    frame.render_widget(Text::from(state), top);
    let count = model.board.joints();
    let share = Constraint::Ratio(1, count as u32);
    let panels = Layout::horizontal((0..count).map(|_| share)).split(joints);
    for (number, panel) in panels.iter().enumerate() {
        joint::draw(frame, *panel, model, number);
    }
    let [left, middle, right] = Layout::horizontal([
        Constraint::Ratio(26, 80),
        Constraint::Ratio(27, 80),
        Constraint::Ratio(27, 80),
    ])
    .areas(health);
    health::link(frame, left, model);
    health::bus(frame, middle, model);
    health::timing(frame, right, model);
    frame.render_widget(Text::from(conversation), answer);
    frame.render_widget(Line::from(KEYS).style(theme::badge(Style::new())), last);
    if keys.is_helping {
        help::draw(frame, area, keys.is_touchable);
    }
}

/// A question first, then why a key did nothing, then what the board answered: one line, or
/// as many as a long answer takes.
fn conversation(model: &Model, keys: &Keys, width: usize) -> Vec<Line<'static>> {
    if let Some(question) = keys.question {
        let question = Line::from(format!(" ? {}", question.text()));
        return vec![question.style(theme::badge(theme::warn()))];
    }
    if let Some(note) = keys.note {
        return vec![Line::from(format!(" {note}")).style(theme::warn())];
    }
    let answer = keys.result.clone().unwrap_or_else(|| {
        let mut answer = model.link.answer.clone().unwrap_or_default();
        let is_beyond = matches!(model.link.arm_refusal, Some(Refusal::BeyondLimit { .. }));
        if is_beyond && keys.is_touchable {
            answer.push_str("; or press l, which lifts the simulated arm");
        }
        answer
    });
    let lines = text_table::wrap(answer.split(' '), " ", width - 1, "");
    lines
        .into_iter()
        .map(|line| Line::from(format!(" {line}")))
        .collect()
}

/// Mode and keys, on a terminal too small for the dashboard.
fn too_small(frame: &mut Frame<'_>, area: Rect, model: &Model, is_observer: bool) {
    let mut lines = head::state(model, is_observer);
    lines.push(Line::from(format!(
        "this terminal is {}x{}, the dashboard needs {}x{}: make it larger",
        area.width, area.height, LEAST.0, LEAST.1
    )));
    lines.push(Line::from("keys work: space stops, d disarms, q quits"));
    let text = Paragraph::new(lines).wrap(Wrap { trim: true });
    frame.render_widget(text, area);
}
