//! `timing`: start error, bus time and compute time of every tick.
//!
//! Each quantity is drawn over time, with a histogram on the same axis beside it. Counts
//! are on a logarithmic axis, so that one tick in ten thousand is visible.

use armbridge_client::enum_names;
use armbridge_link::message::Record;
use armbridge_log::summary::{Counts, Spread};

use super::axis::{Axis, Scale};
use super::drawing::{Anchor, Drawing, Font, Rect};
use super::marks::NOTE;
use super::panel::{INK, Key, LIMIT, Panel};
use super::run::Run;
use super::{WIDTH, figure, marks};

/// Colours of curves that belong to no joint.
const DOT: &str = "#4b6478";
const BAR: &str = "#8aa3b5";

/// Height of a bar of a histogram in px.
const BIN_PX: f64 = 4.0;

/// A quantity of the figure.
pub(super) struct Quantity {
    title: &'static str,
    axis_title: &'static str,
    /// Value in the record's own unit; none if it is missing.
    pub(super) of: fn(&Record) -> Option<u32>,
    /// µs of that unit.
    us: f64,
    /// Axis for the lowest and highest value and the period in µs.
    axis: fn(f64, f64, f64) -> Axis,
    /// Whether the period is a limit of the quantity.
    within_period: bool,
}

pub(super) const QUANTITIES: [Quantity; 3] = [
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
    let quantities = QUANTITIES.iter().zip(&run.timing);
    // A simulated board takes no time to compute: a panel without data says less than a note.
    let mut measured: Vec<_> = quantities
        .filter(|(_, counts)| !counts.is_empty())
        .collect();
    if measured.is_empty() {
        measured.extend(QUANTITIES.iter().zip(&run.timing).take(1));
    }
    let rows = measured.len();
    let mut drawing = figure(100.0 + 220.0 * rows as f64, "Tick timing", &run.facts);
    for (row, (quantity, counts)) in measured.into_iter().enumerate() {
        let frame = Rect {
            x: 84.0,
            y: 78.0 + 220.0 * row as f64,
            w: 690.0,
            h: 172.0,
        };
        draw_quantity(&mut drawing, frame, quantity, counts, row + 1 == rows, run);
    }
    if run.timing.last().is_some_and(Counts::is_empty) {
        let bottom = drawing.height - 12.0;
        drawing.text(
            (84.0, bottom),
            "Compute time: not measured in this run.",
            NOTE,
            false,
        );
    }
    drawing
}

fn draw_quantity(
    drawing: &mut Drawing,
    frame: Rect,
    quantity: &Quantity,
    counts: &Counts,
    last: bool,
    run: &Run,
) {
    let period_us = f64::from(run.facts.period_us);
    let in_us = |value: u32| f64::from(value) * quantity.us;
    let lowest = counts
        .iter()
        .next()
        .map_or(f64::NAN, |(value, _)| in_us(value));
    let highest = counts.iter().next_back();
    let highest = highest.map_or(f64::NAN, |(value, _)| in_us(value));
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
    marks::draw_gaps(drawing, &panel, run);
    if quantity.within_period {
        panel.level(drawing, period_us, LIMIT);
        panel.legend(drawing, &[(Key::Line(LIMIT), "period")]);
    }
    let points = run.over_time(|r| (quantity.of)(r).map_or(f64::NAN, in_us));
    panel.dots(drawing, points.filter(|(_, value)| value.is_finite()), DOT);
    marks::draw_faults(drawing, &panel, run);
    let values = counts.iter().map(|(value, count)| (in_us(value), count));
    draw_histogram(drawing, &panel, values, run.shown, last);

    let remark = match (counts.is_empty(), highest == 0.0) {
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
    if !counts.is_empty() {
        draw_spread(drawing, &panel, counts.spread(), quantity.us);
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

/// Draws a histogram of values with their counts beside the panel, on its axis; `ticks` is the largest possible count.
fn draw_histogram(
    drawing: &mut Drawing,
    beside: &Panel,
    values: impl Iterator<Item = (f64, u64)>,
    ticks: u64,
    last: bool,
) {
    let bins = (beside.frame.h / BIN_PX) as usize;
    let mut counts = vec![0_u64; bins];
    for (value, count) in values {
        let position = beside.y.position(value).clamp(0.0, 1.0);
        counts[((position * bins as f64) as usize).min(bins - 1)] += count;
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
        let (right, _) = panel.at(count as f64, panel.y.low);
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
