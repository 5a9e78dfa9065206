//! Figure of the residuals: root mean square of each window over time, and autocorrelation.

use super::super::checks::{Checks, Whiteness};
use super::super::fit_result::FitResult;
use crate::plot::axis::Axis;
use crate::plot::drawing::{Drawing, Rect, Stroke};
use crate::plot::panel::{ALARM, FRAME, JOINT, Key, LIMIT, Panel};
use crate::plot::titled;

const TOP: f64 = 78.0;
const STEP: f64 = 264.0;
const HEIGHT: f64 = 186.0;
const ZERO: Stroke = Stroke::solid(FRAME, 1.2);

/// Draws the figure.
pub(super) fn draw(fit: &FitResult, checks: &Checks, period_s: f64) -> Drawing {
    let joints = checks.whiteness.len();
    let mut drawing = titled(
        TOP + STEP * (joints - 1) as f64 + HEIGHT + 52.0,
        "Residuals",
        "root mean square of each window; autocorrelation of blocks of 5 ticks",
    );
    let begins_s = begins_s(checks, period_s);
    for (joint, whiteness) in checks.whiteness.iter().enumerate() {
        let points: Vec<(f64, f64)> = fit
            .window_fits
            .iter()
            .filter(|window_fit| window_fit.window.joint == joint && window_fit.count > 0)
            .map(|window_fit| {
                let trace = &checks.traces[window_fit.window.trace];
                let within_s = trace.start_s + window_fit.window.first as f64 * period_s;
                let rms = window_fit.rms_counts();
                (begins_s[trace.log] + within_s, rms)
            })
            .collect();
        let end_s = begins_s[begins_s.len() - 1].max(1.0);
        let is_last = joint + 1 == joints;
        windows(&mut drawing, joint, &points, end_s, fit, is_last);
        correlation(&mut drawing, joint, whiteness, is_last);
    }
    drawing
}

/// Start of each log in s, one log after the other, and end of the last.
fn begins_s(checks: &Checks, period_s: f64) -> Vec<f64> {
    let logs = checks
        .traces
        .iter()
        .map(|trace| trace.log)
        .max()
        .unwrap_or(0);
    let mut begins_s = vec![0.0; logs + 2];
    for trace in &checks.traces {
        let end_s = trace.start_s + trace.counts.len() as f64 * period_s;
        begins_s[trace.log + 1] = f64::max(begins_s[trace.log + 1], end_s);
    }
    for log in 1..begins_s.len() {
        begins_s[log] += begins_s[log - 1];
    }
    begins_s
}

fn windows(
    drawing: &mut Drawing,
    joint: usize,
    points: &[(f64, f64)],
    end_s: f64,
    fit: &FitResult,
    is_last: bool,
) {
    let limit = fit.outlier_limit_counts2.sqrt();
    let high = points
        .iter()
        .fold(1.15 * limit, |high, (_, rms)| f64::max(high, rms * 1.08));
    let panel = Panel {
        frame: Rect {
            x: 84.0,
            y: TOP + STEP * joint as f64,
            w: 560.0,
            h: HEIGHT,
        },
        x: Axis::linear(0.0, end_s),
        y: Axis::linear(0.0, high),
    };
    let title = format!("Joint {}: residual of each window", joint + 1);
    let x_title = is_last.then_some("time, one log after the other (s)");
    panel.draw(drawing, &title, x_title, Some("rms (counts)"));
    panel.level(drawing, fit.noise_counts, ZERO);
    panel.level(drawing, limit, LIMIT);
    for (x, rms) in points {
        let colour = if *rms > limit { ALARM } else { JOINT[joint] };
        drawing.dots(vec![panel.at(*x, *rms)], 4.0, colour);
    }
    let keys = [
        (Key::Line(ZERO), "noise"),
        (Key::Line(LIMIT), "rejected above"),
    ];
    panel.legend(drawing, &keys);
}

fn correlation(drawing: &mut Drawing, joint: usize, whiteness: &Whiteness, is_last: bool) {
    let Whiteness {
        autocorrelation,
        bound,
        portmanteau,
        critical_value,
        ..
    } = whiteness;
    let high = autocorrelation
        .iter()
        .fold(0.1, |high, r| f64::max(high, 1.1 * r.abs()));
    let panel = Panel {
        frame: Rect {
            x: 728.0,
            y: TOP + STEP * joint as f64,
            w: 288.0,
            h: HEIGHT,
        },
        x: Axis::linear(0.0, autocorrelation.len() as f64 + 1.0),
        y: Axis::linear(-high, high),
    };
    let title = format!("portmanteau {portmanteau:.1}; noise: below {critical_value:.1}");
    let x_title = is_last.then_some("lag (blocks)");
    panel.draw(drawing, &title, x_title, Some("autocorrelation"));
    panel.level(drawing, 0.0, ZERO);
    for level in [*bound, -*bound] {
        panel.level(drawing, level, LIMIT);
    }
    let bar = Stroke::solid(JOINT[joint], 5.0);
    for (r, lag) in autocorrelation.iter().zip(1..) {
        let x = f64::from(lag);
        drawing.line(panel.at(x, 0.0), panel.at(x, *r), bar);
    }
}
