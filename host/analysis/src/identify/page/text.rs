//! The page itself.

use armbridge_shared::JOINTS;
use armbridge_shared::link::message::Setup;
use maud::{Markup, html};

use super::super::checks::Checks;
use super::super::diagnose::Diagnosis;
use super::super::forecast::Forecast;
use super::super::quantity::Quantity;
use super::super::report::{self, Number};
use super::{Page, Picture};
use crate::html;

const TITLE: &str = "What this arm is";

/// The whole page.
pub(super) fn page(page: &Page<'_>, pictures: &[Picture]) -> String {
    let checks = page.checks;
    let sections = [
        ("Measured against computed", "windows"),
        ("What is left", "residuals"),
        ("Friction", "friction"),
        ("Correlations", "correlations"),
    ];
    let contents = html! {
        (introduction(page))
        (warnings(checks))
        (numbers(&page.report.numbers))
        (untold(checks))
        (forecasts(page))
        @for (heading, prefix) in sections {
            h2 { (heading) }
            @if prefix == "friction" { (dry(checks)) }
            @for picture in pictures.iter().filter(|picture| picture.name.starts_with(prefix)) {
                (html::figure(picture.name, &picture.drawing, heading, picture.caption))
            }
        }
        (pairs(checks))
        (forms(checks))
        (as_the_paper_did(page))
        (method())
    };
    html::page(TITLE, &contents)
}

/// A page with the reason why there are no numbers.
pub(super) fn no_numbers(diagnosis: &Diagnosis, logs: &[String]) -> String {
    let contents = html! {
        h1 { (TITLE) }
        p.lead { "These logs do not tell." }
        p { "No numbers: " (diagnosis) }
        (self::logs(logs))
    };
    html::page(TITLE, &contents)
}

fn introduction(page: &Page<'_>) -> Markup {
    let report = page.report;
    let found = format!(
        "Found in {:.1} s in which a joint slides, {} windows, {} of them not explained. Errors \
         are {:.2} counts; one count of noise, rounded, makes 1.04.",
        report.sliding_s, report.windows, report.odd, report.noise_counts
    );
    html! {
        h1 { (TITLE) }
        p.lead { (found) }
        (logs(page.logs))
    }
}

fn logs(logs: &[String]) -> Markup {
    html! {
        @for (log, index) in logs.iter().zip(1..) { p.note { "Log " (index) ": " (log) } }
    }
}

fn warnings(checks: &Checks) -> Markup {
    html! {
        h2 { "What to keep in mind" }
        @if checks.warnings.is_empty() {
            p {
                "Nothing: errors are as good as noise, the model has the right form, and the logs \
                 are explained."
            }
        }
        (list(&checks.warnings))
    }
}

fn list(items: impl IntoIterator<Item = impl AsRef<str>>) -> Markup {
    html! {
        ul { @for item in items { li { (item.as_ref()) } } }
    }
}

/// A table of text; columns whose head begins with `#` are numbers.
fn table<R: IntoIterator<Item = String>>(
    heads: &[&str],
    rows: impl IntoIterator<Item = R>,
) -> Markup {
    let rows = html! {
        @for row in rows {
            tr {
                @for (cell, head) in row.into_iter().zip(heads) {
                    td class=[html::class(head)] { (cell) }
                }
            }
        }
    };
    html::table(heads, &rows)
}

fn numbers(numbers: &[Number]) -> Markup {
    let heads = [
        "Joint",
        "Number",
        "#Found",
        "#Within (95 %)",
        "Unit",
        "#Before",
        "Remark",
    ];
    html! {
        h2 { "Numbers" }
        p { "Each with its interval of 95 %, and what the board computed with before." }
        (table(&heads, numbers.iter().map(Number::cells)))
    }
}

fn untold(checks: &Checks) -> Markup {
    let heads = ["Not told by these logs", "Settled by", "#By the logs alone"];
    let rows = checks.untold.iter().map(|untold| {
        let deviation = if untold.deviation > 10.0 {
            "anything".into()
        } else {
            format!("± {:.0} % of what was believed", 100.0 * untold.deviation)
        };
        [untold.what.clone(), untold.settled_by.clone(), deviation]
    });
    html! {
        h2 { "What is not known, and what settled it" }
        p {
            @if checks.untold.is_empty() {
                "There is no combination of numbers that these logs leave open."
            } @else {
                "These combinations of numbers change nothing in these logs, or hardly anything: \
                 what was told of the arm beforehand, not its motion, says where they are."
            }
        }
        p {
            "Nor does any motion tell which way of a joint is the positive one: the arm is its \
             own mirror image. That a higher PWM turns a joint to higher counts is checked; \
             whether these are larger angles is what armbridge calibrate was told."
        }
        @if !checks.untold.is_empty() { (table(&heads, rows)) }
    }
}

fn forecasts(page: &Page<'_>) -> Markup {
    html! {
        h2 { "Forecasts" }
        @if let Some(forecasts) = page.forecasts {
            p {
                "Of " (page.held_out) ". Errors are in counts, root mean square, with the \
                 encoder's noise and without. Rms: the start of each window is sought in all of \
                 it. Forecast: in its first quarter of a second alone, and judged until what is \
                 not known of that start comes to a count (a count off), which an arm that stands \
                 brings about with its unstable pole, whose time constant is told."
            }
            (table(&Forecast::HEADS, forecasts.iter().map(Forecast::cells)))
        } @else {
            p {
                "Not tried: a second fit without the last fifth of the windows would take a \
                 while. Give another log as --held-out."
            }
        }
    }
}

fn dry(checks: &Checks) -> Markup {
    list(checks.dry.iter().map(|dry| {
        let [with, without] = dry.viscous;
        let [rms, rms_without] = dry.rms_counts;
        format!(
            "Joint {}: viscous friction is {with:.3} N m s/rad beside dry friction. Without dry \
             friction in the model, all numbers sought anew, it would be {without:.3}, with \
             errors of {rms_without:.2} counts instead of {rms:.2} (worse by {:.0} variances).",
            dry.joint, dry.worse
        )
    }))
}

/// The paper's numbers beside those of this arm, and what its method would make of these
/// logs.
fn as_the_paper_did(page: &Page<'_>) -> Markup {
    let heads = ["Joint", "Number", "#The paper's arm", "#This arm", "Unit"];
    let paper = Setup::default();
    let quantities = [
        Quantity::Inertia,
        Quantity::Gravity,
        Quantity::Viscous,
        Quantity::Gain,
        Quantity::Offset,
    ];
    let rows = (0..JOINTS).flat_map(|joint| quantities.map(|quantity| (joint, quantity)));
    let rows = rows.map(|(joint, quantity)| {
        let (value, error) = page.found.number(joint, quantity);
        [
            (joint + 1).to_string(),
            quantity.name().to_owned(),
            report::digits(quantity.of(&paper, joint), error),
            report::digits(value, error),
            quantity.unit().to_owned(),
        ]
    });
    let viscous = page.checks.dry.iter().map(|dry| {
        let [with, without] = dry.viscous;
        let joint = dry.joint;
        format!("Joint {joint}: {without:.3} N m s/rad in place of {with:.3}.")
    });
    html! {
        h2 { "As the paper did it" }
        p {
            "The paper fitted one joint at a time, by eye, with viscous friction alone: 0.421 N m \
             s/rad to a free fall, 0.239 to a constant input, of the same joint 1. Dry friction \
             is behind both, see armbridge identify paper. Without dry friction in the model \
             these logs would make of this arm:"
        }
        (list(viscous))
        (table(&heads, rows))
    }
}

fn pairs(checks: &Checks) -> Markup {
    if checks.pairs.is_empty() {
        return html! { p { "No two numbers are correlated by more than 0.9." } };
    }
    let rows = checks.pairs.iter().map(|pair| {
        let correlation = format!("{:+.3}", pair.correlation).replace('-', "−");
        [pair.one.clone(), pair.other.clone(), correlation]
    });
    table(&["Number", "And", "#Correlation"], rows)
}

fn forms(checks: &Checks) -> Markup {
    let heads = [
        "Joint",
        "Torque that the model has not",
        "#Better by",
        "#Torque at most",
    ];
    let rows = checks.forms.iter().map(|form| {
        [
            form.joint.to_string(),
            form.what.to_owned(),
            format!("{:.1}", form.improvement),
            format!("{:.4} N m", form.torque_nm),
        ]
    });
    html! {
        h2 { "Has the model the right form?" }
        p {
            "Torques that the model has not, tried one by one. By chance the sum of squares falls \
             by about one variance; by more than 25 it does not."
        }
        (table(&heads, rows))
    }
}

fn method() -> Markup {
    html! {
        h2 { "How it was found" }
        p {
            "In windows in which a joint slides its motion is computed from the PWM that was \
             sent, tick by tick, and compared with the encoder; the numbers are those that make \
             the sum of squares least, together with what was believed beforehand. Intervals are \
             those of the curvature there, made wider where windows disagree by more than noise."
        }
    }
}
