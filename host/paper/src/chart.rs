//! Figures of the report: subplots with curves, drawn with the modules of `plot`.

use armbridge_analysis::plot::axis::{Axis, Scale};
use armbridge_analysis::plot::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use armbridge_analysis::plot::panel::{ALARM, FOURTH, GOOD, INK, JOINT, Key, Panel};
use armbridge_analysis::plot::titled;

/// Stroke of the paper's values or its model.
pub(crate) const MODEL: Stroke = Stroke {
    colour: INK,
    width: 1.5,
    dash: &[6.0, 4.0],
};
/// Stroke of the simulated arm with speeds by differences.
pub(crate) const DIFFERENCE: Stroke = Stroke::solid(JOINT[1], 1.8);
/// Stroke of the simulated arm with the printed observer.
pub(crate) const PRINTED: Stroke = Stroke::solid(JOINT[0], 1.8);
/// Stroke of the simulated arm with the observer that the printed poles give.
pub(crate) const PLACED: Stroke = Stroke::solid(FOURTH, 1.8);
/// Stroke of the simulated arm with the correction.
pub(crate) const CORRECTED: Stroke = Stroke::solid(GOOD, 1.8);
/// Stroke of an erroneous result, or of a limit.
pub(crate) const WRONG: Stroke = Stroke {
    colour: ALARM,
    width: 1.5,
    dash: &[3.0, 3.0],
};

const TOP: f64 = 78.0;
/// Distance from the bottom of a panel to the top of the next.
const GAP: f64 = 46.0;
/// Distance from the bottom of the last panel to the bottom of the figure.
const BOTTOM: f64 = 52.0;

/// A figure with its caption.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name of its files without extension.
    pub name: &'static str,
    /// Number in the paper, as `Fig. 5`; none if the paper has no such figure.
    pub paper_figure: Option<&'static str>,
    /// Caption of one to three sentences.
    pub caption: String,
    pub(crate) chart: Chart,
}

impl Figure {
    pub(crate) fn drawing(&self) -> Drawing {
        self.chart.draw(self.paper_figure)
    }
}

/// Subplots one above the other on a common x axis.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    pub(crate) title: &'static str,
    pub(crate) x_title: &'static str,
    /// Smallest and largest x.
    pub(crate) x: [f64; 2],
    pub(crate) panels: Vec<Subplot>,
}

/// A subplot of a chart.
#[derive(Clone, Debug)]
pub(crate) struct Subplot {
    pub(crate) title: String,
    pub(crate) y_title: &'static str,
    pub(crate) height: f64,
    /// Smallest and largest y; none for a range that contains every curve.
    pub(crate) y: Option<[f64; 2]>,
    pub(crate) log: bool,
    pub(crate) curves: Vec<Curve>,
    pub(crate) levels: Vec<Level>,
}

/// A curve and its name in the legend; a curve with an empty name is not in the legend.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) name: &'static str,
    pub(crate) stroke: Stroke,
    pub(crate) points: Vec<(f64, f64)>,
}

/// A horizontal line with a label above its left end.
#[derive(Clone, Debug)]
pub(crate) struct Level {
    pub(crate) name: String,
    pub(crate) y: f64,
}

impl Subplot {
    /// Subplot of default height with a linear axis that contains every curve.
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

    /// Curve of values in rad, drawn in mrad, with a gap at infinite values.
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

    fn draw(&self, paper_figure: Option<&str>) -> Drawing {
        let source = paper_figure.map_or_else(
            || "simulated · no such figure in the paper".to_owned(),
            |figure| format!("simulated · {figure} of the paper"),
        );
        let mut drawing = titled(self.height(), self.title, &source);
        let mut top = TOP;
        for (i, subplot) in self.panels.iter().enumerate() {
            let panel = Panel {
                frame: Rect::row(top, subplot.height),
                x: Axis::linear(self.x[0], self.x[1]),
                y: subplot.axis(),
            };
            let last = i + 1 == self.panels.len();
            let x_title = last.then_some(self.x_title);
            panel.draw(&mut drawing, &subplot.title, x_title, Some(subplot.y_title));
            draw_subplot(&mut drawing, &panel, subplot);
            top += subplot.height + GAP;
        }
        drawing
    }
}

fn draw_subplot(drawing: &mut Drawing, panel: &Panel, subplot: &Subplot) {
    for level in &subplot.levels {
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
    for curve in &subplot.curves {
        panel.curve(drawing, curve.points.iter().copied(), curve.stroke);
    }
    let legend: Vec<_> = subplot
        .curves
        .iter()
        .filter(|curve| !curve.name.is_empty())
        .map(|curve| (Key::Line(curve.stroke), curve.name))
        .collect();
    panel.legend(drawing, &legend);
}
