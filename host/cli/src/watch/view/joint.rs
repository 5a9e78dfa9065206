//! One joint: its plot, the estimate in numbers, its torque against the limit.

use armbridge_control::estimate::Config;
use armbridge_link::limits::hard;
use armbridge_link::message::Drive;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Style, Stylize};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::Block;

use super::{plot, theme};
use crate::watch::model::{Line as LinkLine, Model};

/// Height in rows from which the bar has a line of its own.
const ROOMY: u16 = 10;

/// Draws it.
pub(super) fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model, joint: usize) {
    let is_old = model.board.record.is_some() && model.line() != LinkLine::Up;
    let mut title = vec![
        Span::from(format!(" joint {}  ", joint + 1)).style(theme::strong()),
        Span::from("── ").fg(theme::ANGLE),
        Span::from("angle  "),
        Span::from("╌╌ ").fg(theme::SETPOINT),
        Span::from("setpoint "),
    ];
    if is_old {
        title.push(Span::from("OLD ").style(theme::warn()));
    }
    let block = Block::bordered().title(Line::from(title));
    let inside = block.inner(area);
    frame.render_widget(block, area);
    let mut lines = estimate(model, joint).to_vec();
    let torque = Torque::of(model, joint);
    if inside.height >= ROOMY {
        lines.push(torque.number());
        lines.push(torque.bar(inside.width, ""));
    } else {
        lines.push(torque.bar(inside.width, &torque.short()));
    }
    let [above, numbers] =
        Layout::vertical([Constraint::Min(3), Constraint::Length(lines.len() as u16)])
            .areas(inside);
    plot::draw(frame, above, model, joint);
    let style = if is_old { theme::faint() } else { Style::new() };
    frame.render_widget(Text::from(lines).style(style), numbers);
}

/// Angle, setpoint, speed and disturbance.
fn estimate(model: &Model, joint: usize) -> [Line<'static>; 2] {
    let Some(record) = &model.board.record else {
        return [Line::from("nothing measured yet"), Line::default()];
    };
    let value = |text: String| Span::from(text).style(theme::strong());
    let mut first = vec![
        Span::from("angle "),
        value(format!("{:+.4}", record.output.angle_rad[joint])),
    ];
    // Nothing heeds it otherwise.
    if record.mode.drive().is_some_and(Drive::is_closed_loop) {
        first.push(Span::from("  setpoint "));
        first.push(value(format!("{:+.4}", record.output.reference_rad[joint])));
    }
    first.push(Span::from(" rad"));
    let mut second = vec![
        Span::from("speed "),
        value(format!("{:+.3}", record.output.speed_rad_s[joint])),
        Span::from(" rad/s  disturb "),
    ];
    // Not every estimator looks for it.
    let estimator = model
        .board
        .settings
        .map(|settings| settings.setup.estimator);
    match estimator {
        Some(Config::FiniteDifference { .. } | Config::Luenberger { .. } | Config::Gain { .. }) => {
            second.push(Span::from("not estim."));
        }
        Some(Config::Kalman(_)) | None => {
            second.push(value(format!(
                "{:+.3}",
                record.output.disturbance_nm[joint]
            )));
            second.push(Span::from(" N m"));
        }
    }
    [Line::from(first), Line::from(second)]
}

/// Torque and its limit, in N m.
#[derive(Clone, Copy)]
struct Torque {
    now_nm: f32,
    limit_nm: f32,
    /// The limit is not the board's, which is not known, but the hard bound.
    is_assumed: bool,
}

impl Torque {
    fn of(model: &Model, joint: usize) -> Self {
        let limits = model
            .board
            .settings
            .map(|settings| settings.limits.torque_nm);
        Self {
            now_nm: model
                .board
                .record
                .map_or(0.0, |record| record.output.torque_nm[joint]),
            limit_nm: limits.map_or(hard::TORQUE_NM, |limits| limits[joint]),
            is_assumed: limits.is_none(),
        }
    }

    fn number(self) -> Line<'static> {
        let limit = if self.is_assumed {
            "limit not known".to_owned()
        } else {
            format!("limit ±{:.2}", self.limit_nm)
        };
        Line::from(vec![
            Span::from("torque "),
            Span::from(format!("{:+.3}", self.now_nm)).style(theme::strong()),
            Span::from(format!(" N m, {limit}")),
        ])
    }

    fn short(self) -> String {
        format!("torque {:+.3} N m ", self.now_nm)
    }

    /// A bar from the middle to either limit.
    fn bar(self, width: u16, before: &str) -> Line<'static> {
        let taken = before.chars().count() + 2;
        let half = (usize::from(width).saturating_sub(taken + 1) / 2).max(1);
        let share = f64::from(self.now_nm / self.limit_nm).clamp(-1.0, 1.0);
        let style = match share.abs() {
            share if share > 0.95 => theme::bad(),
            share if share > 0.75 => theme::warn(),
            _ => theme::good(),
        };
        let (below, above) = if share < 0.0 {
            let outwards = filled(-share, half, '▐');
            (outwards.chars().rev().collect(), String::new())
        } else {
            (String::new(), filled(share, half, '▌'))
        };
        Line::from(vec![
            Span::from(before.to_owned()),
            Span::from("▕"),
            Span::from(format!("{below:>half$}")).style(style),
            Span::from("│").style(theme::faint()),
            Span::from(format!("{above:<half$}")).style(style),
            Span::from("▏"),
        ])
    }
}

/// Part of a bar, outwards; `half` is half a character.
fn filled(share: f64, width: usize, half: char) -> String {
    let halves = (share * 2.0 * width as f64).round() as usize;
    let mut text = "█".repeat(halves / 2);
    if halves % 2 == 1 {
        text.push(half);
    }
    text
}
