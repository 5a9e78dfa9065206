//! The page itself.

use super::counts;
use crate::html::{Html, escape, unbroken};
use crate::paper::chart::Figure;
use crate::paper::claim::{Claim, Number};
use crate::paper::text::digits;

/// The whole page.
pub(super) fn page(claims: &[Claim]) -> String {
    let mut html = Html::page("The two-joint arm paper, recomputed");
    introduction(&mut html, claims);
    contents(&mut html, claims);
    for (index, claim) in claims.iter().enumerate() {
        section(&mut html, index + 1, claim);
    }
    numbers(&mut html, claims);
    html.finish()
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
    let name = figure.of_paper.unwrap_or("Not in the paper");
    let caption = format!("{name}. {}", figure.caption);
    html.figure(
        figure.name,
        &figure.drawing().svg(),
        &figure.caption,
        &caption,
    );
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
