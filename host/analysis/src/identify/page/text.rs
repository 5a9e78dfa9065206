//! The page itself.

use armbridge_shared::JOINTS;
use armbridge_shared::link::message::Setup;

use super::super::checks::Checks;
use super::super::diagnose::Diagnosis;
use super::super::forecast::Forecast;
use super::super::quantity::Quantity;
use super::super::report::{self, Number};
use super::{Page, Picture};
use crate::html::{Html, escape};

const TITLE: &str = "What this arm is";

/// The whole page.
pub(super) fn page(page: &Page<'_>, pictures: &[Picture]) -> String {
    let mut html = Html::page(TITLE);
    introduction(&mut html, page);
    warnings(&mut html, page.checks);
    numbers(&mut html, &page.report.numbers);
    untold(&mut html, page.checks);
    forecasts(&mut html, page);
    for (heading, prefix) in [
        ("Measured against computed", "windows"),
        ("What is left", "residuals"),
        ("Friction", "friction"),
        ("Correlations", "correlations"),
    ] {
        html.element("h2", "", heading);
        if prefix == "friction" {
            dry(&mut html, page.checks);
        }
        for picture in pictures
            .iter()
            .filter(|picture| picture.name.starts_with(prefix))
        {
            html.figure(
                picture.name,
                &picture.drawing.svg(),
                heading,
                picture.caption,
            );
        }
        if prefix == "correlations" {
            pairs(&mut html, page.checks);
        }
    }
    forms(&mut html, page.checks);
    as_the_paper_did(&mut html, page);
    method(&mut html);
    html.finish()
}

fn introduction(html: &mut Html, page: &Page<'_>) {
    let report = page.report;
    html.element("h1", "", TITLE);
    html.element(
        "p",
        " class=\"lead\"",
        &format!(
            "Found in {:.1} s in which a joint slides, {} windows, {} of them not explained. \
             Errors are {:.2} counts; one count of noise, rounded, makes 1.04.",
            report.sliding_s, report.windows, report.odd, report.noise_counts
        ),
    );
    logs(html, page.logs);
}

fn logs(html: &mut Html, logs: &[String]) {
    for (log, index) in logs.iter().zip(1..) {
        html.element("p", " class=\"note\"", &format!("Log {index}: {log}"));
    }
}

/// A page that says why there are no numbers.
pub(super) fn no_numbers(diagnosis: &Diagnosis, of: &[String]) -> String {
    let mut html = Html::page(TITLE);
    html.element("h1", "", TITLE);
    html.element("p", " class=\"lead\"", "These logs do not tell.");
    html.element("p", "", &format!("No numbers: {diagnosis}"));
    logs(&mut html, of);
    html.finish()
}

fn warnings(html: &mut Html, checks: &Checks) {
    html.element("h2", "", "What to keep in mind");
    if checks.warnings.is_empty() {
        let text = "Nothing: errors are as good as noise, the model has the right form, and the \
                    logs are explained.";
        html.element("p", "", text);
    }
    list(html, checks.warnings.iter().map(String::as_str));
}

fn list<'a>(html: &mut Html, items: impl Iterator<Item = &'a str>) {
    html.tags(format_args!("<ul>"));
    for item in items {
        html.element("li", "", item);
    }
    html.tags(format_args!("</ul>"));
}

/// A table; columns whose head begins with `#` are numbers.
fn table(html: &mut Html, heads: &[&str], rows: impl Iterator<Item = Vec<String>>) {
    let class = |column: usize| {
        let is_number = heads.get(column).is_some_and(|head| head.starts_with('#'));
        if is_number { " class=\"n\"" } else { "" }
    };
    html.tags(format_args!("<div class=\"wide\"><table>\n<thead><tr>"));
    for (column, head) in heads.iter().enumerate() {
        html.element("th", class(column), head.trim_start_matches('#'));
    }
    html.tags(format_args!("</tr></thead>\n<tbody>"));
    for row in rows {
        html.tags(format_args!("<tr>"));
        for (column, cell) in row.iter().enumerate() {
            html.tags(format_args!("<td{}>{}</td>", class(column), escape(cell)));
        }
        html.tags(format_args!("</tr>"));
    }
    html.tags(format_args!("</tbody></table></div>"));
}

fn numbers(html: &mut Html, numbers: &[Number]) {
    html.element("h2", "", "Numbers");
    html.element(
        "p",
        "",
        "Each with its interval of 95 %, and what the board computed with before.",
    );
    let heads = [
        "Joint",
        "Number",
        "#Found",
        "#Within (95 %)",
        "Unit",
        "#Before",
        "Remark",
    ];
    table(html, &heads, numbers.iter().map(Number::cells));
}

fn untold(html: &mut Html, checks: &Checks) {
    html.element("h2", "", "What is not known, and what settled it");
    let combinations = if checks.untold.is_empty() {
        "There is no combination of numbers that these logs leave open."
    } else {
        "These combinations of numbers change nothing in these logs, or hardly anything: what \
         was told of the arm beforehand, not its motion, says where they are."
    };
    html.element("p", "", combinations);
    html.element(
        "p",
        "",
        "Nor does any motion tell which way of a joint is the positive one: the arm is its own \
         mirror image. That a higher PWM turns a joint to higher counts is checked; whether \
         these are larger angles is what armbridge calibrate was told.",
    );
    let heads = ["Not told by these logs", "Settled by", "#By the logs alone"];
    let rows = checks.untold.iter().map(|untold| {
        let deviation = if untold.deviation > 10.0 {
            "anything".into()
        } else {
            format!("± {:.0} % of what was believed", 100.0 * untold.deviation)
        };
        vec![untold.what.clone(), untold.settled_by.clone(), deviation]
    });
    if !checks.untold.is_empty() {
        table(html, &heads, rows);
    }
}

fn forecasts(html: &mut Html, page: &Page<'_>) {
    html.element("h2", "", "Forecasts");
    let Some(forecasts) = page.forecasts else {
        let text = "Not tried: a second fit without the last fifth of the windows would take a \
                    while. Give another log as --held-out.";
        html.element("p", "", text);
        return;
    };
    html.element(
        "p",
        "",
        &format!(
            "Of {}. Errors are in counts, root mean square, with the encoder's noise and \
             without. Rms: the start of each window is sought in all of it. Forecast: in its \
             first quarter of a second alone, and judged until what is not known of that start \
             comes to a count (a count off), which an arm that stands brings about with its \
             unstable pole, whose time constant is told.",
            page.held_out
        ),
    );
    table(
        html,
        &Forecast::HEADS,
        forecasts.iter().map(|forecast| forecast.cells().to_vec()),
    );
}

fn dry(html: &mut Html, checks: &Checks) {
    list_of(
        html,
        checks.dry.iter().map(|dry| {
            let [with, without] = dry.viscous;
            let [rms, rms_without] = dry.rms_counts;
            format!(
                "Joint {}: viscous friction is {with:.3} N m s/rad beside dry friction. Without dry \
             friction in the model, all numbers sought anew, it would be {without:.3}, with errors of {rms_without:.2} \
             counts instead of {rms:.2} (worse by {:.0} variances).",
                dry.joint, dry.worse
            )
        }),
    );
}

/// The paper's numbers beside those of this arm, and what its method would make of these
/// logs.
fn as_the_paper_did(html: &mut Html, page: &Page<'_>) {
    html.element("h2", "", "As the paper did it");
    html.element(
        "p",
        "",
        "The paper fitted one joint at a time, by eye, with viscous friction alone: 0.421 N m s/rad \
         to a free fall, 0.239 to a constant input, of the same joint 1. Dry friction is behind \
         both, see armbridge identify paper. Without dry friction in the model these logs \
         would make of this arm:",
    );
    list_of(
        html,
        page.checks.dry.iter().map(|dry| {
            let [with, without] = dry.viscous;
            let joint = dry.joint;
            format!("Joint {joint}: {without:.3} N m s/rad in place of {with:.3}.")
        }),
    );
    let heads = ["Joint", "Number", "#The paper's arm", "#This arm", "Unit"];
    let paper = Setup::default();
    let rows = (0..JOINTS).flat_map(|joint| {
        let told = [
            Quantity::Inertia,
            Quantity::Gravity,
            Quantity::Viscous,
            Quantity::Gain,
            Quantity::Offset,
        ];
        told.map(|quantity| {
            let (value, error) = page.found.number(joint, quantity);
            let digits = |value| report::digits(value, error);
            vec![
                (joint + 1).to_string(),
                quantity.name().to_owned(),
                digits(quantity.of(&paper, joint)),
                digits(value),
                quantity.unit().to_owned(),
            ]
        })
    });
    table(html, &heads, rows);
}

fn list_of(html: &mut Html, items: impl Iterator<Item = String>) {
    let items: Vec<String> = items.collect();
    list(html, items.iter().map(String::as_str));
}

fn pairs(html: &mut Html, checks: &Checks) {
    if checks.pairs.is_empty() {
        html.element("p", "", "No two numbers are correlated by more than 0.9.");
        return;
    }
    let heads = ["Number", "And", "#Correlation"];
    let rows = checks.pairs.iter().map(|pair| {
        let correlation = format!("{:+.3}", pair.correlation).replace('-', "−");
        vec![pair.one.clone(), pair.other.clone(), correlation]
    });
    table(html, &heads, rows);
}

fn forms(html: &mut Html, checks: &Checks) {
    html.element("h2", "", "Has the model the right form?");
    html.element(
        "p",
        "",
        "Torques that the model has not, tried one by one. By chance the sum of squares falls by \
         about one variance; by more than 25 it does not.",
    );
    let heads = [
        "Joint",
        "Torque that the model has not",
        "#Better by",
        "#Torque at most",
    ];
    let rows = checks.forms.iter().map(|form| {
        vec![
            form.joint.to_string(),
            form.what.to_owned(),
            format!("{:.1}", form.improvement),
            format!("{:.4} N m", form.torque_nm),
        ]
    });
    table(html, &heads, rows);
}

fn method(html: &mut Html) {
    html.element("h2", "", "How it was found");
    html.element(
        "p",
        "",
        "In windows in which a joint slides its motion is computed from the PWM that was \
         sent, tick by tick, and compared with the encoder; the numbers are those that make the \
         sum of squares least, together with what was believed beforehand. Intervals are those \
         of the curvature there, made wider where windows disagree by more than noise.",
    );
}
