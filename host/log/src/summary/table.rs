//! The summary as text for a terminal of 80 columns, without colours.
//!
//! | text      | contents                                                       |
//! |-----------|----------------------------------------------------------------|
//! | `results` | setpoints, pushes and motion: how the arm performed            |
//! | `totals`  | two lines for loop, bus and torque                            |
//! | `details` | distributions per tick, and every counter                      |
//! | `remarks` | explanations and everything that went wrong                    |

use std::fmt::{Result, Write};

use armbridge_servo::JOINTS;

use super::{
    JointSummary, PushSummary, SETTLED_RAD, SegmentSummary, ServoSummary, Spread, Summary,
};
use crate::text_table::{self, WIDTH};

/// Setpoints that fit on a screen.
const SEGMENTS_SHOWN: usize = 8;

impl Summary {
    /// Everything: results, totals, details and remarks.
    pub fn table(&self) -> String {
        [
            self.results(),
            self.totals(),
            self.details(),
            self.remarks_text(),
        ]
        .join("\n")
    }

    /// Performance at setpoints, after pushes and in motion.
    pub fn results(&self) -> String {
        text(|out| {
            self.write_events(out)?;
            if let Some(rms_mrad) = self.tracking_rms_mrad {
                let rms = self.each(&rms_mrad, |mrad| format!("{mrad:.1}"));
                writeln!(out, " in motion, the error is {rms} mrad rms")?;
            }
            Ok(())
        })
    }

    /// Setpoints and pushes, in the order of time.
    fn write_events(&self, out: &mut String) -> Result {
        let setpoints = &self.segments[..self.segments.len().min(SEGMENTS_SHOWN)];
        let pushes = &self.pushes[..self.pushes.len().min(SEGMENTS_SHOWN)];
        match (setpoints, pushes) {
            ([], []) => return Ok(()),
            ([], _) => write_heading(out, "push", "error")?,
            _ => write_heading(out, "setpoint (rad)", "at rest off by")?,
        }
        let joints = self.run.joints();
        let setpoint_rows = setpoints
            .iter()
            .map(|it| (it.start_s, setpoint_row(it, joints)));
        let push_rows = pushes.iter().map(|it| (it.start_s, push_row(it)));
        let mut rows: Vec<(f64, String)> = setpoint_rows.chain(push_rows).collect();
        rows.sort_by(|(a_s, _), (b_s, _)| a_s.total_cmp(b_s));
        for (_, row) in rows {
            writeln!(out, "{row}")?;
        }
        let left_out = (self.segments.len() - setpoints.len()) as u64 + self.segments_left_out;
        if left_out > 0 {
            writeln!(out, " ... and {left_out} setpoints more")?;
        }
        if self.pushes.len() > pushes.len() {
            writeln!(
                out,
                " ... and {} pushes more",
                self.pushes.len() - pushes.len()
            )?;
        }
        Ok(())
    }

    /// Loop, bus and torque.
    pub fn totals(&self) -> String {
        let missing: u64 = self.missing_samples.values().sum();
        let missing = match missing {
            0 => String::new(),
            missing => format!(", {missing} samples missing"),
        };
        text(|out| {
            writeln!(
                out,
                " loop     {}, {} ticks, {} missed, {}{missing}",
                rate(self.run.period_us),
                self.ticks,
                self.missed_ticks,
                match self.faults.len() {
                    1 => "1 fault".to_owned(),
                    count => format!("{count} faults"),
                }
            )?;
            writeln!(
                out,
                " load     bus {:.0} of {} µs, {}",
                self.bus_us.mean,
                self.run.period_us,
                self.torque_text()
            )
        })
    }

    /// Largest torques beside the limits of their directions: a servo drives more strongly in
    /// one than in the other.
    pub fn torque_text(&self) -> String {
        let torque = |nm: &f64| format!("{nm:.2}");
        let most = self.each(&self.peak_torque_nm, torque);
        let limits = match self.peak_torque_limit_nm.map(|nm| torque(&nm)) {
            [limit, other] if limit == other => limit,
            _ => self.each(&self.peak_torque_limit_nm, torque),
        };
        format!("torque at most {most} of {limits} N m")
    }

    /// The texts of the values of all joints: `a and b`.
    fn each<T>(&self, values: &[T; JOINTS], text: impl Fn(&T) -> String) -> String {
        let texts: Vec<_> = values.iter().take(self.run.joints()).map(text).collect();
        texts.join(" and ")
    }

    /// Distributions per tick, and every counter.
    pub fn details(&self) -> String {
        text(|out| {
            self.write_ticks(out)?;
            self.write_counters(out)
        })
    }

    fn write_ticks(&self, out: &mut String) -> Result {
        writeln!(
            out,
            " {:<14}{:>10}{:>10}{:>10}{:>10}",
            "per tick", "mean", "std", "p99", "max"
        )?;
        write_spread(out, "start delay", self.start_error_us, 1.0, "µs")?;
        let occupancy = format!("µs = {:.1} % of a tick", self.bus_occupancy_percent);
        write_spread(out, "bus", self.bus_us, 1.0, &occupancy)?;
        match self.compute_ns {
            Some(compute_ns) => write_spread(out, "compute", compute_ns, 1e-3, "µs"),
            None => writeln!(out, " {:<14}{:>10}", "compute", "–"),
        }
    }

    fn write_counters(&self, out: &mut String) -> Result {
        let pwm = self.each(&self.peak_pwm_deviation, u16::to_string);
        let link = self.records;
        let rows = [
            ("peak PWM", format!("{pwm} counts from neutral")),
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
                "log file",
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
            .try_for_each(|(name, text)| writeln!(out, " {name:<14}{text}"))
    }

    /// The remarks, broken at the terminal's width.
    pub fn remarks_text(&self) -> String {
        let lines = self
            .remarks
            .iter()
            .flat_map(|remark| text_table::wrap(remark.split(' '), " ", WIDTH, "    "));
        lines.map(|line| line + "\n").collect()
    }
}

/// Text that a closure writes.
fn text(write: impl FnOnce(&mut String) -> Result) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut text);
    text
}

/// Heading of setpoints, or of pushes alone.
fn setpoint_row(segment: &SegmentSummary, joints: usize) -> String {
    let joints = &segment.joints[..joints];
    let each = |text: fn(&JointSummary) -> String| joints.iter().map(text).collect::<String>();
    format!(
        " {:<9}{:<18}{:<24}{} mrad",
        format!("{:.1} s", segment.start_s),
        each(|joint| format!("{:+.2}  ", joint.reference_rad)),
        each(|joint| format!("{:<8}", seconds_or_never(joint.settling_time_s))),
        each(|joint| format!("{:>5} ", rest_error(joint))).trim_end(),
    )
}

/// The error at rest; of a joint that is not at rest there is none.
fn rest_error(joint: &JointSummary) -> String {
    if joint.is_at_rest {
        format!("{:.1}", joint.steady_state_error_mrad.abs())
    } else {
        "–".into()
    }
}

fn push_row(push: &PushSummary) -> String {
    format!(
        " {:<9}{:<18}{:<24}{:>5.1} mrad at most",
        format!("{:.1} s", push.start_s),
        format!("push, joint {}", push.joint),
        seconds_or_never(push.recovered_s),
        push.peak_error_mrad
    )
}

fn write_heading(out: &mut String, place: &str, error: &str) -> Result {
    let within = format!("within {:.0} mrad after", SETTLED_RAD * 1e3);
    writeln!(out, " {:<9}{place:<18}{within:<24}{error}", "from")
}

/// A time, or `never`.
fn seconds_or_never(time_s: Option<f64>) -> String {
    time_s.map_or("never".into(), |s| format!("{s:.2} s"))
}

/// Rate of a period: `1 kHz`, `22.2 Hz`.
fn rate(period_us: u32) -> String {
    let hz = 1e6 / f64::from(period_us);
    if hz >= 1000.0 {
        format!("{} kHz", (hz / 10.0).round() / 100.0)
    } else {
        format!("{} Hz", (hz * 10.0).round() / 10.0)
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
    write!(out, " {name:<14}")?;
    for value in [mean, std, f64::from(p99), f64::from(max)] {
        write!(out, "{:>10.2}", value * scale)?;
    }
    writeln!(out, "  {unit}")
}
