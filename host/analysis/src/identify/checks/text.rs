//! The checks of a fit as text for a terminal.

use std::fmt::Write;

use super::Checks;

impl Checks {
    /// What logs cannot tell and what is to be kept in mind, a line each.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for combination in &self.untold {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "not identifiable from these logs: {}; fixed by {}",
                combination.what, combination.settled_by
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

    /// Numbers that hang together by their pairs.
    fn groups(&self) -> Vec<Vec<&str>> {
        let mut groups: Vec<Vec<&str>> = Vec::new();
        for pair in &self.pairs {
            let (mut joined, others): (Vec<_>, Vec<_>) = groups.into_iter().partition(|group| {
                group.contains(&pair.one.as_str()) || group.contains(&pair.other.as_str())
            });
            joined.push(vec![&pair.one, &pair.other]);
            let mut group = joined.concat();
            group.sort_unstable();
            group.dedup();
            groups = others;
            groups.push(group);
        }
        groups
    }
}
