//! Drawings of rectangles, polylines, dots and text, before they are SVG or PNG.
//!
//! No plot library is used: these figures need panels that share an axis, gaps where
//! samples are missing, dashes, marginal histograms and clipped bands, which common
//! libraries lack, and one short file of shapes is less to maintain than a library and
//! its exceptions.

/// A rectangle in px; y grows downwards.
#[derive(Clone, Copy, Debug)]
pub struct Rect {
    /// Left edge, in pixels.
    pub x: f64,
    /// Top edge, in pixels.
    pub y: f64,
    /// Width in pixels.
    pub w: f64,
    /// Height in pixels.
    pub h: f64,
}

impl Rect {
    /// Rectangle of a figure's full width, between its y axis and its right edge.
    pub fn row(y: f64, h: f64) -> Self {
        Self {
            x: 84.0,
            y,
            w: 932.0,
            h,
        }
    }

    /// Right edge, in pixels.
    pub fn right(&self) -> f64 {
        self.x + self.w
    }

    /// Bottom edge, in pixels.
    pub fn bottom(&self) -> f64 {
        self.y + self.h
    }
}

/// Style of a line.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    /// CSS colour.
    pub colour: &'static str,
    /// Width in pixels.
    pub width: f64,
    /// Lengths of dash and gap; empty for a continuous line.
    pub dash: &'static [f32],
}

impl Stroke {
    /// A stroke without dashes.
    pub const fn solid(colour: &'static str, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: &[],
        }
    }
}

/// Anchor of a text at its coordinates.
#[derive(Clone, Copy, Debug)]
pub enum Anchor {
    /// The text begins at the point.
    Start,
    /// The text is centred on the point.
    Middle,
    /// The text ends at the point.
    End,
}

/// Style of a text.
#[derive(Clone, Copy, Debug)]
pub struct Font {
    /// Height in pixels.
    pub size: f64,
    /// Whether the weight is bold.
    pub bold: bool,
    /// CSS colour.
    pub colour: &'static str,
    /// Position relative to the point.
    pub anchor: Anchor,
}

impl Font {
    /// Approximate width of a text in px, without font metrics.
    pub fn width(&self, text: &str) -> f64 {
        // Mean advance of Noto Sans over English text, in em.
        text.chars().count() as f64 * self.size * if self.bold { 0.60 } else { 0.555 }
    }
}

/// A part of a drawing; coordinates and lengths are in px.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// A filled rectangle.
    Rect {
        area: Rect,
        fill: &'static str,
        opacity: f64,
    },
    /// Pieces of a curve, with gaps between them.
    Polyline {
        pieces: Vec<Vec<(f64, f64)>>,
        stroke: Stroke,
    },
    /// Round dots.
    Dots {
        centres: Vec<(f64, f64)>,
        diameter: f64,
        colour: &'static str,
    },
    /// A small ring, white inside.
    Ring {
        centre: (f64, f64),
        colour: &'static str,
    },
    /// A text; `turned` reads from bottom to top.
    Text {
        at: (f64, f64),
        text: String,
        font: Font,
        turned: bool,
    },
    /// Begins a clip: following shapes are visible only inside this rectangle.
    BeginClip(Rect),
    /// Ends the clip.
    EndClip,
}

/// Shapes, the first at the bottom.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// In px.
    pub width: f64,
    /// In px.
    pub height: f64,
    pub(super) shapes: Vec<Shape>,
}

impl Drawing {
    /// An empty drawing on white.
    pub fn new(width: f64, height: f64) -> Self {
        let mut drawing = Self {
            width,
            height,
            shapes: Vec::new(),
        };
        let page = Rect {
            x: 0.0,
            y: 0.0,
            w: width,
            h: height,
        };
        drawing.rect(page, "#ffffff", 1.0);
        drawing
    }

    /// A filled rectangle.
    pub(crate) fn rect(&mut self, area: Rect, fill: &'static str, opacity: f64) {
        self.shapes.push(Shape::Rect {
            area,
            fill,
            opacity,
        });
    }

    /// A straight line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        self.polyline(vec![vec![from, to]], stroke);
    }

    /// Pieces of a curve, with gaps between them.
    pub(crate) fn polyline(&mut self, pieces: Vec<Vec<(f64, f64)>>, stroke: Stroke) {
        self.shapes.push(Shape::Polyline { pieces, stroke });
    }

    /// Round dots.
    pub fn dots(&mut self, centres: Vec<(f64, f64)>, diameter: f64, colour: &'static str) {
        self.shapes.push(Shape::Dots {
            centres,
            diameter,
            colour,
        });
    }

    /// An upright cross.
    pub(crate) fn cross(&mut self, (x, y): (f64, f64), stroke: Stroke) {
        const ARM: f64 = 7.0;
        let arms = vec![
            vec![(x - ARM, y), (x + ARM, y)],
            vec![(x, y - ARM), (x, y + ARM)],
        ];
        self.polyline(arms, stroke);
    }

    /// A small ring, white inside.
    pub(crate) fn ring(&mut self, centre: (f64, f64), colour: &'static str) {
        self.shapes.push(Shape::Ring { centre, colour });
    }

    /// A text; `turned` reads from bottom to top.
    pub fn text(&mut self, at: (f64, f64), text: &str, font: Font, turned: bool) {
        self.shapes.push(Shape::Text {
            at,
            text: text.to_owned(),
            font,
            turned,
        });
    }

    /// Adds a text that begins at a point, on a light background that keeps it legible.
    pub fn note(&mut self, (x, y): (f64, f64), text: &str, font: Font) {
        let ground = Rect {
            x: x - 2.0,
            y: y - 0.95 * font.size,
            w: font.width(text) + 4.0,
            h: 1.3 * font.size,
        };
        self.rect(ground, "#ffffff", 0.8);
        self.text((x, y), text, font, false);
    }

    /// Limits the shapes up to [`end_clip`](Self::end_clip) to a rectangle. Clips do not
    /// nest.
    pub(crate) fn begin_clip(&mut self, area: Rect) {
        self.shapes.push(Shape::BeginClip(area));
    }

    /// Ends the clip.
    pub(crate) fn end_clip(&mut self) {
        self.shapes.push(Shape::EndClip);
    }
}
