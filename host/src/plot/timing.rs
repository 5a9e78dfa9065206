//! `timing`: did every tick start when it should and end before the next?
//!
//! Each quantity over time, and beside it, on the same axis, how often each
//! value came. Counts are on a logarithmic axis: the one tick in ten thousand
//! is what one looks for.

use super::axis::{Axis, Scale};
use super::panel::{INK, Key, LIMIT, Panel};
use super::svg::{Anchor, Font, Rect, Stroke, Svg};
use super::{WIDTH, draw_faults, figure, over_time, time_axis};
use crate::facts::RunFacts;
use crate::log::names;
use crate::summary::Spread;
use armbridge_shared::link::message::Record;

/// Colours that say "not a joint".
const LINE: &str = "#4b6478";
const BAR: &str = "#8aa3b5";

/// Height of a bar of a histogram in px.
const BIN_PX: f64 = 4.0;

/// One of the quantities.
struct Quantity {
    title: &'static str,
    axis_title: &'static str,
    /// In the unit that the record holds.
    of: fn(&Record) -> u32,
    /// µs of that unit.
    us: f64,
}

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        title: "Tick start, actual minus planned",
        axis_title: "late by (µs)",
        of: |r| r.timing.start_error_us,
        us: 1.0,
    },
    Quantity {
        title: "Bus, first bit of the request to last of the replies",
        axis_title: "bus time (µs)",
        of: |r| r.timing.bus_us,
        us: 1.0,
    },
    Quantity {
        title: "Estimator, controller and supervisor",
        axis_title: "compute time (µs)",
        of: |r| r.timing.compute_ns,
        us: 1e-3,
    },
];

pub(super) fn draw(facts: &RunFacts, records: &[Record]) -> String {
    let mut svg = figure(760.0, "Tick timing", facts);
    let up: Vec<Record> = records
        .iter()
        .copied()
        .filter(|r| names::is_up(r.mode))
        .collect();
    let period_us = f64::from(facts.period_us);
    for (row, quantity) in QUANTITIES.iter().enumerate() {
        let values: Vec<u32> = up.iter().map(quantity.of).collect();
        let spread = Spread::of(values.clone());
        let highest = f64::from(spread.max) * quantity.us;
        let y = match row {
            // Zero is common and outliers are what matters.
            0 => Axis {
                scale: Scale::LogFromOne,
                low: 0.0,
                high: (highest * 1.4).max(10.0),
            },
            // The share of the period is what matters.
            1 => Axis {
                scale: Scale::Linear,
                low: 0.0,
                high: highest.max(period_us) * 1.06,
            },
            _ => compute_axis(&values, quantity.us),
        };
        let frame = Rect {
            x: 84.0,
            y: 78.0 + 220.0 * row as f64,
            w: 700.0,
            h: 172.0,
        };
        let last = row + 1 == QUANTITIES.len();
        let panel = Panel {
            frame,
            x: time_axis(facts, records),
            y,
        };
        panel.draw(
            &mut svg,
            quantity.title,
            last.then_some("time (s)"),
            Some(quantity.axis_title),
        );
        if row == 1 {
            panel.level(&mut svg, period_us, LIMIT);
            panel.legend(&mut svg, &[(Key::Line(LIMIT), "period")]);
        }
        if values.iter().all(|&value| value == 0) {
            let text = if row == 2 {
                "not measured in this world"
            } else {
                "0 µs in every tick"
            };
            let font = Font {
                size: 13.0,
                bold: false,
                colour: LINE,
                anchor: Anchor::Middle,
            };
            let middle = (frame.x + frame.w / 2.0, frame.y + frame.h / 2.0);
            svg.text(middle, text, font, false);
        }
        let points = over_time(records, |r| {
            let value = (quantity.of)(r);
            // A compute time of zero is one that was not measured.
            let shown = names::is_up(r.mode) && (row != 2 || value > 0);
            if shown {
                f64::from(value) * quantity.us
            } else {
                f64::NAN
            }
        });
        panel.curve(&mut svg, points, Stroke::solid(LINE, 1.0));
        draw_faults(&mut svg, &panel, records);
        draw_histogram(&mut svg, &panel, &values, quantity.us, last);
        draw_spread(&mut svg, &panel, spread, quantity.us);
    }
    svg.finish()
}

/// Whole decades around all values.
fn compute_axis(values: &[u32], us: f64) -> Axis {
    let measured = || {
        values
            .iter()
            .filter(|&&v| v > 0)
            .map(|&v| f64::from(v) * us)
    };
    let low = measured().fold(f64::INFINITY, f64::min);
    let high = measured().fold(0.0, f64::max);
    if low > high {
        return Axis {
            scale: Scale::Log,
            low: 0.1,
            high: 100.0,
        };
    }
    let decade = |x: f64| 10f64.powf(x);
    let (low, high) = (decade(low.log10().floor()), decade(high.log10().ceil()));
    Axis {
        scale: Scale::Log,
        low,
        high: if high > low { high } else { low * 10.0 },
    }
}

/// How often each value came, beside the panel and on its axis.
fn draw_histogram(svg: &mut Svg, beside: &Panel, values: &[u32], us: f64, last: bool) {
    let bins = (beside.frame.h / BIN_PX) as usize;
    let mut counts = vec![0u32; bins];
    let log = beside.y.scale == Scale::Log;
    for value in values.iter().filter(|&&value| !log || value > 0) {
        let position = beside.y.position(f64::from(*value) * us).clamp(0.0, 1.0);
        counts[((position * bins as f64) as usize).min(bins - 1)] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(0).max(10);
    let left = beside.frame.right() + 14.0;
    let panel = Panel {
        frame: Rect {
            x: left,
            w: WIDTH - 24.0 - left,
            ..beside.frame
        },
        x: Axis {
            scale: Scale::LogFromOne,
            low: 0.0,
            high: f64::from(most) * 1.3,
        },
        y: beside.y,
    };
    panel.draw(svg, "", last.then_some("ticks"), None);
    for (bin, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let (right, _) = panel.at(f64::from(count), panel.y.low);
        let y = panel.frame.bottom() - (bin + 1) as f64 * BIN_PX;
        let bar = Rect {
            x: left,
            y,
            w: right - left,
            h: BIN_PX - 0.6,
        };
        svg.rect(bar, BAR, 1.0);
    }
}

/// Mean, 99th percentile and maximum above the histogram.
fn draw_spread(svg: &mut Svg, beside: &Panel, spread: Spread, us: f64) {
    let decimals = usize::from(us < 1.0 || spread.max < 100);
    let show = |value: f64| format!("{:.decimals$}", value * us);
    let text = format!(
        "mean {}  ·  p99 {}  ·  max {}",
        show(spread.mean),
        show(f64::from(spread.p99)),
        show(f64::from(spread.max))
    );
    let font = Font {
        size: 12.0,
        bold: false,
        colour: INK,
        anchor: Anchor::End,
    };
    svg.text((WIDTH - 24.0, beside.frame.y - 9.0), &text, font, false);
}
