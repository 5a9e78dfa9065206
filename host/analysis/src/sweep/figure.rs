//! Figures of a sweep: each over the first key, one curve for each combination of the
//! others. Solid: median over the seeds; dashed: worst.
//!
//! Values that are no numbers are numbered from 1. Without another key than the seed, the
//! figures are over the seed.

use super::table::{FIGURES, Figure};
use super::{Row, Sweep};
use crate::plot::axis::Axis;
use crate::plot::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use crate::plot::panel::{ALARM, FOURTH, GOOD, INK, JOINT, LABEL, Panel};
use crate::plot::titled;

/// Colours of the curves, which repeat.
const COLOURS: [&str; 6] = [JOINT[0], JOINT[1], GOOD, FOURTH, ALARM, INK];
/// Curves that the legend names.
const NAMED: usize = 8;

/// A curve: its name, and points of first key, median and worst.
struct Curve {
    name: String,
    points: Vec<(f64, [Option<f64>; 2])>,
}

pub(super) fn draw(sweep: &Sweep) -> Drawing {
    let seeds = match sweep.seeds.len() {
        1 => format!("seed {}", sweep.seeds[0]),
        count if sweep.keys.is_empty() => format!("{count} seeds"),
        count => format!("{count} seeds: median, and worst dashed"),
    };
    let about = format!("simulated: bench · {seeds}");
    let title = format!("Sweep · armbridge {}", sweep.scenario);
    let rows = sweep.rows();
    let (x_title, numbers) = first_key(sweep);
    let names: Vec<String> = curves(sweep, &rows, &numbers, &FIGURES[0])
        .into_iter()
        .map(|curve| curve.name)
        .collect();
    let legend_rows = names
        .iter()
        .filter(|name| !name.is_empty())
        .count()
        .min(NAMED);
    let top = 84.0 + 18.0 * legend_rows as f64;
    // Figures that the scenario has.
    let has = |figure: &&Figure| {
        sweep
            .runs
            .iter()
            .any(|run| figure.of_run(&run.figures).is_some())
    };
    let shown: Vec<&Figure> = FIGURES.iter().filter(has).collect();
    let lines = shown.len().div_ceil(2) as f64;
    let mut drawing = titled(top + 292.0 * lines, &title, &about);
    draw_legend(&mut drawing, &names);
    for (number, figure) in shown.into_iter().enumerate() {
        let curves = curves(sweep, &rows, &numbers, figure);
        let (column, row) = ((number % 2) as f64, (number / 2) as f64);
        let frame = Rect {
            x: 84.0 + 500.0 * column,
            y: top + 292.0 * row,
            w: 432.0,
            h: 224.0,
        };
        draw_panel(&mut drawing, frame, figure, &curves, &x_title);
    }
    drawing
}

/// Title of the first key, and its value in each combination.
fn first_key(sweep: &Sweep) -> (String, Vec<f64>) {
    let Some(key) = sweep.keys.first() else {
        return ("seed".into(), Vec::new());
    };
    let numbers = sweep.combinations.iter().map(|values| values.number(0));
    if let Some(numbers) = numbers.collect::<Option<Vec<f64>>>() {
        return (key.clone(), numbers);
    }
    let mut values: Vec<&str> = Vec::new();
    let numbers = sweep.combinations.iter().map(|combination| {
        let value = combination.0.first().map_or("", |pair| pair.value.as_str());
        let place = values.iter().position(|known| *known == value);
        let place = place.unwrap_or_else(|| {
            values.push(value);
            values.len() - 1
        });
        place as f64 + 1.0
    });
    let numbers = numbers.collect();
    let named = values.iter().enumerate();
    let named = named.map(|(number, value)| format!("{}: {value}", number + 1));
    (
        format!("{key} ({})", named.collect::<Vec<_>>().join(", ")),
        numbers,
    )
}

fn curves(sweep: &Sweep, rows: &[Row], numbers: &[f64], figure: &Figure) -> Vec<Curve> {
    if sweep.keys.is_empty() {
        let points = sweep.runs.iter().map(|run| {
            let value = figure.of_run(&run.figures);
            (run.seed as f64, [value, None])
        });
        return vec![Curve {
            name: String::new(),
            points: points.collect(),
        }];
    }
    let mut curves: Vec<Curve> = Vec::new();
    for (row, number) in rows.iter().zip(numbers) {
        let others = row.values.0.iter().skip(1);
        let others = others.map(|pair| format!("{} = {}", pair.key, pair.value));
        let name = others.collect::<Vec<_>>().join(", ");
        let spread = figure.of_row(row);
        let worst = spread.map(|spread| spread.worst);
        let worst = worst.filter(|_| sweep.seeds.len() > 1);
        let point = (*number, [spread.map(|spread| spread.median), worst]);
        match curves.iter_mut().find(|curve| curve.name == name) {
            Some(curve) => curve.points.push(point),
            None => curves.push(Curve {
                name,
                points: vec![point],
            }),
        }
    }
    for curve in &mut curves {
        curve.points.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    }
    curves
}

fn draw_legend(drawing: &mut Drawing, names: &[String]) {
    let font = Font {
        anchor: Anchor::Start,
        ..LABEL
    };
    let names: Vec<&String> = names.iter().filter(|name| !name.is_empty()).collect();
    for (number, name) in names.iter().enumerate().take(NAMED) {
        let y = 58.0 + 18.0 * number as f64;
        let more = match names.len() - number - 1 {
            more if number + 1 == NAMED && more > 0 => format!(", and {more} more"),
            _ => String::new(),
        };
        let stroke = Stroke::solid(COLOURS[number % COLOURS.len()], 2.0);
        drawing.line((84.0, y), (106.0, y), stroke);
        drawing.text((114.0, y + 4.0), &format!("{name}{more}"), font, false);
    }
}

fn draw_panel(drawing: &mut Drawing, frame: Rect, figure: &Figure, curves: &[Curve], x: &str) {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let values = || points().flat_map(|(_, values)| values.iter().flatten().copied());
    let is_finite = |value: &f64| value.is_finite();
    let panel = Panel {
        frame,
        x: Axis::around(points().map(|(x, _)| *x), 0.06),
        y: Axis::around(values().filter(is_finite).chain([0.0]), 0.08),
    };
    let never = values().filter(|value| value.is_infinite()).count();
    let title = match never {
        0 => figure.title.to_owned(),
        _ => format!("{} (a gap: never)", figure.title),
    };
    let longest = (frame.w / LABEL.width("x")) as usize;
    let x: String = if x.chars().count() > longest {
        x.chars().take(longest - 1).chain(['…']).collect()
    } else {
        x.into()
    };
    let unit = format!("{} ({})", figure.title, figure.unit);
    panel.draw(drawing, &title, Some(&x), Some(&unit));
    for (number, curve) in curves.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        for (kind, stroke) in [
            Stroke::solid(colour, 2.0),
            Stroke {
                colour,
                width: 1.3,
                dash: &[5.0, 4.0],
            },
        ]
        .into_iter()
        .enumerate()
        {
            let points = curve.points.iter().map(|(x, values)| {
                let value = values[kind].filter(is_finite);
                (*x, value.unwrap_or(f64::NAN))
            });
            let points: Vec<(f64, f64)> = points.collect();
            panel.trace(drawing, points.iter().copied(), stroke);
            if kind == 0 {
                let finite = points.iter().filter(|(_, value)| value.is_finite());
                let centres = finite.map(|(x, value)| panel.at(*x, *value)).collect();
                drawing.dots(centres, 6.0, colour);
            }
        }
    }
}
