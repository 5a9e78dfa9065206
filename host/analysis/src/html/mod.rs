//! Self-contained HTML pages: they include their style and drawings and need no network
//! access, which their security policy forbids. Their colours follow the screen's light or dark theme; they can be printed.

use std::path::{Path, PathBuf};

use armbridge_log::output_file::Existing;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::plot;
use crate::plot::PlotError;
use crate::plot::drawing::Drawing;
use crate::plot::panel::{ALARM, FOURTH, FRAME, GOOD, GRID, INK, JOINT, MUTED};

const STYLE: &str = include_str!("style.css");

/// Colours of the drawings on a light and on a dark page.
const DARK: [(&str, &str); 10] = [
    ("#ffffff", "#14191f"),
    (INK, "#e3e8ee"),
    (MUTED, "#9aa7b4"),
    (FRAME, "#5a6775"),
    (GRID, "#27303a"),
    (JOINT[0], "#5aa9e6"),
    (JOINT[1], "#ec8a4f"),
    (GOOD, "#4cc38f"),
    (ALARM, "#f08b92"),
    (FOURTH, "#bd94e0"),
];

/// HTML text of a page with a title.
pub fn page(title: &str, contents: &Markup) -> String {
    let dark = DARK.map(|(light, dark)| {
        format!("svg [fill=\"{light}\"]{{fill:{dark}}}svg [stroke=\"{light}\"]{{stroke:{dark}}}\n")
    });
    let dark = dark.concat();
    let style = format!("@media screen and (prefers-color-scheme: dark) {{\n{dark}}}");
    document(title, &style, &html! { main { (contents) } })
}

/// HTML text of a document with a style of its own beside that of all pages. Its security
/// policy forbids the network, and all scripts but those in the page.
pub(crate) fn document(title: &str, style: &str, body: &Markup) -> String {
    const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; \
                          script-src 'unsafe-inline'; img-src data:; base-uri 'none'; \
                          form-action 'none'";
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(style)) }
            }
            body { (body) }
        }
    };
    page.into_string()
}

/// Name of a page's file.
pub const PAGE_NAME: &str = "report.html";

/// Writes a page into an existing folder; returns its path.
///
/// # Errors
/// [`PlotError`] of the file that cannot be written.
pub fn write(folder: &Path, page: &str, existing: Existing) -> Result<PathBuf, PlotError> {
    plot::write(&folder.join(PAGE_NAME), page.as_bytes(), existing)
}

/// Table in a box that scrolls horizontally; a heading with `#` marks a column of numbers.
pub fn table(heads: &[&str], rows: &Markup) -> Markup {
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        @for head in heads {
                            th class=[class(head)] { (head.trim_start_matches('#')) }
                        }
                    }
                }
                tbody { (rows) }
            }
        }
    }
}

/// CSS class of a column's cells.
pub fn class(head: &str) -> Option<&'static str> {
    head.starts_with('#').then_some("n")
}

/// Drawing with a caption; `description` is its text alternative.
pub fn figure(name: &str, drawing: &Drawing, description: &str, caption: &str) -> Markup {
    let (width, height) = (drawing.width, drawing.height);
    html! {
        figure id=(name) {
            // The page's style sets the size.
            svg viewBox={ "0 0 " (width) " " (height) } role="img" aria-label=(description)
                font-family="Noto Sans, Helvetica, Arial, sans-serif" {
                (PreEscaped(drawing.svg_elements(&format!("{name}-"))))
            }
            figcaption { (unbroken(caption)) }
        }
    }
}

/// Replaces the spaces between numbers and units by no-break spaces.
pub fn unbroken(text: &str) -> String {
    const UNITS: [&str; 6] = ["mrad", "rad", "N m", "ms", "s", "%"];
    let mut text = text.to_owned();
    for unit in UNITS {
        let unbroken_unit = unit.replace(' ', "\u{a0}");
        for digit in '0'..='9' {
            text = text.replace(
                &format!("{digit} {unit}"),
                &format!("{digit}\u{a0}{unbroken_unit}"),
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::drawing::Rect;

    #[test]
    fn markup_in_text_is_text() {
        let page = page("a<b> & \"c\"", &html! {});
        assert!(
            page.contains("<title>a&lt;b&gt; &amp; &quot;c&quot;</title>"),
            "{page}"
        );
        assert_eq!(unbroken("at 0.5 N m it"), "at 0.5\u{a0}N\u{a0}m it");
    }

    #[test]
    fn a_drawing_keeps_its_size_and_gets_names_of_its_own() {
        let mut drawing = Drawing::new(9.0, 7.0);
        drawing.begin_clip(Rect {
            x: 1.0,
            y: 1.0,
            w: 2.0,
            h: 2.0,
        });
        let figure = figure("f", &drawing, "a & b", "").into_string();
        assert!(figure.contains("<svg viewBox=\"0 0 9 7\" "), "{figure}");
        assert!(
            figure.contains("id=\"f-c1\"") && figure.contains("a &amp; b"),
            "{figure}"
        );
    }
}
