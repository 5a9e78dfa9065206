//! Text of the report.

use armbridge_link::message::Setup;
use maud::{Markup, html};

use super::super::checks::Checks;
use super::super::diagnose::Diagnosis;
use super::super::forecast::Forecast;
use super::super::quantity::Quantity;
use super::super::report::{self, Estimate};
use super::{Figure, Page};
use crate::html;

const TITLE: &str = "Identified arm";

/// The page of a fit.
pub(super) fn page(page: &Page<'_>, figures: &[Figure]) -> String {
    let checks = page.checks;
    let sections = [
        ("Measured and computed motion", "windows"),
        ("Residuals", "residuals"),
        ("Friction", "friction"),
        ("Correlations", "correlations"),
    ];
    let contents = html! {
        (introduction(page))
        (warnings(page))
        (parameters(&page.report.estimates))
        (unidentifiable(checks))
        (forecasts(page))
        @for (heading, prefix) in sections {
            h2 { (heading) }
            @if prefix == "friction" { (without_dry_friction(checks)) }
            @for figure in figures.iter().filter(|figure| figure.name.starts_with(prefix)) {
                (html::figure(figure.name, &figure.drawing, heading, figure.caption))
            }
        }
        (correlations(checks))
        (missing_torques(checks))
        (paper_method(page))
        (method())
    };
    html::page(TITLE, &contents)
}

/// The page of logs that identify no arm.
pub(super) fn diagnosis(diagnosis: &Diagnosis, logs: &[String]) -> String {
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
    let summary = format!(
        "Fitted to {:.1} s in which a joint slides: {} windows, {} of them rejected. The residual \
         is {:.2} counts; encoder noise of one count, rounded, gives 1.04.",
        report.sliding_s, report.windows, report.outliers, report.noise_counts
    );
    html! {
        h1 { (TITLE) }
        p.lead { (summary) }
        (logs(page.logs))
    }
}

fn logs(logs: &[String]) -> Markup {
    html! {
        @for (log, index) in logs.iter().zip(1..) { p.note { "Log " (index) ": " (log) } }
    }
}

fn warnings(page: &Page<'_>) -> Markup {
    let (checks, report) = (page.checks, page.report);
    let rest = without_warning(report.outliers, report.windows);
    html! {
        h2 { "Warnings" }
        @if checks.warnings.is_empty() {
            p {
                "None: the residual is white noise, the model lacks no torque, and " (rest) "."
            }
        }
        (list(&checks.warnings))
    }
}

/// Remarks on the windows where there is no warning.
fn without_warning(outliers: usize, windows: usize) -> String {
    match outliers {
        0 => "all windows are explained".into(),
        outliers => {
            format!("{outliers} of {windows} windows are rejected, too few for a warning")
        }
    }
}

fn list(items: impl IntoIterator<Item = impl AsRef<str>>) -> Markup {
    html! {
        ul { @for item in items { li { (item.as_ref()) } } }
    }
}

/// A table of text; columns whose heading begins with `#` are numbers.
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

fn parameters(parameters: &[Estimate]) -> Markup {
    let heads = [
        "Joint",
        "Parameter",
        "#Estimate",
        "#95 % interval",
        "Unit",
        "#Prior",
        "Remark",
    ];
    html! {
        h2 { "Parameters" }
        p { "Estimates with 95 % confidence intervals, and their prior: the board's values." }
        (table(&heads, parameters.iter().map(Estimate::cells)))
    }
}

fn unidentifiable(checks: &Checks) -> Markup {
    let heads = [
        "Not identifiable from these logs",
        "Fixed by",
        "#By the logs alone",
    ];
    let rows = checks.unidentifiable.iter().map(|combination| {
        let deviation = if combination.deviation > 10.0 {
            "unbounded".into()
        } else {
            format!("± {:.0} % of the prior", 100.0 * combination.deviation)
        };
        [
            combination.description.clone(),
            combination.fixed_by.clone(),
            deviation,
        ]
    });
    html! {
        h2 { "Identifiability" }
        p {
            @if checks.unidentifiable.is_empty() {
                "These logs identify every combination of parameters."
            } @else {
                "The likelihood is flat, or nearly so, along these combinations of parameters: \
                 the prior fixes them, not the motion."
            }
        }
        p {
            "No motion identifies a joint's positive direction: the arm is its own mirror image. \
             The fit checks that a higher PWM turns a joint to higher counts; that higher counts \
             are larger angles comes from armbridge calibrate."
        }
        @if !checks.unidentifiable.is_empty() { (table(&heads, rows)) }
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

fn without_dry_friction(checks: &Checks) -> Markup {
    list(checks.without_dry_friction.iter().map(|fit| {
        let [with, without] = fit.viscous_nm_s_rad;
        let [rms, rms_without] = fit.rms_counts;
        format!(
            "Joint {}: viscous friction is {with:.3} N m s/rad in a model with dry friction. \
             Fitted without dry friction it is {without:.3}, with a residual of \
             {rms_without:.2} counts instead of {rms:.2} (sum of squares higher by {:.0} \
             variances).",
            fit.joint, fit.loss_increase
        )
    }))
}

/// The paper's parameters beside those of this arm, and its method applied to these logs.
fn paper_method(page: &Page<'_>) -> Markup {
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
    let rows =
        (0..page.known.joints).flat_map(|joint| quantities.map(|quantity| (joint, quantity)));
    let rows = rows.map(|(joint, quantity)| {
        let (value, error) = page.fit.estimate(joint, quantity);
        [
            (joint + 1).to_string(),
            quantity.name().to_owned(),
            report::digits(quantity.nominal(&paper, joint), error),
            report::digits(value, error),
            quantity.unit().to_owned(),
        ]
    });
    let viscous = page.checks.without_dry_friction.iter().map(|fit| {
        let [with, without] = fit.viscous_nm_s_rad;
        let joint = fit.joint;
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

fn correlations(checks: &Checks) -> Markup {
    if checks.correlations.is_empty() {
        return html! { p { "No two parameters are correlated by more than 0.9." } };
    }
    let rows = checks.correlations.iter().map(|correlation| {
        let coefficient = format!("{:+.3}", correlation.coefficient).replace('-', "−");
        [
            correlation.first.clone(),
            correlation.second.clone(),
            coefficient,
        ]
    });
    table(&["Parameter", "Parameter", "#Correlation"], rows)
}

fn missing_torques(checks: &Checks) -> Markup {
    let heads = [
        "Joint",
        "Torque that the model lacks",
        "#Reduction",
        "#Largest torque",
    ];
    let rows = checks.missing_torques.iter().map(|missing| {
        [
            missing.joint.to_string(),
            missing.description.to_owned(),
            format!("{:.1}", missing.improvement),
            format!("{:.4} N m", missing.torque_nm),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejected_windows_are_not_called_explained() {
        assert_eq!(without_warning(0, 109), "all windows are explained");
        let text = without_warning(2, 109);
        assert_eq!(text, "2 of 109 windows are rejected, too few for a warning");
    }
}
