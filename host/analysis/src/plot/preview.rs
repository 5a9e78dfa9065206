//! `preview`: reference and possible range of each joint, before the arm moves.

use std::path::{Path, PathBuf};

use super::axis::Axis;
use super::drawing::{Anchor, Drawing, Font, Stroke};
use super::panel::{self, INK, JOINT, JOINT_TINT, Key, LIMIT, MUTED, Panel};
use super::{PlotError, titled, write_all};
use crate::scenario::{JointPreview, Preview};

/// Name of the figure's files.
const NAME: &str = "preview";
/// Width of the reference's curve in px.
const REFERENCE_WIDTH: f64 = 1.6;
/// Space around a step's number, in px; with less, the number is left out.
const NUMBER_MARGIN_PX: f64 = 8.0;
/// Stroke of the start of a step.
const STEP: Stroke = Stroke {
    colour: MUTED,
    width: 0.8,
    dash: &[1.0, 3.0],
};

/// Draws a preview into a folder, as SVG and PNG; `about` names the board. Returns the files.
///
/// # Errors
/// If a file cannot be written or the drawing cannot be rendered.
pub fn draw_preview(
    folder: &Path,
    preview: &Preview,
    about: &str,
) -> Result<Vec<PathBuf>, PlotError> {
    write_all(folder, [(NAME, figure(preview, about))])
}

fn figure(preview: &Preview, about: &str) -> Drawing {
    let title = format!("Before it moves · armbridge {}", preview.name);
    let mut drawing = titled(panel::height(preview.joints), &title, about);
    for joint in 0..preview.joints {
        let limit = f64::from(preview.limit_rad[joint]);
        let x = Axis::linear(0.0, preview.end_s);
        let y = Axis::around([-limit, limit].into_iter(), 0.14);
        let panel = Panel::angle(&mut drawing, joint, preview.joints, x, y);
        draw_joint(&mut drawing, &panel, preview, joint);
    }
    drawing
}

fn draw_joint(drawing: &mut Drawing, panel: &Panel, preview: &Preview, joint: usize) {
    let joint_preview = || {
        let stages = preview.stages.iter();
        stages.map(|stage| (stage, &stage.joints[joint]))
    };
    for (stage, joint_preview) in joint_preview() {
        if let Some([low, high]) = joint_preview.range_rad {
            let (fill, opacity) = if joint_preview.is_guarded {
                (JOINT_TINT[joint], 0.45)
            } else {
                (JOINT[joint], 0.10)
            };
            let [from, to] = [(stage.time_s.start, low), (stage.time_s.end, high)];
            panel.area(drawing, from, to, fill, opacity);
        }
    }
    let limit = f64::from(preview.limit_rad[joint]);
    panel.level(drawing, limit, LIMIT);
    panel.level(drawing, -limit, LIMIT);
    let reference = Stroke::solid(JOINT[joint], REFERENCE_WIDTH);
    panel.curve(
        drawing,
        references(joint_preview().map(|(_, joint_preview)| joint_preview)),
        reference,
    );
    number_steps(drawing, panel, preview);
    let entries = [
        (Key::Line(reference), "reference"),
        (Key::Band(JOINT[joint]), "possible range"),
        (Key::Area(JOINT_TINT[joint]), "envelope of an experiment"),
        (Key::Line(LIMIT), "limit: motors off"),
    ];
    panel.legend(drawing, &entries);
}

/// Reference over all stages, with gaps where there is none.
fn references<'a>(
    joint_preview: impl Iterator<Item = &'a JointPreview>,
) -> impl Iterator<Item = (f64, f64)> {
    joint_preview.flat_map(|joint_preview| {
        let gap = joint_preview
            .reference
            .is_empty()
            .then_some((f64::NAN, f64::NAN));
        gap.into_iter()
            .chain(joint_preview.reference.iter().copied())
    })
}

/// Draws a line at the start of each step, with its number if there is room.
fn number_steps(drawing: &mut Drawing, panel: &Panel, preview: &Preview) {
    let font = Font {
        size: 11.0,
        bold: false,
        colour: INK,
        anchor: Anchor::Start,
    };
    let mut free = panel.frame.x;
    for stage in &preview.stages {
        let (x, _) = panel.at(stage.time_s.start, panel.y.low);
        let number = stage.step.to_string();
        let end = x + font.width(&number) + NUMBER_MARGIN_PX;
        if x < free || end > panel.frame.right() {
            continue;
        }
        let (top, bottom) = (panel.frame.y, panel.frame.bottom());
        drawing.line((x, top), (x, bottom), STEP);
        drawing.note((x + NUMBER_MARGIN_PX / 2.0, top + 13.0), &number, font);
        free = end;
    }
}
