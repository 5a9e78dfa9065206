//! Figures of a sweep: each over the first key, one curve for each combination of the
//! others. Solid: median over the seeds; dashed: worst.
//!
//! Values that are no numbers are numbered from 1, and named in the legend; without another
//! key than the seed, the figures are over the seed. No line leads from one of these to the
//! next: there is nothing between them, and the worst is a small dot.

use super::table::{FIGURES, Figure};
use super::{Row, Sweep};
use crate::plot::axis::{Axis, Scale};
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
        count if FirstKey::of(sweep).is_category => {
            format!("{count} seeds: median, and worst as a small dot")
        }
        count => format!("{count} seeds: median, and worst dashed"),
    };
    let about = format!("simulated: bench · {seeds}");
    let title = format!("Sweep · armbridge {}", sweep.scenario);
    let rows = sweep.rows();
    let first = FirstKey::of(sweep);
    let names: Vec<String> = curves(sweep, &rows, &first.numbers, &FIGURES[0])
        .into_iter()
        .map(|curve| curve.name)
        .filter(|name| !name.is_empty())
        .collect();
    let legend_rows = first.names.len().min(NAMED) + names.len().min(NAMED);
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
    draw_legend(&mut drawing, &first.names, &names);
    for (number, figure) in shown.into_iter().enumerate() {
        let curves = curves(sweep, &rows, &first.numbers, figure);
        let (column, row) = ((number % 2) as f64, (number / 2) as f64);
        let frame = Rect {
            x: 84.0 + 500.0 * column,
            y: top + 292.0 * row,
            w: 432.0,
            h: 224.0,
        };
        draw_panel(&mut drawing, frame, figure, &curves, &first);
    }
    drawing
}

/// The first key, over which the figures are.
struct FirstKey {
    title: String,
    /// Its value in each combination, or the place of that value.
    numbers: Vec<f64>,
    /// Its values, if they are no numbers.
    names: Vec<String>,
    /// There is nothing between two of its values.
    is_category: bool,
}

impl FirstKey {
    fn of(sweep: &Sweep) -> Self {
        let Some(key) = sweep.keys.first() else {
            return Self {
                title: "seed".into(),
                numbers: Vec::new(),
                names: Vec::new(),
                is_category: true,
            };
        };
        let numbers = sweep.combinations.iter().map(|values| values.number(0));
        if let Some(numbers) = numbers.collect::<Option<Vec<f64>>>() {
            return Self {
                title: key.clone(),
                numbers,
                names: Vec::new(),
                is_category: false,
            };
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
        Self {
            title: format!("{key} (numbered)"),
            numbers,
            names: named
                .map(|(number, value)| format!("{}: {key} = {value}", number + 1))
                .collect(),
            is_category: true,
        }
    }

    /// Its axis.
    fn axis(&self, values: impl Iterator<Item = f64>) -> Axis {
        if !self.is_category {
            return Axis::around(values, 0.06);
        }
        let Axis { low, high, .. } = Axis::around(values, 0.0);
        Axis {
            scale: Scale::Whole,
            low: low - 0.5,
            high: high + 0.5,
        }
    }
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

/// Values of the first key, then the curves.
fn draw_legend(drawing: &mut Drawing, values: &[String], names: &[String]) {
    let font = Font {
        anchor: Anchor::Start,
        ..LABEL
    };
    let height = |row: usize| 58.0 + 18.0 * row as f64;
    for (number, value) in values.iter().enumerate().take(NAMED) {
        let text = format!("{value}{}", more(number, values.len()));
        drawing.text((84.0, height(number) + 4.0), &text, font, false);
    }
    let above = values.len().min(NAMED);
    for (number, name) in names.iter().enumerate().take(NAMED) {
        let y = height(above + number);
        let text = format!("{name}{}", more(number, names.len()));
        let stroke = Stroke::solid(COLOURS[number % COLOURS.len()], 2.0);
        drawing.line((84.0, y), (106.0, y), stroke);
        drawing.text((114.0, y + 4.0), &text, font, false);
    }
}

/// Suffix of a legend's last row: the number of runs that have none.
fn more(number: usize, count: usize) -> String {
    match count - number - 1 {
        more if number + 1 == NAMED && more > 0 => format!(", and {more} more"),
        _ => String::new(),
    }
}

fn draw_panel(
    drawing: &mut Drawing,
    frame: Rect,
    figure: &Figure,
    curves: &[Curve],
    first: &FirstKey,
) {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let values = || points().flat_map(|(_, values)| values.iter().flatten().copied());
    let is_finite = |value: &f64| value.is_finite();
    let panel = Panel {
        frame,
        x: first.axis(points().map(|(x, _)| *x)),
        y: Axis::around(values().filter(is_finite).chain([0.0]), 0.08),
    };
    let never = values().filter(|value| value.is_infinite()).count();
    let title = match never {
        0 => figure.title.to_owned(),
        _ => format!("{} (a gap: never)", figure.title),
    };
    let unit = format!("{} ({})", figure.title, figure.unit);
    panel.draw(drawing, &title, Some(&first.title), Some(&unit));
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
            if !first.is_category {
                panel.trace(drawing, points.iter().copied(), stroke);
            }
            if kind == 0 || first.is_category {
                let finite = points.iter().filter(|(_, value)| value.is_finite());
                let centres = finite.map(|(x, value)| panel.at(*x, *value)).collect();
                drawing.dots(centres, if kind == 0 { 6.0 } else { 3.0 }, colour);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::{Assignment, Combination, RunFigures, SweepRun};

    /// A sweep of `controller.q` over these values.
    fn drawn(values: &[&str]) -> String {
        let key = "controller.q".to_owned();
        let combination = |value: &&str| {
            let (key, value) = (key.clone(), (*value).to_owned());
            Combination(vec![Assignment { key, value }])
        };
        let run = |combination| SweepRun {
            combination,
            seed: 1,
            figures: RunFigures {
                settling_time_s: Some(0.5),
                peak_torque_nm: 0.7,
                ..RunFigures::default()
            },
        };
        let sweep = Sweep {
            scenario: "upright".into(),
            keys: vec![key.clone()],
            combinations: values.iter().map(combination).collect(),
            seeds: vec![1],
            runs: (0..values.len()).map(run).collect(),
        };
        draw(&sweep).svg()
    }

    #[test]
    fn values_that_are_no_numbers_are_named_in_full_and_not_joined() {
        let lists = ["[30.0, 30.0, 1.0, 1.0]", "[60.0, 60.0, 1.0, 1.0]"];
        let lists = drawn(&lists);
        for words in ["1: controller.q = [30.0, 30.0, 1.0, 1.0]", ">1<", ">2<"] {
            assert!(lists.contains(words), "no {words:?} in {lists}");
        }
        assert!(!lists.contains("1.5") && !lists.contains('…'), "{lists}");
        // The same two values of a number have a line between them.
        let lines = |svg: &str| svg.matches(JOINT[0]).count();
        assert!(lines(&drawn(&["30", "60"])) > lines(&lists));
    }
}
