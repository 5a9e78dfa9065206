//! Figure of the measured angles, the angles by each model, and the residuals.

use std::path::{Path, PathBuf};

use super::comparison::{FittedExperiment, PaperComparison};
use super::sampled_experiment::ExperimentKind;
use armbridge_analysis::plot::axis::Axis;
use armbridge_analysis::plot::drawing::{Drawing, Rect, Stroke};
use armbridge_analysis::plot::panel::{ALARM, FRAME, GOOD, JOINT, Key, Panel};
use armbridge_analysis::plot::{PlotError, titled, write_all};

/// Name of the figure's files.
const NAME: &str = "paper-identification";

const MEASURED: &str = JOINT[0];
const VISCOUS: Stroke = Stroke {
    colour: ALARM,
    width: 1.5,
    dash: &[6.0, 4.0],
};
const DRY: Stroke = Stroke::solid(GOOD, 1.8);
const ZERO: Stroke = Stroke::solid(FRAME, 1.2);

/// Largest number of dots of measured angles and of points of residuals.
const DOTS: usize = 40;
const BLOCKS: usize = 120;

/// Distance from the top of one experiment to that of the next.
const HEIGHT: f64 = 494.0;
const TOP: f64 = 78.0;

impl PaperComparison {
    /// Draws the first experiment of each kind: angles, and below them residuals.
    fn drawing(&self) -> Drawing {
        let kinds = [ExperimentKind::FreeFall, ExperimentKind::ConstantInput];
        let first = |kind| {
            self.experiments
                .iter()
                .find(move |fitted| fitted.sampled.kind == kind)
        };
        let experiments: Vec<&FittedExperiment> = kinds.into_iter().filter_map(first).collect();
        let height = TOP + HEIGHT * experiments.len() as f64;
        let mut drawing = titled(height, "The paper's identification", &self.source);
        for (i, fitted) in experiments.iter().enumerate() {
            draw(&mut drawing, fitted, TOP + HEIGHT * i as f64);
        }
        drawing
    }

    /// Writes the figure into a folder as SVG and PNG; returns the files.
    ///
    /// # Errors
    /// If a file cannot be written or the drawing cannot be rendered.
    pub fn draw(&self, folder: &Path) -> Result<Vec<PathBuf>, PlotError> {
        write_all(folder, [(NAME, self.drawing())])
    }
}

fn draw(drawing: &mut Drawing, fitted: &FittedExperiment, top: f64) {
    let sampled = &fitted.sampled;
    let measured: Vec<(f64, f64)> = sampled.points().collect();
    let x = Axis::linear(0.0, measured.last().map_or(1.0, |last| last.0).max(1e-3));
    let frame = Rect::row(top, 230.0);
    // The viscous model is drawn last: its dashes show where both coincide.
    let dry = fitted.dry_rad.iter();
    let models: Vec<(&str, Stroke, &[Option<f64>])> = dry
        .map(|dry| ("with dry friction", DRY, dry.as_slice()))
        .chain([("viscous only", VISCOUS, fitted.viscous_rad.as_slice())])
        .collect();
    // Computed angle = measured angle - residual.
    let computed = |residuals: &[Option<f64>]| -> Vec<(f64, f64)> {
        let pairs = sampled.angles_rad.iter().zip(residuals).enumerate();
        let point = |(k, (angle, residual)): (usize, (&Option<f64>, &Option<f64>))| {
            Some((k as f64 * sampled.period_s, (*angle)? - (*residual)?))
        };
        pairs.filter_map(point).collect()
    };
    let curves: Vec<_> = models.iter().map(|model| computed(model.2)).collect();
    let all = curves.iter().flatten().chain(&measured);
    let panel = Panel {
        frame,
        x,
        y: Axis::around(all.map(|(_, y)| *y), 0.06),
    };
    let title = format!("Joint 1: {}", sampled.kind.name());
    panel.draw(drawing, &title, None, Some("angle (rad)"));
    let mut legend = vec![(Key::Dots(MEASURED), "measured")];
    for ((name, stroke, _), curve) in models.iter().zip(curves) {
        panel.curve(drawing, curve.into_iter(), *stroke);
        legend.push((Key::Line(*stroke), *name));
    }
    let selected = measured
        .iter()
        .step_by(measured.len().div_ceil(DOTS).max(1));
    let centres: Vec<(f64, f64)> = selected.map(|(t, q)| panel.at(*t, *q)).collect();
    drawing.dots(centres, 4.5, MEASURED);
    panel.legend(drawing, &legend);

    let block_len = sampled.angles_rad.len().div_ceil(BLOCKS).max(1);
    let block_means = |residuals: &[Option<f64>]| -> Vec<(f64, f64)> {
        let blocks = residuals.chunks(block_len).enumerate();
        let point = |(k, block): (usize, &[Option<f64>])| {
            let present: Vec<f64> = block.iter().flatten().copied().collect();
            let middle_s =
                ((k * block_len) as f64 + 0.5 * (block.len() - 1) as f64) * sampled.period_s;
            let mean = present.iter().sum::<f64>() / present.len() as f64;
            (!present.is_empty()).then_some((middle_s, 1e3 * mean))
        };
        blocks.filter_map(point).collect()
    };
    let curves: Vec<_> = models.iter().map(|model| block_means(model.2)).collect();
    let panel = Panel {
        frame: Rect {
            y: top + 264.0,
            h: 150.0,
            ..frame
        },
        x,
        y: Axis::around(curves.iter().flatten().map(|(_, y)| *y).chain([0.0]), 0.1),
    };
    let title = match block_len {
        1 => "measured minus computed".to_owned(),
        len => format!("measured minus computed, means of {len} samples"),
    };
    panel.draw(drawing, &title, Some("time (s)"), Some("(mrad)"));
    panel.level(drawing, 0.0, ZERO);
    for ((_, stroke, _), curve) in models.iter().zip(curves) {
        panel.curve(drawing, curve.into_iter(), *stroke);
    }
}
