//! The checks of a fit as text for a terminal.

use std::fmt::Write;

use super::Checks;

impl Checks {
    /// Unidentifiable combinations, strong correlations and warnings, a line each.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for combination in &self.unidentifiable {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "not identifiable from these logs: {}; fixed by {}",
                combination.description, combination.fixed_by
            );
        }
        let groups = self.groups();
        for group in &groups {
            let _ = writeln!(
                text,
                "strongly correlated (above 0.9): {}",
                group.join(", ")
            );
        }
        for warning in &self.warnings {
            let _ = writeln!(text, "warning: {warning}");
        }
        text
    }

    /// Groups of parameters that strong correlations connect.
    fn groups(&self) -> Vec<Vec<&str>> {
        let mut groups: Vec<Vec<&str>> = Vec::new();
        for correlation in &self.correlations {
            let (mut joined, others): (Vec<_>, Vec<_>) = groups.into_iter().partition(|group| {
                group.contains(&correlation.first.as_str())
                    || group.contains(&correlation.second.as_str())
            });
            joined.push(vec![&correlation.first, &correlation.second]);
            let mut group = joined.concat();
            group.sort_unstable();
            group.dedup();
            groups = others;
            groups.push(group);
        }
        groups
    }
}
