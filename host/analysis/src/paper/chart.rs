//! A figure of the report: panels with curves, drawn with the plots' own parts.

use crate::plot::axis::{Axis, Scale};
use crate::plot::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use crate::plot::panel::{ALARM, FOURTH, GOOD, INK, JOINT, Key, Panel};
use crate::plot::titled;

/// The paper's values or its model.
pub(crate) const MODEL: Stroke = Stroke {
    colour: INK,
    width: 1.5,
    dash: &[6.0, 4.0],
};
/// The simulated arm, with speeds by differences.
pub(crate) const DIFFERENCE: Stroke = Stroke::solid(JOINT[1], 1.8);
/// The simulated arm, with the printed observer.
pub(crate) const PRINTED: Stroke = Stroke::solid(JOINT[0], 1.8);
/// The simulated arm, with the observer that the printed poles give.
pub(crate) const PLACED: Stroke = Stroke::solid(FOURTH, 1.8);
/// The simulated arm, mended.
pub(crate) const MENDED: Stroke = Stroke::solid(GOOD, 1.8);
/// What is wrong, or a limit.
pub(crate) const WRONG: Stroke = Stroke {
    colour: ALARM,
    width: 1.5,
    dash: &[3.0, 3.0],
};

const TOP: f64 = 78.0;
/// From the bottom of a panel to the top of the next, and to the figure's end.
const GAP: f64 = 46.0;
const BOTTOM: f64 = 52.0;

/// A figure with its caption.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name of its files, without ending.
    pub name: &'static str,
    /// Its number in the paper, as `Fig. 5`; none where the paper has none.
    pub of_paper: Option<&'static str>,
    /// What it shows, in a sentence or three.
    pub caption: String,
    pub(crate) chart: Chart,
}

impl Figure {
    pub(crate) fn drawing(&self) -> Drawing {
        self.chart.draw(self.of_paper)
    }
}

/// Panels one above the other, on one x axis.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    pub(crate) title: &'static str,
    pub(crate) x_title: &'static str,
    /// Smallest and largest x.
    pub(crate) x: [f64; 2],
    pub(crate) panels: Vec<Part>,
}

/// A panel of a chart.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) title: String,
    pub(crate) y_title: &'static str,
    pub(crate) height: f64,
    /// Smallest and largest y; none to show all of every curve.
    pub(crate) y: Option<[f64; 2]>,
    pub(crate) log: bool,
    pub(crate) curves: Vec<Curve>,
    pub(crate) levels: Vec<Level>,
}

/// A curve and its name in the legend; nothing is written for an empty one.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) name: &'static str,
    pub(crate) stroke: Stroke,
    pub(crate) points: Vec<(f64, f64)>,
}

/// A level line with words above its left end.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    pub(crate) name: String,
    pub(crate) y: f64,
}

impl Part {
    /// A panel of usual height on a linear axis that shows all.
    pub(crate) fn new(title: impl Into<String>, y_title: &'static str, curves: Vec<Curve>) -> Self {
        Self {
            title: title.into(),
            y_title,
            height: 300.0,
            y: None,
            log: false,
            curves,
            levels: Vec::new(),
        }
    }

    fn axis(&self) -> Axis {
        let scale = if self.log { Scale::Log } else { Scale::Linear };
        if let Some([low, high]) = self.y {
            return Axis { scale, low, high };
        }
        let curves = self.curves.iter().flat_map(|curve| &curve.points);
        let levels = self.levels.iter().map(|level| level.y);
        Axis::around(curves.map(|(_, y)| *y).chain(levels), 0.06)
    }
}

impl Curve {
    pub(crate) fn new(name: &'static str, stroke: Stroke, points: Vec<(f64, f64)>) -> Self {
        Self {
            name,
            stroke,
            points,
        }
    }

    /// Of values in rad, drawn in mrad; a gap where one is infinite.
    pub(crate) fn in_mrad(name: &'static str, stroke: Stroke, points: &[(f64, f64)]) -> Self {
        let mrad = |rad: f64| if rad.is_finite() { rad * 1e3 } else { f64::NAN };
        let points = points.iter().map(|(x, rad)| (*x, mrad(*rad)));
        Self::new(name, stroke, points.collect())
    }
}

impl Chart {
    fn height(&self) -> f64 {
        let panels: f64 = self.panels.iter().map(|panel| panel.height).sum();
        TOP + panels + GAP * (self.panels.len() as f64 - 1.0) + BOTTOM
    }

    fn draw(&self, of_paper: Option<&str>) -> Drawing {
        let source = of_paper.map_or_else(
            || "simulated · no such figure in the paper".to_owned(),
            |figure| format!("simulated · {figure} of the paper"),
        );
        let mut drawing = titled(self.height(), self.title, &source);
        let mut top = TOP;
        for (i, part) in self.panels.iter().enumerate() {
            let panel = Panel {
                frame: Rect::row(top, part.height),
                x: Axis::linear(self.x[0], self.x[1]),
                y: part.axis(),
            };
            let last = i + 1 == self.panels.len();
            let x_title = last.then_some(self.x_title);
            panel.draw(&mut drawing, &part.title, x_title, Some(part.y_title));
            draw_part(&mut drawing, &panel, part);
            top += part.height + GAP;
        }
        drawing
    }
}

fn draw_part(drawing: &mut Drawing, panel: &Panel, part: &Part) {
    for level in &part.levels {
        panel.level(drawing, level.y, WRONG);
        let font = Font {
            size: 11.5,
            bold: false,
            colour: ALARM,
            anchor: Anchor::Start,
        };
        let (left, y) = panel.at(panel.x.low, level.y);
        drawing.text((left + 7.0, y - 5.0), &level.name, font, false);
    }
    for curve in &part.curves {
        panel.curve(drawing, curve.points.iter().copied(), curve.stroke);
    }
    let legend: Vec<_> = part
        .curves
        .iter()
        .filter(|curve| !curve.name.is_empty())
        .map(|curve| (Key::Line(curve.stroke), curve.name))
        .collect();
    panel.legend(drawing, &legend);
}
