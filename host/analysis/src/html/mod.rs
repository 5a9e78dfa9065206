//! Pages that stand alone: their style and their drawings are in them, and they ask
//! nothing of a network. Light or dark, as the reader's screen is, and fit for print.

use std::fmt::Write;

use crate::paper::chart::PLACED;
use crate::plot::panel::{ALARM, FRAME, GOOD, GRID, INK, JOINT, MUTED};

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
    (PLACED.colour, "#bd94e0"),
];

/// Markup being written. Text goes through [`escape`], tags do not.
pub(crate) struct Html(String);

impl Html {
    /// A page of this title, up to where its contents begin.
    pub(crate) fn page(title: &str) -> Self {
        let mut html = Self(String::with_capacity(1 << 19));
        html.tags(format_args!("<!DOCTYPE html>\n<html lang=\"en\">\n<head>"));
        html.tags(format_args!("<meta charset=\"utf-8\">"));
        html.tags(format_args!(
            "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
        ));
        html.element("title", "", title);
        html.tags(format_args!(
            "<style>\n{STYLE}{}</style>\n</head>\n<body>\n<main>",
            dark_drawings()
        ));
        html
    }

    /// The finished page.
    pub(crate) fn finish(mut self) -> String {
        self.tags(format_args!("</main>\n</body>\n</html>"));
        self.0
    }

    /// Tags, as they are.
    pub(crate) fn tags(&mut self, tags: std::fmt::Arguments) {
        // Writing to a string cannot fail.
        let _ = self.0.write_fmt(tags);
        self.0.push('\n');
    }

    /// An element that holds text alone.
    pub(crate) fn element(&mut self, tag: &str, attributes: &str, text: &str) {
        let text = escape(text);
        self.tags(format_args!("<{tag}{attributes}>{text}</{tag}>"));
    }

    /// A drawing with its caption; `shows` is for those who cannot see it.
    pub(crate) fn figure(&mut self, name: &str, svg: &str, shows: &str, caption: &str) {
        self.tags(format_args!("<figure id=\"{name}\">"));
        self.0.push_str(&inline(name, svg, shows));
        self.element("figcaption", "", &unbroken(caption));
        self.tags(format_args!("</figure>"));
    }
}

/// Text for the inside of an element or an attribute.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
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

/// The drawing as part of a page: its size is the page's business, and its
/// names must differ from those of the page's other drawings.
fn inline(name: &str, svg: &str, shows: &str) -> String {
    let (opening, drawing) = svg.split_once('>').unwrap_or_default();
    let size = opening
        .split_once("viewBox=\"")
        .map_or("", |(_, size)| size);
    let size = size.split_once('"').map_or("", |(size, _)| size);
    let drawing = drawing
        .replace("id=\"c", &format!("id=\"{name}-c"))
        .replace("url(#c", &format!("url(#{name}-c"));
    format!(
        "<svg viewBox=\"{size}\" role=\"img\" aria-label=\"{}\" \
         font-family=\"Noto Sans, Helvetica, Arial, sans-serif\">{drawing}",
        escape(shows)
    )
}

/// Drawings on a dark page.
fn dark_drawings() -> String {
    let mut css = String::from("@media screen and (prefers-color-scheme: dark) {\n");
    for (light, dark) in DARK {
        let _ = writeln!(
            css,
            "  svg [fill=\"{light}\"] {{ fill: {dark}; }}\n  \
             svg [stroke=\"{light}\"] {{ stroke: {dark}; }}"
        );
    }
    css.push_str("}\n");
    css
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_text_is_text() {
        assert_eq!(escape("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
        assert_eq!(unbroken("at 0.5 N m it"), "at 0.5\u{a0}N\u{a0}m it");
    }

    #[test]
    fn a_drawing_keeps_its_size_and_gets_names_of_its_own() {
        let svg = "<svg width=\"9\" viewBox=\"0 0 9 7\" font-family=\"x\"><g id=\"c1\"/></svg>";
        let inline = inline("f", svg, "a & b");
        assert!(inline.starts_with("<svg viewBox=\"0 0 9 7\" "), "{inline}");
        assert!(
            inline.contains("id=\"f-c1\"") && inline.contains("a &amp; b"),
            "{inline}"
        );
    }
}
