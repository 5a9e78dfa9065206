//! `timing`: start error, bus time and compute time of every tick.
//!
//! Each quantity is drawn over time, with a histogram on the same axis beside it. Counts
//! are on a logarithmic axis, so that one tick in ten thousand is visible.

use armbridge_client::enum_names;
use armbridge_log::summary::Spread;
use armbridge_shared::link::message::Record;

use super::axis::{Axis, Scale};
use super::drawing::{Anchor, Drawing, Font, Rect};
use super::panel::{INK, Key, LIMIT, Panel};
use super::run::Run;
use super::{WIDTH, figure};

/// Colours of curves that belong to no joint.
const DOT: &str = "#4b6478";
const BAR: &str = "#8aa3b5";

/// Height of a bar of a histogram in px.
const BIN_PX: f64 = 4.0;

/// A quantity of the figure.
struct Quantity {
    title: &'static str,
    axis_title: &'static str,
    /// Value in the record's own unit; none if it is missing.
    of: fn(&Record) -> Option<u32>,
    /// µs of that unit.
    us: f64,
    /// Axis for the lowest and highest value and the period in µs.
    axis: fn(f64, f64, f64) -> Axis,
    /// Whether the period is a limit of the quantity.
    within_period: bool,
}

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        title: "Tick start, actual minus planned",
        axis_title: "late by (µs)",
        of: |r| enum_names::is_up(r.mode).then_some(r.timing.start_error_us),
        us: 1.0,
        // Zero is common, and outliers matter.
        axis: |_, highest, _| Axis {
            scale: Scale::LogFromOne,
            low: 0.0,
            high: (highest * 1.4).max(10.0),
        },
        within_period: false,
    },
    Quantity {
        title: "Bus, first bit of the request to last of the replies",
        axis_title: "bus time (µs)",
        of: |r| enum_names::is_up(r.mode).then_some(r.timing.bus_us),
        us: 1.0,
        // The fraction of the period matters.
        axis: |_, highest, period_us| Axis::linear(0.0, highest.max(period_us) * 1.06),
        within_period: true,
    },
    Quantity {
        title: "Estimator, controller and supervisor",
        axis_title: "compute time (µs)",
        // Zero: not measured.
        of: |r| Some(r.timing.compute_ns).filter(|&ns| ns > 0 && enum_names::is_up(r.mode)),
        us: 1e-3,
        axis: |lowest, highest, _| whole_decades(lowest, highest),
        within_period: false,
    },
];

pub(super) fn draw(run: &Run) -> Drawing {
    let mut drawing = figure(760.0, "Tick timing", run.facts);
    for (row, quantity) in QUANTITIES.iter().enumerate() {
        let y = 78.0 + 220.0 * row as f64;
        let frame = Rect {
            x: 84.0,
            y,
            w: 690.0,
            h: 172.0,
        };
        let last = row + 1 == QUANTITIES.len();
        draw_quantity(&mut drawing, frame, quantity, last, run);
    }
    drawing
}

fn draw_quantity(drawing: &mut Drawing, frame: Rect, quantity: &Quantity, last: bool, run: &Run) {
    let period_us = f64::from(run.facts.period_us);
    let values: Vec<u32> = run.shown().iter().filter_map(quantity.of).collect();
    let in_us = |value: u32| f64::from(value) * quantity.us;
    let lowest = values.iter().min().map_or(f64::NAN, |&value| in_us(value));
    let highest = values.iter().max().map_or(f64::NAN, |&value| in_us(value));
    let y = (quantity.axis)(lowest, highest, period_us);
    let panel = Panel {
        frame,
        x: run.time_axis(),
        y,
    };
    panel.draw(
        drawing,
        quantity.title,
        last.then_some("time (s)"),
        Some(quantity.axis_title),
    );
    run.draw_gaps(drawing, &panel);
    if quantity.within_period {
        panel.level(drawing, period_us, LIMIT);
        panel.legend(drawing, &[(Key::Line(LIMIT), "period")]);
    }
    let points = run.over_time(|r| (quantity.of)(r).map_or(f64::NAN, in_us));
    panel.dots(drawing, points.filter(|(_, value)| value.is_finite()), DOT);
    run.draw_faults(drawing, &panel);
    draw_histogram(
        drawing,
        &panel,
        values.iter().copied().map(in_us),
        run.shown().len(),
        last,
    );

    let remark = match (values.is_empty(), highest == 0.0) {
        (true, _) => "not measured",
        (false, true) => "0 µs in every tick",
        (false, false) => "",
    };
    let font = Font {
        size: 13.0,
        bold: false,
        colour: DOT,
        anchor: Anchor::Middle,
    };
    drawing.text(
        (frame.x + frame.w / 2.0, frame.y + frame.h / 2.0),
        remark,
        font,
        false,
    );
    if !values.is_empty() {
        draw_spread(drawing, &panel, Spread::from_values(values), quantity.us);
    }
}

/// Whole decades around all values, at least one.
fn whole_decades(lowest: f64, highest: f64) -> Axis {
    if !(lowest > 0.0 && highest.is_finite()) {
        return Axis {
            scale: Scale::Log,
            low: 0.1,
            high: 100.0,
        };
    }
    let low = 10f64.powf(lowest.log10().floor());
    let high = 10f64.powf(highest.log10().ceil()).max(low * 10.0);
    Axis {
        scale: Scale::Log,
        low,
        high,
    }
}

/// Draws a histogram beside the panel, on its axis; `ticks` is the largest possible count.
fn draw_histogram(
    drawing: &mut Drawing,
    beside: &Panel,
    values: impl Iterator<Item = f64>,
    ticks: usize,
    last: bool,
) {
    let bins = (beside.frame.h / BIN_PX) as usize;
    let mut counts = vec![0u32; bins];
    for value in values {
        let position = beside.y.position(value).clamp(0.0, 1.0);
        counts[((position * bins as f64) as usize).min(bins - 1)] += 1;
    }
    let left = beside.frame.right() + 30.0;
    let high = (ticks as f64 * 1.3).max(10.0);
    let panel = Panel {
        frame: Rect {
            x: left,
            w: WIDTH - 24.0 - left,
            ..beside.frame
        },
        x: Axis {
            scale: Scale::LogFromOne,
            low: 0.0,
            high,
        },
        y: beside.y,
    };
    panel.draw(drawing, "", last.then_some("ticks"), None);
    for (bin, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let (right, _) = panel.at(f64::from(count), panel.y.low);
        let y = panel.frame.bottom() - (bin + 1) as f64 * BIN_PX;
        let bar = Rect {
            x: left,
            y,
            w: right - left,
            h: BIN_PX - 0.6,
        };
        drawing.rect(bar, BAR, 1.0);
    }
}

/// Writes mean, 99th percentile and maximum above the histogram.
fn draw_spread(drawing: &mut Drawing, beside: &Panel, spread: Spread, us: f64) {
    let decimals = usize::from(us < 1.0 || spread.max < 100);
    let show = |value: f64| format!("{:.decimals$}", value * us);
    let text = format!(
        "mean {} · p99 {} · max {} µs",
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
    drawing.text((WIDTH - 24.0, beside.frame.y - 9.0), &text, font, false);
}
