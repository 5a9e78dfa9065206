//! The page itself.

use super::counts;
use crate::paper::chart::{Figure, PLACED};
use crate::paper::claim::{Claim, Number};
use crate::paper::text::digits;
use crate::plot::panel::{ALARM, FRAME, GOOD, GRID, INK, JOINT, MUTED};
use std::fmt::Write;

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
struct Html(String);

impl Html {
    /// Tags, as they are.
    fn tags(&mut self, tags: std::fmt::Arguments) {
        // Writing to a string cannot fail.
        let _ = self.0.write_fmt(tags);
        self.0.push('\n');
    }

    /// An element that holds text alone.
    fn element(&mut self, tag: &str, attributes: &str, text: &str) {
        let text = escape(text);
        self.tags(format_args!("<{tag}{attributes}>{text}</{tag}>"));
    }
}

/// Text for the inside of an element or an attribute.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// No line ends between a number and its unit.
fn unbroken(text: &str) -> String {
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

/// The whole page.
pub(super) fn page(claims: &[Claim]) -> String {
    let mut html = Html(String::with_capacity(1 << 19));
    html.tags(format_args!("<!DOCTYPE html>\n<html lang=\"en\">\n<head>"));
    html.tags(format_args!("<meta charset=\"utf-8\">"));
    html.tags(format_args!(
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
    ));
    html.element("title", "", "The two-joint arm paper, recomputed");
    html.tags(format_args!(
        "<style>\n{STYLE}{}</style>\n</head>\n<body>\n<main>",
        dark_drawings()
    ));
    introduction(&mut html, claims);
    contents(&mut html, claims);
    for (index, claim) in claims.iter().enumerate() {
        section(&mut html, index + 1, claim);
    }
    numbers(&mut html, claims);
    html.tags(format_args!("</main>\n</body>\n</html>"));
    html.0
}

fn introduction(html: &mut Html, claims: &[Claim]) {
    html.element("h1", "", "The two-joint arm paper, recomputed");
    html.element(
        "p",
        " class=\"lead\"",
        "“Detailed description of a two joint robot arm” describes an arm of two Dynamixel AX-12A \
         servos, its model, an LQR regulator and an observer. This page is what its numbers and \
         figures come to when they are computed again, by the code that Armbridge runs on its \
         board.",
    );
    html.element("p", "", &format!("{}.", counts(claims)));
    html.element(
        "p",
        " class=\"note\"",
        &format!(
            "Everything here is simulated. No servo and no arm has been measured, and the paper's \
             measured curves are not available as data: where it compares its model with its arm, \
             a simulated arm stands in, with encoder counts, integer PWM and an assumed dry \
             friction. Every figure and number comes from one run of armbridge {}; the verdicts \
             are computed by comparing the numbers with the thresholds in the last table.",
            env!("CARGO_PKG_VERSION")
        ),
    );
}

fn contents(html: &mut Html, claims: &[Claim]) {
    html.tags(format_args!("<nav>"));
    html.element("h2", "", "Contents");
    html.tags(format_args!("<div class=\"wide\"><table>"));
    html.tags(format_args!(
        "<thead><tr><th>Claim</th><th>Verdict</th><th class=\"n\">Numbers that hold</th></tr>\
         </thead>\n<tbody>"
    ));
    for claim in claims {
        let holding = claim.numbers().filter(|number| number.holds()).count();
        html.tags(format_args!(
            "<tr><td><a href=\"#{}\">{}</a></td><td class=\"verdict {}\">{}</td>\
             <td class=\"n\">{holding} of {}</td></tr>",
            claim.id,
            escape(claim.title),
            claim.verdict().name(),
            claim.verdict().words(),
            claim.numbers().count(),
        ));
    }
    html.tags(format_args!(
        "<tr><td><a href=\"#numbers\">All numbers</a></td><td></td><td></td></tr>\n</tbody>\
         </table></div>\n</nav>"
    ));
}

fn section(html: &mut Html, index: usize, claim: &Claim) {
    let verdict = claim.verdict();
    html.tags(format_args!(
        "<section id=\"{}\">\n<h2><span class=\"verdict {}\">{}</span>{index}. {}</h2>\n<dl>",
        claim.id,
        verdict.name(),
        verdict.words(),
        escape(claim.title),
    ));
    for (term, text) in [
        ("Paper says", &claim.paper),
        ("We find", &claim.find),
        ("Why", &claim.why),
        ("What mends it", &claim.mend),
    ] {
        html.element("dt", "", term);
        html.element("dd", "", &unbroken(text));
    }
    html.tags(format_args!("</dl>"));
    for figure in &claim.figures {
        self::figure(html, figure);
    }
    html.tags(format_args!("</section>"));
}

fn figure(html: &mut Html, figure: &Figure) {
    html.tags(format_args!("<figure id=\"{}\">", figure.name));
    html.0.push_str(&inline(figure));
    let name = figure.of_paper.unwrap_or("Not in the paper");
    let caption = format!("{name}. {}", figure.caption);
    html.element("figcaption", "", &unbroken(&caption));
    html.tags(format_args!("</figure>"));
}

/// The drawing as part of a page: its size is the page's business, and its
/// names must differ from those of the page's other drawings.
fn inline(figure: &Figure) -> String {
    let svg = figure.svg();
    let (width, height) = figure.size();
    let drawing = svg.split_once('>').map_or("", |(_, drawing)| drawing);
    let drawing = drawing
        .replace("id=\"c", &format!("id=\"{}-c", figure.name))
        .replace("url(#c", &format!("url(#{}-c", figure.name));
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\" \
         font-family=\"Noto Sans, Helvetica, Arial, sans-serif\">{drawing}",
        escape(&figure.caption)
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

/// Every number of every claim.
fn numbers(html: &mut Html, claims: &[Claim]) {
    html.tags(format_args!("<section id=\"numbers\">"));
    html.element("h2", "", "All numbers");
    html.element(
        "p",
        "",
        "A claim is reproduced when every number “as printed” holds; it is explained when those \
         do not and every number of “our reading” does; otherwise it is not reproduced. \
         Deviation is what is found less what is expected.",
    );
    html.tags(format_args!(
        "<div class=\"wide\"><table>\n<thead><tr><th>Number</th><th class=\"n\">Found</th>\
         <th class=\"n\">Expected</th><th class=\"n\">Deviation</th><th>Holds</th></tr></thead>\n\
         <tbody>"
    ));
    for claim in claims {
        for (reading, numbers) in [
            ("as printed", &claim.printed),
            ("our reading", &claim.reading),
        ] {
            if numbers.is_empty() {
                continue;
            }
            html.tags(format_args!(
                "<tr class=\"group\"><th colspan=\"5\"><a href=\"#{}\">{}</a>, {reading}</th></tr>",
                claim.id,
                escape(claim.title),
            ));
            for number in numbers {
                row(html, number);
            }
        }
    }
    html.tags(format_args!("</tbody></table></div>\n</section>"));
}

fn row(html: &mut Html, number: &Number) {
    let deviation = number.deviation().map_or_else(String::new, |deviation| {
        let sign = if deviation > 0.0 { "+" } else { "" };
        format!("{sign}{}", digits(deviation, 2))
    });
    let space = if number.unit.is_empty() { "" } else { " " };
    let (class, holds) = if number.holds() {
        ("reproduced", "yes")
    } else {
        ("not-reproduced", "no")
    };
    html.tags(format_args!(
        "<tr><td>{}</td><td class=\"n\">{}{space}{}</td><td class=\"n\">{}</td>\
         <td class=\"n\">{deviation}</td><td class=\"verdict {class}\">{holds}</td></tr>",
        escape(&number.what),
        digits(number.found, 6),
        number.unit,
        escape(&number.rule.words()),
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_text_is_text() {
        assert_eq!(escape("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
        assert_eq!(unbroken("at 0.5 N m it"), "at 0.5\u{a0}N\u{a0}m it");
    }
}
