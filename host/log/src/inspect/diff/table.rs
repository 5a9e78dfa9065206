//! Differences as text for a terminal.

use std::fmt::{Result, Write};

use super::{Diff, QuantityDiff};

impl Diff {
    /// As text, ending in a line feed.
    pub fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) -> Result {
        let [a, b] = &self.logs;
        writeln!(out, "A  {a}\nB  {b}\n")?;
        self.write_settings(out)?;
        self.write_commands(out)?;
        self.write_ticks(out)?;
        if self.is_same() {
            writeln!(out, "The same.")?;
        }
        Ok(())
    }

    fn write_settings(&self, out: &mut String) -> Result {
        let Some(settings) = &self.settings else {
            return writeln!(out, "settings   not in both logs");
        };
        if settings.is_empty() {
            return writeln!(out, "settings   the same");
        }
        writeln!(out, "settings   {} differ", settings.len())?;
        let width = settings.iter().map(|s| s.key.len()).max().unwrap_or(0);
        for differing in settings {
            let (key, [a, b]) = (differing.key, [0, 1].map(|at| differing.show(at)));
            writeln!(out, "  {key:<width$}  A {a}, B {b}")?;
        }
        Ok(())
    }

    fn write_commands(&self, out: &mut String) -> Result {
        let [a, b] = self.commands;
        let Some(first) = &self.first_command else {
            return writeln!(out, "commands   the same {a}");
        };
        writeln!(
            out,
            "commands   A {a}, B {b}; they differ first in the {}.:",
            first.place
        )?;
        for (name, command) in ["A", "B"].iter().zip(&first.commands) {
            let command = command.as_deref().unwrap_or("none");
            writeln!(out, "  {name} {command}")?;
        }
        Ok(())
    }

    fn write_ticks(&self, out: &mut String) -> Result {
        writeln!(
            out,
            "ticks      {} compared, from where the arm is first driven",
            self.ticks
        )?;
        let [a, b] = self.unmatched;
        if a + b > 0 {
            writeln!(out, "           {a} only in A, {b} only in B")?;
        }
        let Some(first) = &self.first_tick else {
            return writeln!(out, "outputs    the same in every tick");
        };
        let [a, b] = first.ticks;
        let columns = first.columns.join(", ");
        writeln!(
            out,
            "outputs    differ first {} ticks after that (tick {a} of A, {b} of B): {columns}\n",
            first.since_drive
        )?;
        writeln!(
            out,
            "{:<18}{:>14}{:>14}{:>10}  unit",
            "", "largest", "rms", "ticks"
        )?;
        for quantity in &self.quantities {
            let QuantityDiff {
                column,
                unit,
                max,
                rms,
                ticks,
            } = quantity;
            let show = |value: &Option<f64>| value.map_or_else(String::new, |v| format!("{v:.3e}"));
            let (max, rms) = (show(max), show(rms));
            writeln!(out, "{column:<18}{max:>14}{rms:>14}{ticks:>10}  {unit}")?;
        }
        Ok(())
    }
}
