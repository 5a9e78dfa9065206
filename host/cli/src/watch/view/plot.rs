//! One joint's angle and setpoint over the last ten seconds, in braille dots: two by
//! four to a character. The angle is a line, the setpoint a dashed one, so that they
//! are distinct without colour.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::Paragraph;
use ratatui::widgets::canvas::{Canvas, Context, Line as Stroke};

use super::theme;
use crate::watch::model::{Model, SPAN_S, Slice};

/// Columns for the labels of the angles.
const LABELS: u16 = 7;
/// The least range that is shown, in rad: noise of a few encoder counts stays small.
const RANGE_MIN_RAD: f64 = 0.1;
/// Slices farther apart than this are not joined: at the longest period there are 100
/// ms between ticks.
const GAP_S: f64 = 0.25;
/// One dash of the setpoint and the gap after it, in slices.
const DASH: u64 = 40;

/// Draws it, axes included.
pub(super) fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model, joint: usize) {
    let [upper, below] = Layout::vertical([Constraint::Min(1), Constraint::Length(1)]).areas(area);
    let [labels, inside] =
        Layout::horizontal([Constraint::Length(LABELS), Constraint::Min(1)]).areas(upper);
    let now_s = model.board_s();
    let since_s = now_s - SPAN_S;
    let axis = Axis::over(model.history.range(joint, since_s), labels.height);

    let canvas = Canvas::default()
        .marker(Marker::Braille)
        .x_bounds([since_s, now_s])
        .y_bounds([axis.low, axis.high])
        .paint(|context| {
            setpoint(context, model, joint);
            angle(context, model, joint);
        });
    frame.render_widget(canvas, inside);
    for (row, text) in axis.labels(labels.height) {
        let place = Rect {
            y: labels.y + row,
            height: 1,
            ..labels
        };
        frame.render_widget(Paragraph::new(text), place);
    }
    times(
        frame,
        Rect {
            x: inside.x,
            width: inside.width,
            ..below
        },
    );
}

/// The line below: how long ago.
fn times(frame: &mut Frame<'_>, area: Rect) {
    let thirds = Layout::horizontal([Constraint::Ratio(1, 3); 3]).areas(area);
    let [left, middle, right]: [Rect; 3] = thirds;
    let line = |text: &'static str| Line::from(text).style(theme::faint());
    frame.render_widget(line("-10 s").left_aligned(), left);
    frame.render_widget(line("-5 s").centered(), middle);
    frame.render_widget(line("now").right_aligned(), right);
}

fn angle(context: &mut Context<'_>, model: &Model, joint: usize) {
    let mut before: Option<&Slice> = None;
    for slice in model.history.slices() {
        let (seen, at_s) = (slice.joints[joint], slice.at_s());
        let (low, high) = (f64::from(seen.low), f64::from(seen.high));
        stroke(context, (at_s, low), (at_s, high), theme::ANGLE);
        if let Some(before) = before.filter(|before| at_s - before.at_s() < GAP_S) {
            let last = before.joints[joint];
            let middle = f64::from(last.low).midpoint(f64::from(last.high));
            let from = (before.at_s(), middle);
            stroke(context, from, (at_s, low.midpoint(high)), theme::ANGLE);
        }
        before = Some(slice);
    }
}

fn setpoint(context: &mut Context<'_>, model: &Model, joint: usize) {
    let mut before: Option<(f64, f64)> = None;
    for slice in model.history.slices() {
        let here = slice.joints[joint]
            .setpoint
            .map(|setpoint| (slice.at_s(), f64::from(setpoint)));
        if let (Some(from), Some(to)) = (before, here)
            && slice.number % DASH < DASH * 5 / 8
            && to.0 - from.0 < GAP_S
        {
            stroke(context, from, to, theme::SETPOINT);
        }
        before = here;
    }
}

fn stroke(context: &mut Context<'_>, from: (f64, f64), to: (f64, f64), color: Color) {
    context.draw(&Stroke {
        x1: from.0,
        y1: from.1,
        x2: to.0,
        y2: to.1,
        color,
    });
}

/// Quantity of the ordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    /// Rounded tick spacing over this range, for `rows` rows.
    fn over(range: Option<(f32, f32)>, rows: u16) -> Self {
        let (low, high) = range.unwrap_or((0.0, 0.0));
        let (low, high) = (f64::from(low), f64::from(high));
        let middle = low.midpoint(high);
        let half = (high - low).max(RANGE_MIN_RAD) / 2.0;
        let (low, high) = (middle - half, middle + half);
        let labels = f64::from((rows / 2).clamp(2, 6));
        let step = round_step((high - low) / labels);
        Self {
            low: (low / step).floor() * step,
            high: (high / step).ceil() * step,
            step,
        }
    }

    /// Labels by row; the top row is 0.
    fn labels(self, rows: u16) -> Vec<(u16, String)> {
        let steps = ((self.high - self.low) / self.step).round() as u32;
        let most = u32::from(rows / 2).max(1);
        // At most one label in two rows.
        let every = steps.div_ceil(most).max(1);
        let last = f64::from(rows.saturating_sub(1));
        (0..=steps)
            .filter(|step| step % every == 0)
            .map(|step| {
                let share = f64::from(step) / f64::from(steps.max(1));
                let value = self.low + f64::from(step) * self.step;
                // Zero has no sign.
                let value = if value.abs() < self.step / 2.0 {
                    0.0
                } else {
                    value
                };
                let row = (last * (1.0 - share)).round() as u16;
                (row, format!("{value:>6.2}"))
            })
            .collect()
    }
}

/// The round number next above: 1, 2 or 5 times a power of ten, at least a hundredth.
fn round_step(step: f64) -> f64 {
    let decade = 10_f64.powf(step.log10().floor());
    let round = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * decade)
        .find(|round| *round >= step * 0.999);
    round.unwrap_or(step).max(0.01)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_round_and_hold_what_is_seen() {
        for (low, high) in [
            (0.0_f32, 0.0_f32),
            (-0.25, 0.31),
            (-1.5, 1.5),
            (0.299, 0.301),
        ] {
            for rows in [4, 7, 23] {
                let axis = Axis::over(Some((low, high)), rows);
                assert!(
                    axis.low <= low.into() && axis.high >= high.into(),
                    "{axis:?}"
                );
                let labels = axis.labels(rows);
                assert!(labels.len() >= 2, "{labels:?}");
                let mut taken: Vec<_> = labels.iter().map(|(row, _)| *row).collect();
                assert!(taken.iter().all(|row| *row < rows));
                taken.dedup();
                assert_eq!(taken.len(), labels.len(), "{labels:?}");
            }
        }
        assert!((round_step(0.13) - 0.2).abs() < 1e-12);
    }
}
