//! Pages that stand alone: their style and their drawings are in them, and they ask
//! nothing of a network. Light or dark, as the reader's screen is, and fit for print.

use std::path::{Path, PathBuf};

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::plot;
use crate::plot::PlotError;
use crate::plot::drawing::Drawing;
use crate::plot::panel::{ALARM, FOURTH, FRAME, GOOD, GRID, INK, JOINT, MUTED};

const STYLE: &str = include_str!("style.css");

/// Colours of the drawings that a dark page turns round.
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

/// A whole page of this title.
pub(crate) fn page(title: &str, contents: &Markup) -> String {
    let dark = DARK.map(|(light, dark)| {
        format!("svg [fill=\"{light}\"]{{fill:{dark}}}svg [stroke=\"{light}\"]{{stroke:{dark}}}\n")
    });
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style {
                    (PreEscaped(STYLE))
                    "@media screen and (prefers-color-scheme: dark) {\n"
                    (PreEscaped(dark.concat()))
                    "}"
                }
            }
            body { main { (contents) } }
        }
    };
    page.into_string()
}

/// Writes a page into an existing folder, as `report.html`; returns its path.
pub(crate) fn write(folder: &Path, page: &str) -> Result<PathBuf, PlotError> {
    let path = folder.join("report.html");
    plot::write(&path, page.as_bytes())?;
    Ok(path)
}

/// A table in a box that scrolls sideways; columns whose head begins with `#` are numbers.
pub(crate) fn table(heads: &[&str], rows: &Markup) -> Markup {
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

/// The class of a column's cells.
pub(crate) fn class(head: &str) -> Option<&'static str> {
    head.starts_with('#').then_some("n")
}

/// A drawing with its caption; `shows` is for those who cannot see it.
pub(crate) fn figure(name: &str, drawing: &Drawing, shows: &str, caption: &str) -> Markup {
    let (width, height) = (drawing.width, drawing.height);
    html! {
        figure id=(name) {
            // Its size is the page's business.
            svg viewBox={ "0 0 " (width) " " (height) } role="img" aria-label=(shows)
                font-family="Noto Sans, Helvetica, Arial, sans-serif" {
                (PreEscaped(drawing.svg_elements(&format!("{name}-"))))
            }
            figcaption { (unbroken(caption)) }
        }
    }
}

/// No line ends between a number and its unit.
pub(crate) fn unbroken(text: &str) -> String {
    const UNITS: [&str; 6] = ["mrad", "rad", "N m", "ms", "s", "%"];
    let mut text = text.to_owned();
    for unit in UNITS {
        let whole = unit.replace(' ', "\u{a0}");
        for digit in '0'..='9' {
            text = text.replace(&format!("{digit} {unit}"), &format!("{digit}\u{a0}{whole}"));
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
