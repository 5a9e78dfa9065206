//! `preview`: where an arm will be asked to go, and where it may get to, before it moves.

use std::path::{Path, PathBuf};

use armbridge_shared::JOINTS;

use super::axis::Axis;
use super::drawing::{Anchor, Drawing, Font, Stroke};
use super::panel::{INK, JOINT, JOINT_TINT, Key, LIMIT, MUTED, Panel};
use super::{PlotError, titled, write_all};
use crate::scenario::{Outlook, Swept};

/// Name of the picture's files.
const NAME: &str = "preview";
/// Where a joint is asked to be.
const ASKED_WIDTH: f64 = 1.6;
/// Room about a step's number, in px; with less, it is left out.
const AROUND_PX: f64 = 8.0;
/// Where a step begins.
const STEP: Stroke = Stroke {
    colour: MUTED,
    width: 0.8,
    dash: &[1.0, 3.0],
};

/// Draws it into a folder, as SVG and PNG; `about` names the board. Returns the files.
///
/// # Errors
/// When a file cannot be written or a drawing not be turned into pixels.
pub fn draw_outlook(
    folder: &Path,
    outlook: &Outlook,
    about: &str,
) -> Result<Vec<PathBuf>, PlotError> {
    write_all(folder, [(NAME, figure(outlook, about))])
}

fn figure(outlook: &Outlook, about: &str) -> Drawing {
    let title = format!("Before it moves · armbridge {}", outlook.name);
    let mut drawing = titled(640.0, &title, about);
    for joint in 0..JOINTS {
        let limit = f64::from(outlook.limit_rad[joint]);
        let x = Axis::linear(0.0, outlook.end_s);
        let y = Axis::around([-limit, limit].into_iter(), 0.14);
        let panel = Panel::angle(&mut drawing, joint, x, y);
        draw_joint(&mut drawing, &panel, outlook, joint);
    }
    drawing
}

fn draw_joint(drawing: &mut Drawing, panel: &Panel, outlook: &Outlook, joint: usize) {
    let swept = || {
        let stages = outlook.stages.iter();
        stages.map(|stage| (stage, &stage.joints[joint]))
    };
    for (stage, swept) in swept() {
        if let Some([low, high]) = swept.range_rad {
            let (fill, opacity) = if swept.is_guarded {
                (JOINT_TINT[joint], 0.45)
            } else {
                (JOINT[joint], 0.10)
            };
            let [from, to] = [(stage.time_s.start, low), (stage.time_s.end, high)];
            panel.area(drawing, from, to, fill, opacity);
        }
    }
    let limit = f64::from(outlook.limit_rad[joint]);
    panel.level(drawing, limit, LIMIT);
    panel.level(drawing, -limit, LIMIT);
    let asked = Stroke::solid(JOINT[joint], ASKED_WIDTH);
    panel.curve(drawing, asked_of(swept().map(|(_, swept)| swept)), asked);
    number_steps(drawing, panel, outlook);
    let entries = [
        (Key::Line(asked), "asked for"),
        (Key::Band(JOINT[joint]), "on the way"),
        (Key::Area(JOINT_TINT[joint]), "envelope of an experiment"),
        (Key::Line(LIMIT), "motors off beyond"),
    ];
    panel.legend(drawing, &entries);
}

/// One stage after the other, with gaps where nothing is known.
fn asked_of<'a>(swept: impl Iterator<Item = &'a Swept>) -> impl Iterator<Item = (f64, f64)> {
    swept.flat_map(|swept| {
        let gap = swept.asked.is_empty().then_some((f64::NAN, f64::NAN));
        gap.into_iter().chain(swept.asked.iter().copied())
    })
}

/// A line where each step begins, with its number where there is room.
fn number_steps(drawing: &mut Drawing, panel: &Panel, outlook: &Outlook) {
    let font = Font {
        size: 11.0,
        bold: false,
        colour: INK,
        anchor: Anchor::Start,
    };
    let mut free = panel.frame.x;
    for stage in &outlook.stages {
        let (x, _) = panel.at(stage.time_s.start, panel.y.low);
        let number = stage.step.to_string();
        let end = x + font.width(&number) + AROUND_PX;
        if x < free || end > panel.frame.right() {
            continue;
        }
        let (top, bottom) = (panel.frame.y, panel.frame.bottom());
        drawing.line((x, top), (x, bottom), STEP);
        drawing.note((x + AROUND_PX / 2.0, top + 13.0), &number, font);
        free = end;
    }
}
