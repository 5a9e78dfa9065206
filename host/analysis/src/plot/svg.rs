//! A small SVG writer: rectangles, polylines, dots and text.
//!
//! Plot libraries were weighed against this: what these figures need beyond
//! their common core (panels that share an axis, gaps where samples are
//! missing, dashes, marginal histograms, clipped bands) would have been drawn
//! by hand on top of them anyway, and one short file of elements is less to
//! keep than a library and its exceptions. Coordinates are px with one
//! decimal, which is finer than the PNG that is made of them.

use std::fmt::Write;

/// Fonts in order of preference; the first is the one PNGs are drawn with.
const FONTS: &str = "Noto Sans, Helvetica, Arial, sans-serif";

/// A rectangle in px; y grows downwards.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rect {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) w: f64,
    pub(crate) h: f64,
}

impl Rect {
    pub(crate) fn right(&self) -> f64 {
        self.x + self.w
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.y + self.h
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stroke {
    pub(crate) colour: &'static str,
    pub(crate) width: f64,
    /// Lengths of dash and gap; empty for a continuous line.
    pub(crate) dash: &'static str,
}

impl Stroke {
    pub(crate) const fn solid(colour: &'static str, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: "",
        }
    }
}

/// Which point of a text is at its coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text is set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Font {
    pub(crate) size: f64,
    pub(crate) bold: bool,
    pub(crate) colour: &'static str,
    pub(crate) anchor: Anchor,
}

impl Font {
    /// Width of a text in px, about: fonts differ, and none is asked.
    pub(crate) fn width(&self, text: &str) -> f64 {
        // Mean advance of Noto Sans over English text, in em.
        text.chars().count() as f64 * self.size * if self.bold { 0.60 } else { 0.555 }
    }
}

/// A drawing being made.
#[derive(Debug)]
pub(crate) struct Svg {
    body: String,
    clips: usize,
}

impl Svg {
    /// An empty drawing on white.
    pub(crate) fn new(width: f64, height: f64) -> Self {
        let mut svg = Self {
            body: String::with_capacity(1 << 17),
            clips: 0,
        };
        svg.put(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{FONTS}\">"
        ));
        svg.rect(
            Rect {
                x: 0.0,
                y: 0.0,
                w: width,
                h: height,
            },
            "#ffffff",
            1.0,
        );
        svg
    }

    /// Appends a line of SVG.
    fn put(&mut self, element: std::fmt::Arguments) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(element);
        self.body.push('\n');
    }

    /// A filled rectangle.
    pub(crate) fn rect(&mut self, Rect { x, y, w, h }: Rect, fill: &str, opacity: f64) {
        self.put(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" \
             fill=\"{fill}\" fill-opacity=\"{opacity}\"/>"
        ));
    }

    /// A straight line.
    pub(crate) fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        self.polyline(&[vec![from, to]], stroke);
    }

    /// Pieces of a curve, with gaps between them.
    pub(crate) fn polyline(&mut self, pieces: &[Vec<(f64, f64)>], stroke: Stroke) {
        let mut path = String::new();
        for piece in pieces {
            for (i, (x, y)) in piece.iter().enumerate() {
                let command = if i == 0 { "M" } else { " " };
                let _ = write!(path, "{command}{x:.1},{y:.1}");
            }
        }
        let Stroke {
            colour,
            width,
            dash,
        } = stroke;
        self.put(format_args!(
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
             stroke-dasharray=\"{dash}\" stroke-linejoin=\"round\"/>",
            dash = if dash.is_empty() { "none" } else { dash }
        ));
    }

    /// Round dots, as one path of strokes without length.
    pub(crate) fn dots(&mut self, centres: &[(f64, f64)], diameter: f64, colour: &str) {
        let mut path = String::new();
        for (x, y) in centres {
            let _ = write!(path, "M{x:.1},{y:.1}h.01");
        }
        self.put(format_args!(
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{diameter}\" \
             stroke-linecap=\"round\"/>"
        ));
    }

    /// An upright cross.
    pub(crate) fn cross(&mut self, (x, y): (f64, f64), stroke: Stroke) {
        const ARM: f64 = 7.0;
        let arms = [
            vec![(x - ARM, y), (x + ARM, y)],
            vec![(x, y - ARM), (x, y + ARM)],
        ];
        self.polyline(&arms, stroke);
    }

    /// A small ring, white inside.
    pub(crate) fn ring(&mut self, (x, y): (f64, f64), colour: &str) {
        self.put(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"#ffffff\" \
             stroke=\"{colour}\" stroke-width=\"1.8\"/>"
        ));
    }

    /// A text; `turned` reads from bottom to top.
    pub(crate) fn text(&mut self, (x, y): (f64, f64), text: &str, font: Font, turned: bool) {
        let Font {
            size,
            bold,
            colour,
            anchor,
        } = font;
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let turn = if turned {
            format!(" transform=\"rotate(-90 {x:.1} {y:.1})\"")
        } else {
            String::new()
        };
        let weight = if bold { " font-weight=\"bold\"" } else { "" };
        let text = text
            .replace('&', "&amp;")
            .replace('<', "&lt;")
            .replace('>', "&gt;");
        self.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{colour}\" \
             text-anchor=\"{anchor}\"{weight}{turn}>{text}</text>"
        ));
    }

    /// A text that begins here, on a light ground that keeps it legible over curves.
    pub(crate) fn note(&mut self, (x, y): (f64, f64), text: &str, font: Font) {
        let ground = Rect {
            x: x - 2.0,
            y: y - 0.95 * font.size,
            w: font.width(text) + 4.0,
            h: 1.3 * font.size,
        };
        self.rect(ground, "#ffffff", 0.8);
        self.text((x, y), text, font, false);
    }

    /// What is drawn next, up to [`end_clip`](Self::end_clip), shows only
    /// inside this rectangle.
    pub(crate) fn begin_clip(&mut self, Rect { x, y, w, h }: Rect) {
        self.clips += 1;
        let id = self.clips;
        self.put(format_args!(
            "<clipPath id=\"c{id}\"><rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" \
             height=\"{h:.1}\"/></clipPath><g clip-path=\"url(#c{id})\">"
        ));
    }

    /// Ends the clip begun last.
    pub(crate) fn end_clip(&mut self) {
        self.put(format_args!("</g>"));
    }

    /// The finished file.
    pub(crate) fn finish(mut self) -> String {
        self.body.push_str("</svg>\n");
        self.body
    }
}
