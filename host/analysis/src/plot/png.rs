//! PNG from the very SVG that was written, so that there is one drawing.
//!
//! Texts are set in Noto Sans, which is part of the program: a machine without
//! any fonts draws the same picture.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb::Database};
use std::sync::Arc;

/// Pixels of the PNG per px of the drawing, for sharp screens and print.
const SCALE: f32 = 2.0;

/// The fonts that texts are set in.
pub(super) fn fonts() -> Arc<Database> {
    let mut fonts = Database::new();
    fonts.load_font_data(notosans::REGULAR_TTF.to_vec());
    fonts.load_font_data(notosans::BOLD_TTF.to_vec());
    Arc::new(fonts)
}

/// Draws an SVG; the error says what it does not like about it.
pub(super) fn png(svg: &str, fonts: Arc<Database>) -> Result<Vec<u8>, String> {
    let options = Options {
        fontdb: fonts,
        font_family: "Noto Sans".to_owned(),
        ..Options::default()
    };
    let tree = Tree::from_str(svg, &options).map_err(|e| e.to_string())?;
    let size = tree.size().to_int_size().scale_by(SCALE).ok_or("no size")?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("no size")?;
    resvg::render(
        &tree,
        Transform::from_scale(SCALE, SCALE),
        &mut pixels.as_mut(),
    );
    pixels.encode_png().map_err(|e| e.to_string())
}
