//! Link, bus and timing: three boxes of numbers.

use armbridge_client::enum_names;
use armbridge_link::message::Timing;
use armbridge_servo::{Alarms, Firmware};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph};

use super::theme;
use crate::watch::model::{Histogram, Line as LinkLine, Model};

/// Draws `lines` in a box.
fn boxed(frame: &mut Frame<'_>, area: Rect, title: &str, lines: Vec<Line<'_>>) {
    let title = Line::from(format!(" {title} ")).style(theme::strong());
    let block = Block::bordered().title(title);
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

/// A count that should be 0.
fn count(name: &str, count: u64) -> Span<'static> {
    let style = if count == 0 {
        Style::new()
    } else {
        theme::warn()
    };
    Span::from(format!("{name} {count:<6}")).style(style)
}

/// State of the link.
pub(super) fn link(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let link = &model.link;
    let state = match model.line() {
        LinkLine::Opening => Span::from("nothing heard yet").style(theme::warn()),
        LinkLine::Up => Span::from("up").style(theme::good()),
        LinkLine::Quiet(_) => Span::from("quiet").style(theme::warn()),
        LinkLine::Parted(_) => Span::from("LOST").style(theme::bad()),
    };
    let rate = link.frames_per_s(model.now_ns());
    let round_trip = link.round_trip_ns.map_or_else(
        || "round trip not known".to_owned(),
        |ns| format!("round trip {:.1} ms", ns as f64 * 1e-6),
    );
    let lines = vec![
        Line::from(vec![state, Span::from(format!("  {rate:.0} frames/s"))]),
        Line::from(vec![
            count("lost   ", link.lost),
            count("damaged", link.damaged),
        ]),
        Line::from(vec![
            count("dropped", link.dropped),
            count("foreign", link.foreign),
        ]),
        Line::from(vec![
            count("breaks ", link.breaks),
            count("unseen ", model.unseen),
        ]),
        Line::from(round_trip),
    ];
    boxed(frame, area, "link", lines);
}

/// State of the bus.
pub(super) fn bus(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let bus = &model.bus;
    let period_us = model
        .board
        .settings
        .map(|settings| settings.setup.period_us);
    let missed = bus.missed_ticks;
    let time = model.board.record.map_or_else(String::new, |record| {
        let period = period_us.map_or_else(String::new, |period_us| format!(" of {period_us}"));
        format!("{}{period} µs, missed {missed}", record.timing.bus_us)
    });
    let style = match missed {
        0 => Style::new(),
        _ => theme::warn(),
    };
    let missing = bus.missing();
    let all: u64 = missing.iter().map(|(_, count)| *count).sum();
    let kinds: Vec<_> = missing
        .iter()
        .map(|(kind, count)| format!("{} {count}", enum_names::missing(*kind).replace('_', " ")))
        .collect();
    let lines = vec![
        Line::from(servos(model)),
        Line::from(time).style(style),
        Line::from(count("samples missing", all)),
        Line::from(format!("  {}", kinds.join(", "))).style(theme::warn()),
        heat(model),
    ];
    boxed(frame, area, "bus", lines);
}

/// The servos.
fn servos(model: &Model) -> String {
    model.board.servos.map_or_else(
        || "servos not found yet".to_owned(),
        |servos| format!("{}, {} baud", servos.firmware, servos.baud),
    )
}

/// Temperatures and alarms.
fn heat(model: &Model) -> Line<'static> {
    let alarms = model.bus.alarms.map(Alarms::from_bits);
    if let Some(joint) = alarms.iter().position(|alarms| !alarms.is_empty()) {
        let names = enum_names::alarms(model.bus.alarms[joint]);
        return Line::from(format!("servo {}: {names}", joint + 1)).style(theme::bad());
    }
    let [first, second] = model
        .board
        .temperature
        .map(|value| value.map_or_else(|| "–".to_owned(), |value| value.to_string()));
    let unit = match model.board.servos.map(|servos| servos.firmware) {
        Some(Firmware::Stock | Firmware::XSeries) => "°C",
        Some(Firmware::Morpheus) => "counts",
        None => "",
    };
    Line::from(format!("temp. {first}, {second} {unit}"))
}

/// Columns beside the bars: name, mean, most.
const BESIDE: u16 = 17;

/// Timings of ticks, as histograms from minimum to maximum.
pub(super) fn timing(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let inside = Block::bordered().inner(area);
    let bins = usize::from(inside.width.saturating_sub(BESIDE)).max(4);
    let rows = usize::from(inside.height.saturating_sub(2) / 3).max(1);
    let late = |timing: &Timing| f64::from(timing.start_error_us);
    let bus = |timing: &Timing| f64::from(timing.bus_us);
    let compute = |timing: &Timing| f64::from(timing.compute_ns) * 1e-3;
    let spread = |take: &dyn Fn(&Timing) -> f64| Histogram::of(model.bus.timings().map(take), bins);
    let heading = format!("{:7}{:>4} {:bins$} {:>4}", "", "mean", "", "most");
    let mut lines = vec![Line::from(heading).style(theme::faint())];
    for (name, spread) in [("late", spread(&late)), ("bus", spread(&bus))] {
        lines.extend(bars(name, spread.as_ref(), rows));
    }
    // Where it is not measured, it is 0 in every tick.
    let computed = spread(&compute).filter(|spread| spread.most > 0.0);
    lines.extend(bars("compute", computed.as_ref(), rows));
    let legend = "last 10 000 ticks, log";
    lines.push(Line::from(legend).style(theme::faint()));
    boxed(frame, area, "tick timing, µs", lines);
}

/// A histogram of so many rows, its numbers in the lowest; the height is that of a
/// count's logarithm, so that one late tick in ten thousand shows.
fn bars(name: &str, spread: Option<&Histogram>, rows: usize) -> Vec<Line<'static>> {
    const PARTS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let flat = |text: String| {
        let mut lines = vec![Line::default(); rows - 1];
        lines.push(Line::from(text));
        lines
    };
    let Some(spread) = spread else {
        return flat(format!("{name:7}   – not measured"));
    };
    let (mean, most) = (spread.mean, spread.most);
    if most <= spread.least {
        return flat(format!("{name:7}{mean:>4.0} always"));
    }
    let height = |count: u32| f64::from(count + 1).ln();
    let highest = spread.bins.iter().copied().map(height).fold(1e-9, f64::max);
    let eighths = |count: u32| match count {
        0 => 0,
        _ => ((height(count) / highest * 8.0 * rows as f64).round() as usize).max(1),
    };
    let bar = |row: usize| -> String {
        let below = 8 * (rows - 1 - row);
        let part = |count: &u32| PARTS[eighths(*count).saturating_sub(below).min(8)];
        spread.bins.iter().map(part).collect()
    };
    let numbered = |row: usize| {
        let (name, mean, most) = if row + 1 == rows {
            (name, format!("{mean:.0}"), format!("{most:.0}"))
        } else {
            ("", String::new(), String::new())
        };
        Line::from(vec![
            Span::from(format!("{name:7}{mean:>4} ")),
            Span::from(bar(row)).style(theme::good()),
            Span::from(format!(" {most:>4}")),
        ])
    };
    (0..rows).map(numbered).collect()
}
