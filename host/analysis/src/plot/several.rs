//! Figures of several runs: their curves over each other, a colour for each run.
//!
//! Runs share their time axis: time zero is where they are aligned. `difference` is each run
//! minus the first at the same times, see [`difference`](super::difference).

use armbridge_link::message::Record;
use armbridge_log::record_values::{angle_rad, error_rad, reference_rad};
use armbridge_log::recording::ReadError;
use armbridge_log::summary::SETTLED_RAD;
use armbridge_servo::JOINTS;

use super::axis::Axis;
use super::difference::Difference;
use super::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use super::labels::labels;
use super::panel::{ALARM, FOURTH, GOOD, INK, JOINT, LABEL, LIMIT, Panel, SETPOINT};
use super::run::Run;
use super::spectrum::SIGNALS;
use super::tracking::ZERO;
use super::{Figure, WIDTH, marks, path, phase, spectrum, titled};

/// Colour of each run; a ninth has that of the first.
const RUNS: [&str; 8] = [
    JOINT[0], JOINT[1], GOOD, FOURTH, "#0b8a8f", "#a67c00", "#c2418f", ALARM,
];

/// Height of a run's line in the legend in px.
const LINE_PX: f64 = 17.0;

/// Height of a panel in px.
const PANEL_PX: f64 = 224.0;

/// Draws a figure of several runs; none if it is of one run only.
pub(super) fn draw(figure: Figure, runs: &[Run]) -> Result<Option<Drawing>, ReadError> {
    Ok(match figure {
        Figure::Angles => Some(angles(runs)),
        Figure::Tracking => Some(tracking(runs)),
        Figure::Torque => Some(torque(runs)),
        Figure::Path => Some(paths(runs)),
        Figure::Phase => Some(phases(runs)),
        Figure::Spectrum => Some(spectra(runs)),
        Figure::Difference => Some(difference(runs)?),
        Figure::Timing => None,
    })
}

fn stroke(place: usize) -> Stroke {
    Stroke::solid(RUNS[place % RUNS.len()], 1.5)
}

/// A figure with the names of the runs; returns the top of its first panel as well.
fn begin(title: &str, runs: &[Run], panels_px: f64, notes: &[String]) -> (Drawing, f64) {
    let (common, names) = labels(runs);
    let top = 88.0 + LINE_PX * names.len() as f64;
    let title = format!("{title} · {} runs", runs.len());
    let mut drawing = titled(top + panels_px, &title, &common);
    let font = Font {
        size: 12.5,
        colour: INK,
        anchor: Anchor::Start,
        ..LABEL
    };
    for (place, name) in names.iter().enumerate() {
        let y = 58.0 + LINE_PX * place as f64;
        drawing.line((26.0, y - 4.0), (52.0, y - 4.0), stroke(place));
        let note = notes.get(place).map_or("", String::as_str);
        let right = WIDTH - 24.0 - font.width(note);
        drawing.text(
            (60.0, y),
            &shortened(name, &font, right - 80.0),
            font,
            false,
        );
        let anchor = Anchor::End;
        drawing.text((WIDTH - 24.0, y), note, Font { anchor, ..font }, false);
    }
    (drawing, top)
}

/// A text that is not wider than this in px.
fn shortened(text: &str, font: &Font, width: f64) -> String {
    if font.width(text) <= width {
        return text.to_owned();
    }
    let mut short: Vec<char> = text.chars().collect();
    while font.width(&short.iter().collect::<String>()) > width {
        short.pop();
    }
    short.into_iter().chain(['…']).collect()
}

/// Time axis of all runs: from where the first begins to where the last ends.
fn time_axis(runs: &[Run]) -> Axis {
    let ends = |end: usize| runs.iter().map(move |run| run.window[end]);
    let low = ends(0).fold(f64::INFINITY, f64::min);
    let high = ends(1).fold(f64::NEG_INFINITY, f64::max);
    Axis::linear(low, high.max(low + 1e-3))
}

/// A panel for each joint, one above the other, over time.
fn time_panels(
    drawing: &mut Drawing,
    top: f64,
    runs: &[Run],
    y_title: &str,
    axis: impl Fn(usize) -> Axis,
    mut draw: impl FnMut(&mut Drawing, &Panel, usize),
) {
    for joint in 0..JOINTS {
        let panel = Panel {
            frame: Rect::row(top + (PANEL_PX + 46.0) * joint as f64, PANEL_PX),
            x: time_axis(runs),
            y: axis(joint),
        };
        let x_title = (joint + 1 == JOINTS).then_some("time since the runs are aligned (s)");
        panel.draw(
            drawing,
            &format!("Joint {}", joint + 1),
            x_title,
            Some(y_title),
        );
        for run in &runs[1..] {
            marks::draw_gaps(drawing, &panel, run);
            marks::draw_faults(drawing, &panel, run);
        }
        marks::draw(drawing, &panel, &runs[0], joint);
        if joint == 0 {
            marks::draw_texts(drawing, &panel, &runs[0], top - 27.0);
        }
        draw(drawing, &panel, joint);
    }
}

/// Height in px of panels one above the other.
const TIME_PANELS_PX: f64 = JOINTS as f64 * (PANEL_PX + 46.0) + 10.0;

/// Draws a quantity of each run, the first on top.
fn curves(
    drawing: &mut Drawing,
    panel: &Panel,
    runs: &[Run],
    quantity: impl Fn(&Record) -> f64 + Copy,
) {
    for (place, run) in runs.iter().enumerate().rev() {
        panel.curve(drawing, run.over_time(quantity), stroke(place));
    }
}

/// Axis around a quantity of all runs.
fn around(runs: &[Run], quantity: impl Fn(&Record) -> f64 + Copy) -> Axis {
    let records = runs.iter().flat_map(Run::records);
    Axis::around(records.map(quantity), 0.06)
}

fn angles(runs: &[Run]) -> Drawing {
    let (mut drawing, top) = begin("Joint angles", runs, TIME_PANELS_PX, &[]);
    let axis = |joint| around(runs, |r| angle_rad(r, joint));
    time_panels(
        &mut drawing,
        top,
        runs,
        "angle (rad)",
        axis,
        |drawing, panel, joint| {
            curves(drawing, panel, runs, |r| angle_rad(r, joint));
            // Dashes of equal references cover each other.
            for (place, run) in runs.iter().enumerate().rev() {
                let colour = if place == 0 {
                    INK
                } else {
                    stroke(place).colour
                };
                let dashed = Stroke { colour, ..SETPOINT };
                panel.curve(drawing, run.over_time(|r| reference_rad(r, joint)), dashed);
            }
        },
    );
    drawing
}

fn tracking(runs: &[Run]) -> Drawing {
    let rms = |run: &Run| {
        let [first, second] = run.error_rms_rad.map(|rad| 1e3 * rad);
        format!("rms {first:.1} and {second:.1} mrad")
    };
    let notes: Vec<_> = runs.iter().map(rms).collect();
    let (mut drawing, top) = begin("Tracking error", runs, TIME_PANELS_PX, &notes);
    let axis = |joint| around(runs, |r| 1e3 * error_rad(r, joint));
    time_panels(
        &mut drawing,
        top,
        runs,
        "estimate minus reference (mrad)",
        axis,
        |drawing, panel, joint| {
            let band = 1e3 * SETTLED_RAD;
            let ends = [panel.x.low, panel.x.high];
            panel.area(drawing, (ends[0], -band), (ends[1], band), GOOD, 0.12);
            panel.level(drawing, 0.0, ZERO);
            curves(drawing, panel, runs, |r| 1e3 * error_rad(r, joint));
        },
    );
    drawing
}

fn torque(runs: &[Run]) -> Drawing {
    let (mut drawing, top) = begin("Joint torque", runs, TIME_PANELS_PX, &[]);
    let axis = |joint| around(runs, |r| f64::from(r.output.torque_nm[joint]));
    time_panels(
        &mut drawing,
        top,
        runs,
        "torque decided (N m)",
        axis,
        |drawing, panel, joint| {
            panel.level(drawing, 0.0, ZERO);
            for limit in runs
                .iter()
                .flat_map(|run| run.facts.torque_limits_nm[joint])
            {
                panel.level(drawing, limit, LIMIT);
            }
            curves(drawing, panel, runs, |r| {
                f64::from(r.output.torque_nm[joint])
            });
        },
    );
    drawing
}

fn difference(runs: &[Run]) -> Result<Drawing, ReadError> {
    let mut differences = Vec::new();
    if let [first, others @ ..] = runs {
        for other in others {
            differences.push(Difference::read(first, other)?);
        }
    }
    let note = |difference: &Difference| {
        let [first, second] = difference.rms_mrad;
        format!("minus the first: rms {first:.1} and {second:.1} mrad")
    };
    let mut notes = vec![String::new()];
    notes.extend(differences.iter().map(note));
    let (mut drawing, top) = begin("Difference of joint angles", runs, TIME_PANELS_PX, &notes);
    let axis = |joint| {
        let values = differences.iter().flat_map(|one| one.curve(joint));
        Axis::around(values.map(|(_, mrad)| mrad).chain([-1.0, 1.0]), 0.06)
    };
    time_panels(
        &mut drawing,
        top,
        runs,
        "run minus first run (mrad)",
        axis,
        |drawing, panel, joint| {
            panel.level(drawing, 0.0, ZERO);
            for (place, difference) in differences.iter().enumerate() {
                panel.curve(drawing, difference.curve(joint), stroke(place + 1));
            }
        },
    );
    Ok(drawing)
}

fn paths(runs: &[Run]) -> Drawing {
    let (mut drawing, top) = begin("Path", runs, 622.0, &[]);
    let curves = runs
        .iter()
        .flat_map(|run| [&run.path_curve, &run.reference_curve]);
    let panel = path::panel(&mut drawing, top, curves);
    for (place, run) in runs.iter().enumerate().rev() {
        panel.trace(&mut drawing, phase::points(&run.path_curve), stroke(place));
        path::draw_reference(&mut drawing, &panel, run);
        path::draw_start(&mut drawing, &panel, run, stroke(place).colour);
    }
    drawing
}

fn phases(runs: &[Run]) -> Drawing {
    let (mut drawing, top) = begin("Phase plane", runs, 508.0, &[]);
    for joint in 0..JOINTS {
        let curves = runs.iter().map(|run| &run.phase[joint]);
        let panel = phase::panel(&mut drawing, top, joint, curves);
        for (place, run) in runs.iter().enumerate().rev() {
            panel.trace(
                &mut drawing,
                phase::points(&run.phase[joint]),
                stroke(place),
            );
        }
    }
    drawing
}

fn spectra(runs: &[Run]) -> Drawing {
    let (mut drawing, top) = begin(
        "Power spectral density of the error",
        runs,
        TIME_PANELS_PX,
        &[],
    );
    let rate_hz = runs
        .iter()
        .map(|run| 1.0 / run.period_s())
        .fold(0.0, f64::max);
    for joint in 0..JOINTS {
        let frame = Rect::row(top + (PANEL_PX + 46.0) * joint as f64, PANEL_PX);
        let curves: Vec<_> = runs
            .iter()
            .enumerate()
            .map(|(place, run)| (stroke(place), run.spectra[0][joint].as_ref()))
            .collect();
        let last = joint + 1 == JOINTS;
        let title = format!("Joint {}: estimate minus reference", joint + 1);
        spectrum::draw_panel(
            &mut drawing,
            frame,
            &title,
            &SIGNALS[0],
            &curves,
            last,
            rate_hz,
        );
    }
    drawing
}
