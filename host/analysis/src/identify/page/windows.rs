//! Figure of measured and computed motion: of a joint's longer windows the one with the
//! smallest residual, the median, and the one with the largest.

use super::super::checks::{Checks, Rollout};
use crate::plot::axis::Axis;
use crate::plot::drawing::{Drawing, Rect, Stroke};
use crate::plot::panel::{FRAME, INK, JOINT, JOINT_TINT, Key, Panel};
use crate::plot::titled;

const LEFT: f64 = 84.0;
const TOP: f64 = 78.0;
const WIDTH: f64 = 255.0;
const STEP: f64 = 342.0;
const HEIGHTS: [f64; 2] = [230.0, 110.0];
const GAP: f64 = 40.0;
const COMPUTED: Stroke = Stroke::solid(INK, 1.5);
const ZERO: Stroke = Stroke::solid(FRAME, 1.2);

/// Draws the figure of a joint; `None` if it has no window.
pub(super) fn draw(checks: &Checks, joint: usize, period_s: f64) -> Option<Drawing> {
    let mut windows: Vec<(f64, &Rollout)> = checks
        .rollouts
        .iter()
        .filter(|rollouts| rollouts.window.joint == joint)
        .map(|rollouts| (rollouts.rms(0..rollouts.window.len), rollouts))
        .collect();
    // Windows of the shorter half show little.
    windows.sort_by_key(|(_, rollouts)| rollouts.window.len);
    windows.drain(..windows.len() / 2);
    windows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let last = windows.len().checked_sub(1)?;
    let title = format!("Joint {}: measured and computed", joint + 1);
    let height = TOP + HEIGHTS[0] + GAP + HEIGHTS[1] + 52.0;
    let mut drawing = titled(height, &title, "");
    let top = Panel {
        frame: Rect {
            x: LEFT,
            y: 44.0,
            w: WIDTH + 2.0 * STEP,
            h: 0.0,
        },
        x: Axis::around([].into_iter(), 0.0),
        y: Axis::around([].into_iter(), 0.0),
    };
    let keys = [
        (Key::Dots(JOINT_TINT[joint]), "measured"),
        (Key::Line(COMPUTED), "computed"),
    ];
    top.legend(&mut drawing, &keys);
    for (column, (name, index)) in [("best", 0), ("median", last / 2), ("worst", last)]
        .into_iter()
        .enumerate()
    {
        let (rms, window) = windows[index];
        let left = LEFT + STEP * column as f64;
        let title = format!("{name}: {rms:.2} counts rms");
        draw_window(&mut drawing, &title, window, checks, [left, period_s]);
    }
    Some(drawing)
}

fn draw_window(
    drawing: &mut Drawing,
    title: &str,
    window: &Rollout,
    checks: &Checks,
    [left, period_s]: [f64; 2],
) {
    let trace = &checks.traces[window.window.trace];
    let from_s = trace.start_s + window.window.first as f64 * period_s;
    let time_s = |tick: usize| from_s + tick as f64 * period_s;
    let frame = Rect {
        x: left,
        y: TOP,
        w: WIDTH,
        h: HEIGHTS[0],
    };
    let x = Axis::linear(from_s, time_s(window.window.len));
    let residuals = || window.residuals.iter().copied().enumerate();
    let computed = || window.computed.iter().copied().enumerate();
    let measured = || {
        residuals()
            .zip(computed())
            .map(|((tick, e), (_, c))| (time_s(tick), c + e))
    };
    let is_first = left < LEFT + 1.0;
    let joint = window.window.joint;
    let panel = Panel {
        frame,
        x,
        y: Axis::around(measured().map(|(_, y)| y), 0.06),
    };
    panel.draw(
        drawing,
        title,
        None,
        Some(if is_first { "encoder (counts)" } else { "" }),
    );
    panel.dots(drawing, measured(), JOINT_TINT[joint]);
    panel.curve(
        drawing,
        computed().map(|(tick, y)| (time_s(tick), y)),
        COMPUTED,
    );
    let below = Panel {
        frame: Rect {
            y: TOP + HEIGHTS[0] + GAP,
            h: HEIGHTS[1],
            ..frame
        },
        x,
        y: Axis::around(residuals().map(|(_, error)| error).chain([-6.0, 6.0]), 0.04),
    };
    let y_title = if is_first { "error (counts)" } else { "" };
    let log = format!("time in log {} (s)", trace.log + 1);
    below.draw(drawing, "residual", Some(&log), Some(y_title));
    below.level(drawing, 0.0, ZERO);
    below.dots(
        drawing,
        residuals().map(|(tick, e)| (time_s(tick), e)),
        JOINT[joint],
    );
}
