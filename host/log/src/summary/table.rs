//! The summary as text for a terminal, at most 100 columns, without colours.

use std::fmt::{Result, Write};

use super::{JointSummary, ServoSummary, Spread, Summary};
use crate::text_table;

/// Setpoints that fit on a screen.
const SEGMENTS_SHOWN: usize = 8;

/// Width of the rules, and the column at which remarks are broken.
const WIDTH: usize = 84;

impl Summary {
    /// The summary as text, ending in a line feed.
    pub fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_table(&mut text);
        text
    }

    fn write_table(&self, out: &mut String) -> Result {
        let rule = "─".repeat(WIDTH);
        writeln!(
            out,
            "armbridge {} · {}\n{rule}",
            self.run.name,
            self.run.describe()
        )?;
        self.write_setpoints(out)?;
        writeln!(out, "{rule}")?;
        self.write_ticks(out)?;
        writeln!(out, "{rule}")?;
        self.write_totals(out)?;
        if !self.remarks.is_empty() {
            writeln!(out, "{rule}")?;
        }
        for remark in &self.remarks {
            let lines = text_table::wrap(remark.split(' '), " ", WIDTH, "    ");
            writeln!(out, "{}", lines.join("\n"))?;
        }
        Ok(())
    }

    fn write_setpoints(&self, out: &mut String) -> Result {
        writeln!(
            out,
            "{:<10}{:>6}{:>16}{:>14}{:>18}{:>20}",
            "from", "joint", "setpoint", "settled", "error at rest", "in encoder counts"
        )?;
        let shown = self.segments.len().min(SEGMENTS_SHOWN);
        for segment in &self.segments[..shown] {
            for (j, joint) in segment.joints.iter().enumerate() {
                let from = if j == 0 {
                    format!("{:.2} s", segment.start_s)
                } else {
                    String::new()
                };
                let JointSummary {
                    reference_rad,
                    settling_time_s,
                    ..
                } = joint;
                let settled = settling_time_s.map_or("never".into(), |s| format!("in {s:.3} s"));
                writeln!(
                    out,
                    "{from:<10}{:>6}{reference_rad:>+12.3} rad{settled:>14}{:>+13.1} mrad{:>+20.1}",
                    j + 1,
                    joint.steady_state_error_mrad,
                    joint.steady_state_error_counts,
                )?;
            }
        }
        let left_out = (self.segments.len() - shown) as u64 + self.segments_left_out;
        if left_out > 0 {
            writeln!(out, "... and {left_out} setpoints more")?;
        }
        if let Some([first, second]) = self.tracking_rms_mrad {
            writeln!(out, "in motion, error rms {first:.1} and {second:.1} mrad")?;
        }
        Ok(())
    }

    fn write_ticks(&self, out: &mut String) -> Result {
        writeln!(
            out,
            "{:<16}{:>10}{:>10}{:>10}{:>10}",
            "per tick", "mean", "std", "p99", "max"
        )?;
        write_spread(out, "starts late", self.start_error_us, 1.0, "µs")?;
        let occupancy = format!("µs = {:.1} % of the period", self.bus_occupancy_percent);
        write_spread(out, "bus", self.bus_us, 1.0, &occupancy)?;
        match self.compute_ns {
            Some(compute_ns) => write_spread(out, "compute", compute_ns, 1e-3, "µs"),
            None => writeln!(out, "{:<16}{:>10}", "compute", "not measured"),
        }
    }

    fn write_totals(&self, out: &mut String) -> Result {
        let [torque1, torque2] = self.peak_torque_nm;
        let [pwm1, pwm2] = self.peak_pwm_deviation;
        let missing: u64 = self.missing_samples.values().sum();
        let link = self.records;
        let rows = [
            ("peak torque", format!("{torque1:.3} and {torque2:.3} N m")),
            ("peak PWM", format!("{pwm1} and {pwm2} counts from neutral")),
            (
                "ticks",
                format!(
                    "{} recorded, {} missed, {missing} samples missing, {} faults",
                    self.ticks,
                    self.missed_ticks,
                    self.faults.len()
                ),
            ),
            (
                "records",
                format!(
                    "{} sent, {} lost, {} damaged, {} dropped",
                    link.sent, link.lost, link.damaged, link.dropped
                ),
            ),
            (
                "speed",
                format!(
                    "{:.2} s in {:.2} s, {:.1} times real time",
                    self.simulated_s, self.wall_s, self.simulated_s_per_wall_s
                ),
            ),
        ];
        let servos = self.servos.iter().map(|servos| {
            let ServoSummary { firmware, baud } = servos;
            ("servos", format!("{firmware}, at {baud} baud"))
        });
        let log = self.log.iter().map(|log| {
            (
                "log",
                format!(
                    "{} records written, {} lost, {} bytes unwritten, {:.1} MB",
                    log.written,
                    log.lost,
                    log.unwritten,
                    log.size as f64 * 1e-6
                ),
            )
        });
        let port = self.port.iter().map(|port| {
            (
                "port",
                format!(
                    "{} passed, {} of them late, {} refused, {} half packets",
                    port.passed, port.delayed, port.refused, port.halves
                ),
            )
        });
        servos
            .chain(rows)
            .chain(log)
            .chain(port)
            .try_for_each(|(name, text)| writeln!(out, "{name:<16}{text}"))
    }
}

/// One row of the table of times per tick, in the given unit.
fn write_spread(out: &mut String, name: &str, spread: Spread, scale: f64, unit: &str) -> Result {
    let Spread {
        mean,
        std,
        p99,
        max,
    } = spread;
    write!(out, "{name:<16}")?;
    for value in [mean, std, f64::from(p99), f64::from(max)] {
        write!(out, "{:>10.2}", value * scale)?;
    }
    writeln!(out, "  {unit}")
}
