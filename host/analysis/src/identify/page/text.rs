//! Text of the report.

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

const TITLE: &str = "Identified arm";

/// The whole page.
pub(super) fn page(page: &Page<'_>, pictures: &[Picture]) -> String {
    let checks = page.checks;
    let sections = [
        ("Measured and computed motion", "windows"),
        ("Residuals", "residuals"),
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

/// The page of logs that identify no arm.
pub(super) fn no_numbers(diagnosis: &Diagnosis, logs: &[String]) -> String {
    let contents = html! {
        h1 { (TITLE) }
        p.lead { "These logs identify no arm." }
        p { (diagnosis) }
        (self::logs(logs))
    };
    html::page(TITLE, &contents)
}

fn introduction(page: &Page<'_>) -> Markup {
    let report = page.report;
    let found = format!(
        "Fitted to {:.1} s in which a joint slides: {} windows, {} of them rejected. The residual \
         is {:.2} counts; encoder noise of one count, rounded, gives 1.04.",
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
        h2 { "Warnings" }
        @if checks.warnings.is_empty() {
            p {
                "None: the residual is white noise, the model lacks no torque, and all windows are \
                 explained."
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
        "Parameter",
        "#Estimate",
        "#95 % interval",
        "Unit",
        "#Before",
        "Remark",
    ];
    html! {
        h2 { "Parameters" }
        p { "Estimates with 95 % confidence intervals, and the board's values before." }
        (table(&heads, numbers.iter().map(Number::cells)))
    }
}

fn untold(checks: &Checks) -> Markup {
    let heads = [
        "Not identifiable from these logs",
        "Fixed by",
        "#By the logs alone",
    ];
    let rows = checks.untold.iter().map(|untold| {
        let deviation = if untold.deviation > 10.0 {
            "unbounded".into()
        } else {
            format!("± {:.0} % of the prior", 100.0 * untold.deviation)
        };
        [untold.what.clone(), untold.settled_by.clone(), deviation]
    });
    html! {
        h2 { "Identifiability" }
        p {
            @if checks.untold.is_empty() {
                "These logs identify every combination of parameters."
            } @else {
                "The likelihood is flat, or nearly so, along these combinations of parameters: the \
                 prior fixes them, not the motion."
            }
        }
        p {
            "No motion identifies a joint's positive direction: the arm is its own mirror image. \
             The fit checks that a higher PWM turns a joint to higher counts; that higher counts \
             are larger angles comes from armbridge calibrate."
        }
        @if !checks.untold.is_empty() { (table(&heads, rows)) }
    }
}

fn forecasts(page: &Page<'_>) -> Markup {
    html! {
        h2 { "Holdout" }
        @if let Some(forecasts) = page.forecasts {
            p {
                "Validated on " (page.held_out) ". Errors are root mean squares in counts, with \
                 and without the encoder's noise. Rms: the initial state is fitted to the whole \
                 window. Forecast: it is fitted to the first quarter of a second alone, and the \
                 error counts until the uncertainty of that state reaches one count; a standing \
                 arm gets there by its unstable pole, whose time constant is given."
            }
            (table(&Forecast::HEADS, forecasts.iter().map(Forecast::cells)))
        } @else {
            p {
                "Skipped: the logs are too long for a second fit without the last fifth of the \
                 windows. Pass another log as --held-out."
            }
        }
    }
}

fn dry(checks: &Checks) -> Markup {
    list(checks.dry.iter().map(|dry| {
        let [with, without] = dry.viscous;
        let [rms, rms_without] = dry.rms_counts;
        format!(
            "Joint {}: viscous friction is {with:.3} N m s/rad in a model with dry friction. \
             Fitted without dry friction it is {without:.3}, with a residual of \
             {rms_without:.2} counts instead of {rms:.2} (sum of squares higher by {:.0} \
             variances).",
            dry.joint, dry.worse
        )
    }))
}

/// The paper's parameters beside those of this arm, and its method applied to these logs.
fn as_the_paper_did(page: &Page<'_>) -> Markup {
    let heads = [
        "Joint",
        "Parameter",
        "#The paper's arm",
        "#This arm",
        "Unit",
    ];
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
        h2 { "The paper's method" }
        p {
            "The paper fitted one joint at a time, by eye, with viscous friction alone: 0.421 N m \
             s/rad to a free fall, 0.239 to a constant input, of the same joint 1. Dry friction \
             explains both, see armbridge identify paper. Fitted without dry friction, these \
             logs give:"
        }
        (list(viscous))
        (table(&heads, rows))
    }
}

fn pairs(checks: &Checks) -> Markup {
    if checks.pairs.is_empty() {
        return html! { p { "No two parameters are correlated by more than 0.9." } };
    }
    let rows = checks.pairs.iter().map(|pair| {
        let correlation = format!("{:+.3}", pair.correlation).replace('-', "−");
        [pair.one.clone(), pair.other.clone(), correlation]
    });
    table(&["Parameter", "Parameter", "#Correlation"], rows)
}

fn forms(checks: &Checks) -> Markup {
    let heads = [
        "Joint",
        "Torque that the model lacks",
        "#Reduction",
        "#Largest torque",
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
        h2 { "Model errors" }
        p {
            "Torques that the model lacks, added one at a time. The reduction of the sum of \
             squares, in noise variances, is about 1 by chance and never above 25."
        }
        (table(&heads, rows))
    }
}

fn method() -> Markup {
    html! {
        h2 { "Method" }
        p {
            "In windows in which a joint slides, the motion is computed from the PWM that was \
             sent, tick by tick, and compared with the encoder. The estimate minimises the sum of \
             squared residuals and the prior's term. Intervals follow from the curvature at the \
             minimum, and are wider where windows disagree by more than noise."
        }
    }
}
