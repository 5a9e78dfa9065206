//! Panels: framed areas with two axes, a title, a legend, and curves.

use super::axis::Axis;
use super::decimate::{decimate, distinct};
use super::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use super::trace::Trace;

/// Colours of text and frames, from dark to light.
pub const INK: &str = "#1f2933";
/// Secondary text.
pub(crate) const MUTED: &str = "#5f6c7b";
/// Frames and axes.
pub const FRAME: &str = "#aab4bf";
/// Grid lines.
pub const GRID: &str = "#e9edf1";
/// Colour of each joint, and its light tint for samples.
pub const JOINT: [&str; 2] = ["#1769aa", "#c8561b"];
/// Areas and bands of the two joints.
pub(crate) const JOINT_TINT: [&str; 2] = ["#9cc3e3", "#f0b996"];
/// Colour of limits, faults and missing data.
pub const ALARM: &str = "#b4232f";
/// Colour of intervals without records.
pub const GAP: &str = "#dfe4e9";
/// Colour of permitted ranges and good results.
pub const GOOD: &str = "#2a9d6a";

/// Colour of a fourth curve.
pub const FOURTH: &str = "#8250a8";

/// Font of axis titles, tick labels and legends.
pub(crate) const LABEL: Font = Font {
    size: 12.0,
    bold: false,
    colour: MUTED,
    anchor: Anchor::Middle,
};
/// Stroke of setpoints.
pub(crate) const SETPOINT: Stroke = Stroke {
    colour: INK,
    width: 1.3,
    dash: &[6.0, 4.0],
};
/// Stroke of a servo's limits.
pub(crate) const LIMIT: Stroke = Stroke {
    colour: ALARM,
    width: 1.2,
    dash: &[3.0, 3.0],
};

/// Px between tick labels.
const TICK_SPACING_X: f64 = 70.0;
const TICK_SPACING_Y: f64 = 34.0;

/// Side of a square in px through which a curve is traced once.
const TRACE_PX: f64 = 1.5;

/// A framed area with two axes.
#[derive(Clone, Copy, Debug)]
pub struct Panel {
    /// Place in the drawing.
    pub frame: Rect,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
}

/// Symbol of a legend's entry.
#[derive(Clone, Copy, Debug)]
pub enum Key {
    /// A line.
    Line(Stroke),
    /// Dots of this colour.
    Dots(&'static str),
    /// A band of this colour.
    Band(&'static str),
    /// A filled area of this colour.
    Area(&'static str),
    /// A cross.
    Cross(Stroke),
    /// A ring of this colour.
    Ring(&'static str),
}

/// Height in px of a figure with one panel for each of this number of joints.
pub(super) fn height(joints: usize) -> f64 {
    100.0 + 270.0 * joints as f64
}

impl Panel {
    /// Draws the frame of a joint's angle over time, one of `joints` from above.
    pub fn angle(drawing: &mut Drawing, joint: usize, joints: usize, x: Axis, y: Axis) -> Self {
        let panel = Self {
            frame: Rect::row(78.0 + 270.0 * joint as f64, 224.0),
            x,
            y,
        };
        let x_title = (joint + 1 == joints).then_some("time (s)");
        let title = format!("Joint {}", joint + 1);
        panel.draw(drawing, &title, x_title, Some("angle (rad)"));
        panel
    }

    /// Px of a point.
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let Rect { x: left, w, h, .. } = self.frame;
        (
            left + self.x.position(x) * w,
            self.frame.bottom() - self.y.position(y) * h,
        )
    }

    /// Grid, frame, tick labels, axis titles; `x_title` none for an axis that
    /// is labelled by a panel below, `y_title` likewise for one beside.
    pub fn draw(
        &self,
        drawing: &mut Drawing,
        title: &str,
        x_title: Option<&str>,
        y_title: Option<&str>,
    ) {
        let Rect { x, y, w, h } = self.frame;
        let (right, bottom) = (self.frame.right(), self.frame.bottom());
        let (grid, frame) = (Stroke::solid(GRID, 1.0), Stroke::solid(FRAME, 1.0));
        for (value, label) in self.x.ticks(w / TICK_SPACING_X) {
            let (px, _) = self.at(value, self.y.low);
            drawing.line((px, y), (px, bottom), grid);
            if x_title.is_some() {
                drawing.text((px, bottom + 17.0), &label, LABEL, false);
            }
        }
        for (value, label) in self.y.ticks(h / TICK_SPACING_Y) {
            let (_, py) = self.at(self.x.low, value);
            drawing.line((x, py), (right, py), grid);
            if y_title.is_some() {
                let font = Font {
                    anchor: Anchor::End,
                    ..LABEL
                };
                drawing.text((x - 7.0, py + 4.0), &label, font, false);
            }
        }
        let corners = vec![(x, y), (right, y), (right, bottom), (x, bottom), (x, y)];
        drawing.polyline(vec![corners], frame);
        if let Some(text) = x_title {
            drawing.text((x + w / 2.0, bottom + 36.0), text, LABEL, false);
        }
        if let Some(text) = y_title {
            drawing.text((x - 50.0, y + h / 2.0), text, LABEL, true);
        }
        self.title(drawing, title);
    }

    /// A title above the left end of the frame.
    pub fn title(&self, drawing: &mut Drawing, title: &str) {
        let font = Font {
            size: 13.0,
            bold: true,
            colour: INK,
            anchor: Anchor::Start,
        };
        drawing.text((self.frame.x, self.frame.y - 9.0), title, font, false);
    }

    /// A legend above the right end of the frame.
    pub fn legend(&self, drawing: &mut Drawing, entries: &[(Key, &str)]) {
        let font = Font {
            anchor: Anchor::Start,
            ..LABEL
        };
        let y = self.frame.y - 13.0;
        let mut right = self.frame.right();
        for (key, text) in entries.iter().rev() {
            let left = right - font.width(text);
            drawing.text((left, y + 4.0), text, font, false);
            match *key {
                Key::Line(stroke) => drawing.line((left - 28.0, y), (left - 6.0, y), stroke),
                Key::Dots(colour) => {
                    {
                        let centres = [-25.0, -17.0, -9.0].map(|dx| (left + dx, y));
                        drawing.dots(centres.into(), 4.0, colour);
                    };
                }
                Key::Band(fill) => drawing.rect(swatch(left, y), fill, 0.18),
                Key::Area(fill) => drawing.rect(swatch(left, y), fill, 1.0),
                Key::Cross(stroke) => drawing.cross((left - 17.0, y), stroke),
                Key::Ring(colour) => drawing.ring((left - 17.0, y), colour),
            }
            right = left - 46.0;
        }
    }

    /// Draws a curve that may cross itself, with a gap at each value that is not finite.
    pub fn trace(
        &self,
        drawing: &mut Drawing,
        points: impl Iterator<Item = (f64, f64)>,
        stroke: Stroke,
    ) {
        let mut trace = Trace::new([TRACE_PX; 2]);
        points.for_each(|(x, y)| trace.add(self.at(x, y)));
        let pieces = trace.into_pieces();
        self.clipped(drawing, |drawing| drawing.polyline(pieces, stroke));
    }

    /// A curve, with a gap at each value that is not finite.
    pub fn curve(
        &self,
        drawing: &mut Drawing,
        points: impl Iterator<Item = (f64, f64)>,
        stroke: Stroke,
    ) {
        let pieces = decimate(points.map(|(x, y)| self.at(x, y)));
        self.clipped(drawing, |drawing| drawing.polyline(pieces, stroke));
    }

    /// A cross at a point; none outside the frame.
    pub(crate) fn cross(&self, drawing: &mut Drawing, (x, y): (f64, f64), stroke: Stroke) {
        if self.contains((x, y)) {
            drawing.cross(self.at(x, y), stroke);
        }
    }

    /// A ring at a point; none outside the frame.
    pub(crate) fn ring(&self, drawing: &mut Drawing, (x, y): (f64, f64), colour: &'static str) {
        if self.contains((x, y)) {
            drawing.ring(self.at(x, y), colour);
        }
    }

    /// Whether a point is in the frame; false for one that is not finite.
    fn contains(&self, (x, y): (f64, f64)) -> bool {
        (self.x.low..=self.x.high).contains(&x) && (self.y.low..=self.y.high).contains(&y)
    }

    /// A dot for each point.
    pub fn dots(
        &self,
        drawing: &mut Drawing,
        points: impl Iterator<Item = (f64, f64)>,
        colour: &'static str,
    ) {
        let dots = distinct(points.map(|(x, y)| self.at(x, y)));
        self.clipped(drawing, |drawing| drawing.dots(dots, 2.2, colour));
    }

    /// A filled area between two corners.
    pub(crate) fn area(
        &self,
        drawing: &mut Drawing,
        a: (f64, f64),
        b: (f64, f64),
        fill: &'static str,
        opacity: f64,
    ) {
        let ((ax, ay), (bx, by)) = (self.at(a.0, a.1), self.at(b.0, b.1));
        let area = Rect {
            x: ax.min(bx),
            y: ay.min(by),
            w: (ax - bx).abs(),
            h: (ay - by).abs(),
        };
        self.clipped(drawing, |drawing| drawing.rect(area, fill, opacity));
    }

    /// A level line over the whole width.
    pub fn level(&self, drawing: &mut Drawing, y: f64, stroke: Stroke) {
        let (_, py) = self.at(self.x.low, y);
        self.clipped(drawing, |drawing| {
            drawing.line((self.frame.x, py), (self.frame.right(), py), stroke);
        });
    }

    fn clipped(&self, drawing: &mut Drawing, draw: impl FnOnce(&mut Drawing)) {
        // Lines and dots on the very edge show in full.
        let Rect { x, y, w, h } = self.frame;
        drawing.begin_clip(Rect {
            x: x - 1.5,
            y: y - 1.5,
            w: w + 3.0,
            h: h + 3.0,
        });
        draw(drawing);
        drawing.end_clip();
    }
}

/// Rectangle of an area's symbol in a legend, for a text that begins at `left`.
fn swatch(left: f64, y: f64) -> Rect {
    Rect {
        x: left - 28.0,
        y: y - 5.0,
        w: 22.0,
        h: 10.0,
    }
}
