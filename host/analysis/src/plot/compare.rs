//! Overlay of two runs, and their difference.
//!
//! Both begin where the arm is first driven. The difference is that of ticks present in
//! both; elsewhere there is a gap.

use std::path::{Path, PathBuf};

use armbridge_log::inspect::Log;
use armbridge_log::inspect::diff::{driven, pairs};
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::Record;

use super::axis::Axis;
use super::drawing::{Drawing, Rect, Stroke};
use super::panel::{JOINT, Key, Panel};
use super::{Formats, PlotError, titled, write_as};

/// Strokes of the first run, the second, and the second minus the first.
const A: Stroke = Stroke::solid(JOINT[0], 2.2);
const B: Stroke = Stroke::solid(JOINT[1], 1.2);
const DIFFERENCE: Stroke = Stroke::solid(super::panel::INK, 1.2);
const ZERO: Stroke = Stroke::solid(super::panel::FRAME, 1.2);

/// A quantity of each joint, with axes for its values and for the difference.
struct Quantity {
    name: &'static str,
    title: &'static str,
    axis_title: &'static str,
    difference_title: &'static str,
    /// Units of the difference per unit of the quantity.
    scale: f64,
    value: fn(&Record, usize) -> f64,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        name: "compare-angles",
        title: "angle",
        axis_title: "angle (rad)",
        difference_title: "B − A (mrad)",
        scale: 1e3,
        value: |record, joint| f64::from(record.angle_rad[joint]),
    },
    Quantity {
        name: "compare-torque",
        title: "torque",
        axis_title: "torque (N m)",
        difference_title: "B − A (mN m)",
        scale: 1e3,
        value: |record, joint| f64::from(record.torque_nm[joint]),
    },
];

/// Draws an overlay of two runs into a folder; returns the files.
///
/// # Errors
/// If a file cannot be written or a drawing cannot be rendered.
pub fn compare(
    folder: &Path,
    formats: Formats,
    a: &Log,
    b: &Log,
) -> Result<Vec<PathBuf>, PlotError> {
    let pairs = pairs(a, b);
    let figures = QUANTITIES.map(|quantity| (quantity.name, draw(&quantity, a, b, &pairs)));
    write_as(folder, formats, figures)
}

fn draw(quantity: &Quantity, a: &Log, b: &Log, pairs: &[[&Record; 2]]) -> Drawing {
    let about = [("A", a), ("B", b)].map(|(which, log)| {
        format!(
            "{which}: {} · {}",
            log.head.facts.name,
            log.head.facts.describe()
        )
    });
    let title = format!("Two runs: {}", quantity.title);
    let mut drawing = titled(820.0, &title, &about.join(" — "));
    let [left, right] = [driven(a), driven(b)];
    let end_s = [left, right].map(|ticks| ticks.last().map_or(0.0, |last| since_s(ticks, last)));
    let x = Axis::linear(0.0, end_s[0].max(end_s[1]).max(1e-3));
    for joint in 0..JOINTS {
        let y = 78.0 + 364.0 * joint as f64;
        let frame = Rect::row(y, 180.0);
        let value = |record: &Record| (quantity.value)(record, joint);
        let both = left.iter().chain(right).map(value);
        let panel = Panel {
            frame,
            x,
            y: Axis::around(both, 0.06),
        };
        let title = format!("Joint {}: {}", joint + 1, quantity.title);
        panel.draw(&mut drawing, &title, None, Some(quantity.axis_title));
        for (ticks, stroke) in [(left, A), (right, B)] {
            panel.curve(&mut drawing, over_time(ticks, value), stroke);
        }
        panel.legend(&mut drawing, &[(Key::Line(A), "A"), (Key::Line(B), "B")]);

        let difference = |[a, b]: &[&Record; 2]| quantity.scale * (value(b) - value(a));
        let panel = Panel {
            frame: Rect {
                y: y + 214.0,
                h: 102.0,
                ..frame
            },
            x,
            y: Axis::around(pairs.iter().map(difference).chain([0.0]), 0.1),
        };
        let last = joint + 1 == JOINTS;
        let x_title = last.then_some("time since the arm was first driven (s)");
        let title = difference_text(pairs.iter().map(difference));
        panel.draw(
            &mut drawing,
            &title,
            x_title,
            Some(quantity.difference_title),
        );
        panel.level(&mut drawing, 0.0, ZERO);
        let mut before: Option<u32> = None;
        let points = pairs.iter().flat_map(|pair| {
            let time_s = since_s(left, pair[0]);
            let gap = before.is_some_and(|tick| pair[0].tick != tick.wrapping_add(1));
            before = Some(pair[0].tick);
            let gap = gap.then_some((time_s, f64::NAN));
            gap.into_iter().chain([(time_s, difference(pair))])
        });
        panel.curve(&mut drawing, points, DIFFERENCE);
    }
    drawing
}

/// Text with the largest and RMS difference.
fn difference_text(differences: impl Iterator<Item = f64>) -> String {
    let (mut largest, mut squares, mut count) = (0.0_f64, 0.0, 0_u32);
    for difference in differences.filter(|difference| difference.is_finite()) {
        largest = largest.max(difference.abs());
        squares += difference * difference;
        count += 1;
    }
    match count {
        0 => "difference: no tick is in both".to_owned(),
        _ if largest == 0.0 => "difference: none".to_owned(),
        _ => {
            let rms = (squares / f64::from(count)).sqrt();
            format!("difference: at most {largest:.3}, rms {rms:.3}")
        }
    }
}

fn since_s(ticks: &[Record], record: &Record) -> f64 {
    record.start_us.saturating_sub(ticks[0].start_us) as f64 * 1e-6
}

/// A quantity over time in s, with NaN between ticks that are not consecutive.
fn over_time(ticks: &[Record], value: impl Fn(&Record) -> f64) -> impl Iterator<Item = (f64, f64)> {
    ticks.iter().enumerate().flat_map(move |(at, record)| {
        let time_s = since_s(ticks, record);
        let gap = at > 0 && record.tick != ticks[at - 1].tick.wrapping_add(1);
        let gap = gap.then_some((time_s, f64::NAN));
        gap.into_iter().chain([(time_s, value(record))])
    })
}
