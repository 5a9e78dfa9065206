//! Outlines of text in Noto Sans, which is part of the program, so that figures do not
//! depend on installed fonts.

use tiny_skia::{Path, PathBuilder, Transform};
use ttf_parser::gpos::{PairAdjustment, PositioningSubtable};
use ttf_parser::{Face, FaceParsingError, GlyphId, OutlineBuilder, Tag};

use super::drawing::{Anchor, Font};

/// Fonts of the texts.
pub(super) struct Fonts {
    regular: Face<'static>,
    bold: Face<'static>,
}

impl Fonts {
    pub(super) fn load() -> Result<Self, FaceParsingError> {
        Ok(Self {
            regular: Face::parse(notosans::REGULAR_TTF, 0)?,
            bold: Face::parse(notosans::BOLD_TTF, 0)?,
        })
    }

    /// Path of a text in px relative to its anchor; `None` if it is invisible.
    pub(super) fn path(&self, text: &str, font: &Font) -> Option<Path> {
        let face = if font.bold { &self.bold } else { &self.regular };
        let scale = font.size as f32 / f32::from(face.units_per_em());
        let mut outline = Outline::default();
        let mut last = None;
        for letter in text.chars() {
            let glyph = face.glyph_index(letter).unwrap_or_default();
            let kerning = last.and_then(|last| kerning(face, last, glyph));
            outline.x += kerning.unwrap_or_default();
            // A glyph without an outline, such as a space, still has a width.
            face.outline_glyph(glyph, &mut outline);
            outline.x += f32::from(face.glyph_hor_advance(glyph).unwrap_or_default());
            last = Some(glyph);
        }
        let left = match font.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -outline.x / 2.0,
            Anchor::End => -outline.x,
        };
        // In fonts, y points upwards.
        let place = Transform::from_scale(scale, -scale).pre_translate(left, 0.0);
        outline.path.finish()?.transform(place)
    }
}

/// Kerning of two glyphs in font units.
fn kerning(face: &Face<'_>, left: GlyphId, right: GlyphId) -> Option<f32> {
    let table = face.tables().gpos?;
    let feature = table.features.find(Tag::from_bytes(b"kern"))?;
    let lookups = feature.lookup_indices.into_iter();
    let mut pairs = lookups
        .filter_map(|lookup| table.lookups.get(lookup))
        .flat_map(|lookup| lookup.subtables.into_iter::<PositioningSubtable>());
    let advance = |subtable| {
        let PositioningSubtable::Pair(pair) = subtable else {
            return None;
        };
        let index = pair.coverage().get(left)?;
        let (value, _) = match pair {
            PairAdjustment::Format1 { sets, .. } => sets.get(index)?.get(right)?,
            PairAdjustment::Format2 {
                classes, matrix, ..
            } => matrix.get((classes.0.get(left), classes.1.get(right)))?,
        };
        Some(f32::from(value.x_advance))
    };
    pairs.find_map(advance)
}

/// Outline of a line of glyphs, in font units.
#[derive(Default)]
struct Outline {
    path: PathBuilder,
    /// Start of the next glyph.
    x: f32,
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(self.x + x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(self.x + x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.path.quad_to(self.x + x1, y1, self.x + x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let left = self.x;
        self.path
            .cubic_to(left + x1, y1, left + x2, y2, left + x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}
