//! Figure of the correlations of all parameters: the darker, the stronger.

use super::super::checks::correlation_matrix;
use super::super::fit_result::FitResult;
use super::super::quantity::{PER_JOINT, Quantity};
use crate::plot::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use crate::plot::panel::{FRAME, INK, JOINT, LABEL, MUTED};
use crate::plot::titled;

const LEFT: f64 = 250.0;
const TOP: f64 = 196.0;
const CELL: f64 = 30.0;
/// Magnitude above which a correlation is written in digits.
const WRITTEN: f64 = 0.3;

/// Draws the figure for an arm with this number of joints.
pub(super) fn draw(fit: &FitResult, joints: usize) -> Drawing {
    let count = PER_JOINT * joints;
    let all = correlation_matrix(fit);
    let size = CELL * count as f64;
    let mut drawing = titled(
        TOP + size + 40.0,
        "Correlations of the estimates",
        "blue: negative; orange: positive; in hundredths",
    );
    let light = Font {
        anchor: Anchor::End,
        ..LABEL
    };
    for i in 0..count {
        let at = CELL * i as f64;
        let quantity = Quantity::ALL[i % PER_JOINT];
        let name = format!("{} {}", quantity.name(), i / PER_JOINT + 1);
        drawing.text((LEFT - 8.0, TOP + at + 20.0), &name, light, false);
        let upwards = Font {
            anchor: Anchor::Start,
            ..LABEL
        };
        drawing.text((LEFT + at + 20.0, TOP - 8.0), &name, upwards, true);
        for j in 0..count {
            let r = all[(i, j)];
            if !r.is_finite() {
                continue;
            }
            let cell = Rect {
                x: LEFT + CELL * j as f64,
                y: TOP + at,
                w: CELL - 1.0,
                h: CELL - 1.0,
            };
            let (colour, opacity) = if i == j {
                (MUTED, 0.25)
            } else {
                (JOINT[usize::from(r > 0.0)], r.abs().min(1.0) * 0.85)
            };
            drawing.rect(cell, colour, (opacity * 100.0).round() / 100.0);
            if i != j && r.abs() > WRITTEN {
                let font = Font {
                    size: 10.5,
                    bold: r.abs() > 0.9,
                    colour: INK,
                    anchor: Anchor::Middle,
                };
                let text = format!("{:.0}", 100.0 * r).replace('-', "−");
                drawing.text((cell.x + 14.5, cell.y + 19.0), &text, font, false);
            }
        }
    }
    // Between the joints.
    for joint in 1..joints {
        let middle = CELL * (PER_JOINT * joint) as f64 - 0.5;
        let line = Stroke::solid(FRAME, 1.5);
        drawing.line((LEFT + middle, TOP), (LEFT + middle, TOP + size), line);
        drawing.line((LEFT, TOP + middle), (LEFT + size, TOP + middle), line);
    }
    drawing
}
