//! Differences as text for a terminal.

use std::fmt::{Result, Write};

use armbridge_client::params;

use crate::text_table::{self, WIDTH};

use super::{Diff, QuantityDiff, RunDiff};

/// Letter of a run: A, B and so on.
fn letter(place: usize) -> char {
    let letters = ('A'..='Z').chain('a'..='z');
    letters.cycle().nth(place).unwrap_or('?')
}

impl Diff {
    /// As text, ending in a line feed.
    pub fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) -> Result {
        for (place, log) in self.logs.iter().enumerate() {
            writeln!(out, "{}  {log}", letter(place))?;
        }
        writeln!(out)?;
        self.write_settings(out)?;
        for (place, run) in self.runs.iter().enumerate() {
            let name = letter(place + 1);
            if self.runs.len() > 1 {
                writeln!(out, "\n{name} against A")?;
            }
            run.write_commands(out, name)?;
            run.write_ticks(out, name, self.aligned)?;
        }
        if self.is_same() {
            writeln!(out, "The same.")?;
        }
        Ok(())
    }

    fn write_settings(&self, out: &mut String) -> Result {
        let Some(settings) = &self.settings else {
            return writeln!(out, "settings   not in every log");
        };
        if settings.is_empty() {
            return writeln!(out, "settings   the same");
        }
        writeln!(out, "settings   {} differ", settings.len())?;
        for setting in settings {
            writeln!(out, "  {}", setting.key)?;
            for (place, value) in setting.values.iter().enumerate() {
                let show = |value| format!("{} {}", params::to_text(value), setting.unit);
                let text = value.as_ref().map_or_else(|| "-".to_owned(), show);
                writeln!(out, "    {}  {}", letter(place), text.trim_end())?;
            }
        }
        Ok(())
    }
}

impl RunDiff {
    fn write_commands(&self, out: &mut String, name: char) -> Result {
        let [a, b] = self.commands;
        let Some(first) = &self.first_command else {
            return writeln!(out, "commands   the same {a}");
        };
        let place = first.place;
        writeln!(
            out,
            "commands   A {a}, {name} {b}; number {place} is the first that differs:"
        )?;
        if !first.settings.is_empty() {
            let verb = first.commands[0].as_deref().unwrap_or_default();
            let settings = first.settings.join(", ");
            let line = format!("  {verb} sets other values of {settings}");
            for line in text_table::wrap(line.split(' '), " ", WIDTH, "    ") {
                writeln!(out, "{line}")?;
            }
            return Ok(());
        }
        for (name, command) in ['A', name].iter().zip(&first.commands) {
            let command = command.as_deref().unwrap_or("none");
            writeln!(out, "  {name} {command}")?;
        }
        Ok(())
    }

    fn write_ticks(&self, out: &mut String, name: char, aligned: &str) -> Result {
        let (count, [a, b]) = (self.ticks, self.unmatched);
        writeln!(out, "ticks      {count} at the same times since {aligned}")?;
        let [a_us, b_us] = self.period_us;
        if a_us != b_us {
            let (fast, slow) = if a_us < b_us {
                ('A', name)
            } else {
                (name, 'A')
            };
            writeln!(
                out,
                "           periods {a_us} and {b_us} µs: angles and speeds of {fast} are\n           \
                 interpolated at the ticks of {slow}, the rest is that in force"
            )?;
        }
        if a + b > 0 {
            writeln!(out, "           {a} only in A, {b} only in {name}")?;
        }
        if count == 0 {
            return writeln!(out, "outputs    not compared: no tick is at the same time");
        }
        let Some(first) = &self.first_tick else {
            return writeln!(out, "outputs    the same in every tick");
        };
        let ([a, b], time_s) = (first.ticks, first.time_s);
        writeln!(
            out,
            "outputs    differ first after {time_s:.3} s, in tick {a} of A and {b} of {name}\n"
        )?;
        writeln!(
            out,
            "{:<18}{:>13}{:>13}{:>10}  unit",
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
            writeln!(out, "{column:<18}{max:>13}{rms:>13}{ticks:>10}  {unit}")?;
        }
        Ok(())
    }
}
