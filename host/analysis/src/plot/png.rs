//! Drawings as PNG: each shape as a browser would draw the SVG's element.

use std::error::Error;

use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash,
    Transform,
};
use ttf_parser::FaceParsingError;

use super::drawing::{Drawing, Rect, Shape};
use super::text::Fonts;

/// Pixels of the PNG per px of the drawing, for sharp screens and print.
const SCALE: f32 = 2.0;

/// Failure to render a drawing.
#[derive(Debug, thiserror::Error)]
pub enum RasterError {
    /// Its width or height is zero, or too large.
    #[error("no size")]
    Size,
    /// A font cannot be read.
    #[error(transparent)]
    Font(#[from] FaceParsingError),
    /// The pixels cannot be compressed.
    #[error(transparent)]
    Encode(Box<dyn Error + Send + Sync>),
}

/// The file.
pub(super) fn png(drawing: &Drawing) -> Result<Vec<u8>, RasterError> {
    let size = [drawing.width, drawing.height].map(|px| (px as f32 * SCALE).ceil() as u32);
    let mut page = Page {
        pixels: Pixmap::new(size[0], size[1]).ok_or(RasterError::Size)?,
        fonts: Fonts::load()?,
        clip: None,
    };
    for shape in &drawing.shapes {
        // Shapes without extent, such as a path without points, are skipped.
        let _ = page.draw(shape);
    }
    let file = page.pixels.encode_png();
    file.map_err(|error| RasterError::Encode(error.into()))
}

/// Pixels being drawn.
struct Page {
    pixels: Pixmap,
    fonts: Fonts,
    clip: Option<Mask>,
}

impl Page {
    /// `None` if there is nothing to draw.
    fn draw(&mut self, shape: &Shape) -> Option<()> {
        match shape {
            Shape::Rect {
                area,
                fill,
                opacity,
            } => self.fill(&outline(area)?, fill, *opacity, Transform::identity()),
            Shape::Polyline { pieces, stroke } => {
                let mut path = PathBuilder::new();
                for piece in pieces {
                    for (i, (x, y)) in piece.iter().enumerate() {
                        let (x, y) = (tenth(*x), tenth(*y));
                        if i == 0 {
                            path.move_to(x, y);
                        } else {
                            path.line_to(x, y);
                        }
                    }
                }
                let line = Stroke {
                    width: stroke.width as f32,
                    line_join: LineJoin::Round,
                    dash: StrokeDash::new(stroke.dash.to_vec(), 0.0),
                    ..Stroke::default()
                };
                self.stroke(&path.finish()?, stroke.colour, &line)
            }
            Shape::Dots {
                centres,
                diameter,
                colour,
            } => {
                let mut path = PathBuilder::new();
                for (x, y) in centres {
                    path.move_to(tenth(*x), tenth(*y));
                    path.line_to(tenth(*x) + 0.01, tenth(*y));
                }
                let line = Stroke {
                    width: *diameter as f32,
                    line_cap: LineCap::Round,
                    ..Stroke::default()
                };
                self.stroke(&path.finish()?, colour, &line)
            }
            Shape::Ring { centre, colour } => {
                let circle = PathBuilder::from_circle(tenth(centre.0), tenth(centre.1), 4.0)?;
                self.fill(&circle, "#ffffff", 1.0, Transform::identity());
                let line = Stroke {
                    width: 1.8,
                    ..Stroke::default()
                };
                self.stroke(&circle, colour, &line)
            }
            Shape::Text {
                at,
                text,
                font,
                turned,
            } => {
                let (x, y) = (tenth(at.0), tenth(at.1));
                let path = self.fonts.path(text, font)?;
                let turn = if *turned { -90.0 } else { 0.0 };
                let place = Transform::from_translate(x, y).pre_rotate(turn);
                self.fill(&path, font.colour, 1.0, place)
            }
            Shape::BeginClip(area) => {
                let mut mask = Mask::new(self.pixels.width(), self.pixels.height())?;
                let scale = Transform::from_scale(SCALE, SCALE);
                mask.fill_path(&outline(area)?, FillRule::Winding, true, scale);
                self.clip = Some(mask);
                Some(())
            }
            Shape::EndClip => {
                self.clip = None;
                Some(())
            }
        }
    }

    fn fill(&mut self, path: &Path, fill: &str, opacity: f64, place: Transform) -> Option<()> {
        self.pixels.fill_path(
            path,
            &paint(fill, opacity)?,
            FillRule::Winding,
            place.post_scale(SCALE, SCALE),
            self.clip.as_ref(),
        );
        Some(())
    }

    fn stroke(&mut self, path: &Path, colour: &str, stroke: &Stroke) -> Option<()> {
        self.pixels.stroke_path(
            path,
            &paint(colour, 1.0)?,
            stroke,
            Transform::from_scale(SCALE, SCALE),
            self.clip.as_ref(),
        );
        Some(())
    }
}

/// Colour from `#rrggbb`.
fn paint(colour: &str, opacity: f64) -> Option<Paint<'static>> {
    let rgb = u32::from_str_radix(colour.strip_prefix('#')?, 16).ok()?;
    let [_, r, g, b] = rgb.to_be_bytes();
    let alpha = (opacity * 255.0).round() as u8;
    let mut paint = Paint::default();
    paint.set_color(Color::from_rgba8(r, g, b, alpha));
    Some(paint)
}

fn outline(&Rect { x, y, w, h }: &Rect) -> Option<Path> {
    let rect = tiny_skia::Rect::from_xywh(tenth(x), tenth(y), tenth(w), tenth(h))?;
    Some(PathBuilder::from_rect(rect))
}

/// Farthest coordinate: in pixels, the rasteriser's have 16 bits. The page is much smaller.
const FARTHEST: f64 = 32_000.0 / SCALE as f64;

/// A coordinate as the SVG has it.
fn tenth(px: f64) -> f32 {
    ((px * 10.0).round() / 10.0).clamp(-FARTHEST, FARTHEST) as f32
}
