//! The report: `report.html` and each figure as SVG and PNG, in one folder.
//!
//! The page is self-contained: it includes its style and drawings and needs no network
//! access. [`table`] is a summary for a terminal.

mod page;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use armbridge_log::output_file::Existing;

use super::claim::{Claim, Verdict};
use armbridge_analysis::plot::PlotError;
use armbridge_analysis::{html, plot};

/// Writes the page and its figures into an existing folder; returns the page's path.
///
/// # Errors
///
/// If a file cannot be written or a drawing cannot be rendered.
pub fn write(folder: &Path, claims: &[Claim]) -> Result<PathBuf, PlotError> {
    let figures = claims.iter().flat_map(|claim| &claim.figures);
    plot::write_all(
        folder,
        figures.map(|figure| (figure.name, figure.drawing())),
    )?;
    html::write(folder, &page::page(claims), Existing::Number)
}

/// Number of claims with a verdict.
fn count(claims: &[Claim], verdict: Verdict) -> usize {
    claims.iter().filter(|c| c.verdict() == verdict).count()
}

/// Text table of the claims and their verdicts.
pub fn table(claims: &[Claim]) -> String {
    let width = claims.iter().map(|claim| claim.title.chars().count());
    let width = width.max().unwrap_or(0);
    let mut text = String::new();
    for claim in claims {
        let holding = claim.numbers().filter(|number| number.holds()).count();
        let all = claim.numbers().count();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:width$}  {:28}  {holding:>2} of {all:>2} numbers",
            claim.title,
            claim.verdict().words()
        );
    }
    text.push_str(&counts(claims));
    text
}

/// Count of each verdict, in a line.
fn counts(claims: &[Claim]) -> String {
    let counts = [
        Verdict::Reproduced,
        Verdict::Explained,
        Verdict::NotReproduced,
    ]
    .map(|verdict| format!("{} {}", count(claims, verdict), verdict.words()));
    format!("{} claims: {}", claims.len(), counts.join("; "))
}
