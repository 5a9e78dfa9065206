//! Drawings as SVG.
//!
//! Coordinates are px with one decimal, which is finer than the PNG.

use std::fmt::{Result, Write};

use super::drawing::{Anchor, Drawing, Rect, Shape};

/// Fonts in order of preference; PNGs use the first.
const FONTS: &str = "Noto Sans, Helvetica, Arial, sans-serif";

impl Drawing {
    /// The SVG file.
    pub(crate) fn svg(&self) -> String {
        let (width, height) = (self.width, self.height);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{FONTS}\">\n{}</svg>\n",
            self.svg_elements("")
        )
    }

    /// SVG elements, one per line; names of clips begin with `name`.
    pub(crate) fn svg_elements(&self, name: &str) -> String {
        let mut lines = String::with_capacity(1 << 17);
        let mut clips = 0;
        for shape in &self.shapes {
            if matches!(shape, Shape::BeginClip(_)) {
                clips += 1;
            }
            // Writing to a string cannot fail.
            let _ = element(&mut lines, shape, &format!("{name}c{clips}"));
        }
        lines
    }
}

/// A line of SVG; `clip` is the name of the latest clip.
fn element(file: &mut String, shape: &Shape, clip: &str) -> Result {
    match shape {
        Shape::Rect {
            area: Rect { x, y, w, h },
            fill,
            opacity,
        } => writeln!(
            file,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" \
             fill=\"{fill}\" fill-opacity=\"{opacity}\"/>"
        ),
        Shape::Polyline { pieces, stroke } => {
            write!(file, "<path d=\"")?;
            for piece in pieces {
                for (i, (x, y)) in piece.iter().enumerate() {
                    let command = if i == 0 { "M" } else { " " };
                    write!(file, "{command}{x:.1},{y:.1}")?;
                }
            }
            let dash: Vec<_> = stroke.dash.iter().map(f32::to_string).collect();
            writeln!(
                file,
                "\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" \
                 stroke-dasharray=\"{}\" stroke-linejoin=\"round\"/>",
                stroke.colour,
                stroke.width,
                if dash.is_empty() {
                    "none".to_owned()
                } else {
                    dash.join(" ")
                }
            )
        }
        Shape::Dots {
            centres,
            diameter,
            colour,
        } => {
            // One path of zero-length strokes.
            write!(file, "<path d=\"")?;
            for (x, y) in centres {
                write!(file, "M{x:.1},{y:.1}h.01")?;
            }
            writeln!(
                file,
                "\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{diameter}\" \
                 stroke-linecap=\"round\"/>"
            )
        }
        Shape::Ring {
            centre: (x, y),
            colour,
        } => writeln!(
            file,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"#ffffff\" \
             stroke=\"{colour}\" stroke-width=\"1.8\"/>"
        ),
        Shape::Text {
            at: (x, y),
            text,
            font,
            turned,
        } => {
            let anchor = match font.anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            write!(
                file,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{}\" fill=\"{}\" \
                 text-anchor=\"{anchor}\"",
                font.size, font.colour
            )?;
            if font.bold {
                write!(file, " font-weight=\"bold\"")?;
            }
            if *turned {
                write!(file, " transform=\"rotate(-90 {x:.1} {y:.1})\"")?;
            }
            let text = text
                .replace('&', "&amp;")
                .replace('<', "&lt;")
                .replace('>', "&gt;");
            writeln!(file, ">{text}</text>")
        }
        Shape::BeginClip(Rect { x, y, w, h }) => writeln!(
            file,
            "<clipPath id=\"{clip}\"><rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" \
             height=\"{h:.1}\"/></clipPath><g clip-path=\"url(#{clip})\">"
        ),
        Shape::EndClip => writeln!(file, "</g>"),
    }
}
