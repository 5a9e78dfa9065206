//! HTML page of the report.

use maud::{Markup, html};

use super::counts;
use crate::chart::Figure;
use crate::claim::{Claim, Number};
use crate::text::digits;
use armbridge_analysis::html::{self, unbroken};

const TITLE: &str = "The two-joint arm paper, recomputed";

/// HTML text of the page.
pub(super) fn page(claims: &[Claim]) -> String {
    let contents = html! {
        (introduction(claims))
        (contents(claims))
        @for (claim, index) in claims.iter().zip(1..) { (section(index, claim)) }
        (numbers(claims))
    };
    html::page(TITLE, &contents)
}

fn introduction(claims: &[Claim]) -> Markup {
    html! {
        h1 { (TITLE) }
        p.lead {
            "“Detailed description of a two joint robot arm” describes an arm of two Dynamixel \
             AX-12A servos, its model, an LQR regulator and an observer. This page recomputes its \
             numbers and figures with the code that Armbridge runs on its board."
        }
        p { (counts(claims)) "." }
        p.note {
            "Everything here is simulated. No servo and no arm has been measured, and the \
             paper's measured curves are not available as data: where the paper compares its \
             model with its arm, a simulated arm is used instead, with encoder counts, integer PWM \
             and an assumed dry friction. Every figure and number comes from one run of armbridge "
            (env!("CARGO_PKG_VERSION")) "; each verdict follows from a comparison of its numbers \
             with the thresholds in the last table."
        }
    }
}

fn contents(claims: &[Claim]) -> Markup {
    let rows = html! {
        @for claim in claims {
            @let holding = claim.numbers().filter(|number| number.holds()).count();
            tr {
                td { (link(claim)) }
                td class={ "verdict " (claim.verdict().name()) } { (claim.verdict().words()) }
                td.n { (holding) " of " (claim.numbers().count()) }
            }
        }
        tr { td { a href="#numbers" { "All numbers" } } td {} td {} }
    };
    html! {
        nav {
            h2 { "Contents" }
            (html::table(&["Claim", "Verdict", "#Numbers that hold"], &rows))
        }
    }
}

/// Link to a claim's section.
fn link(claim: &Claim) -> Markup {
    html! { a href={ "#" (claim.id) } { (claim.title) } }
}

fn section(index: usize, claim: &Claim) -> Markup {
    let verdict = claim.verdict();
    let texts = [
        ("Paper", &claim.paper),
        ("Finding", &claim.finding),
        ("Explanation", &claim.explanation),
        ("Remedy", &claim.remedy),
    ];
    html! {
        section id=(claim.id) {
            h2 {
                span class={ "verdict " (verdict.name()) } { (verdict.words()) }
                (index) ". " (claim.title)
            }
            dl {
                @for (term, text) in texts {
                    dt { (term) }
                    dd { (unbroken(text)) }
                }
            }
            @for figure in &claim.figures { (self::figure(figure)) }
        }
    }
}

fn figure(figure: &Figure) -> Markup {
    let name = figure.paper_figure.unwrap_or("Not in the paper");
    let caption = format!("{name}. {}", figure.caption);
    html::figure(figure.name, &figure.drawing(), &figure.caption, &caption)
}

/// Table of the numbers of all claims.
fn numbers(claims: &[Claim]) -> Markup {
    let heads = ["Number", "#Found", "#Expected", "#Deviation", "Holds"];
    let rows = html! {
        @for claim in claims {
            @for (reading, numbers) in
                [("as printed", &claim.printed), ("our reading", &claim.reading)]
            {
                @if !numbers.is_empty() {
                    tr.group { th colspan="5" { (link(claim)) ", " (reading) } }
                }
                @for number in numbers { (row(number)) }
            }
        }
    };
    html! {
        section #numbers {
            h2 { "All numbers" }
            p {
                "A number holds if it meets the condition under “Expected”. A claim is reproduced \
                 if all its numbers hold; it is explained if a number “as printed” does not hold, \
                 but every number of “our reading” does; otherwise it is not reproduced. The \
                 deviation is the found value minus the expected value."
            }
            (html::table(&heads, &rows))
        }
    }
}

fn row(number: &Number) -> Markup {
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
    html! {
        tr {
            td { (number.quantity) }
            td.n { (digits(number.found, 6)) (space) (number.unit) }
            td.n { (number.rule.words()) }
            td.n { (deviation) }
            td class={ "verdict " (class) } { (holds) }
        }
    }
}
