//! Distance of an arm from where hands have left it.

use armbridge_link::message::{Drive, Record};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::Lead;

/// Monitor of an arm that floats: how far it moves by itself.
#[derive(Clone, Debug)]
pub(super) struct StayMonitor {
    /// Hands in order of time, their times since the run began.
    leads: Vec<Lead>,
    next: usize,
    /// Angles in rad at which the last hand left the arm, while they count.
    left_rad: Option<[f32; JOINTS]>,
    farthest_rad: f64,
}

impl StayMonitor {
    /// Monitor of a run with these hands.
    pub(super) fn new(leads: &[Lead]) -> Self {
        Self {
            leads: leads.to_vec(),
            next: 0,
            left_rad: None,
            farthest_rad: 0.0,
        }
    }

    /// Observes the next tick, `now_us` after the run began.
    pub(super) fn on_record(&mut self, now_us: u64, record: &Record) {
        let is_floating = record.mode.drive() == Some(Drive::Float);
        let angle_rad = record.output.angle_rad;
        if !is_floating {
            self.left_rad = None;
        }
        if let Some(lead) = self.leads.get(self.next) {
            if now_us >= lead.start_ns / 1_000 {
                self.left_rad = None;
            }
            if now_us >= (lead.start_ns + lead.release_ns) / 1_000 {
                self.next += 1;
                if is_floating {
                    self.left_rad = Some(angle_rad);
                } else {
                    self.farthest_rad = f64::INFINITY;
                }
            }
        }
        for (left_rad, angle_rad) in self.left_rad.iter().flatten().zip(angle_rad) {
            let way_rad = f64::from((angle_rad - left_rad).abs());
            self.farthest_rad = self.farthest_rad.max(way_rad);
        }
    }

    /// Largest distance in rad of a joint from where a hand left it; infinite if a hand has not
    /// let go of an arm that floats, `None` if there is no hand.
    pub(super) fn farthest_rad(&self) -> Option<f64> {
        if self.next < self.leads.len() {
            return Some(f64::INFINITY);
        }
        (!self.leads.is_empty()).then_some(self.farthest_rad)
    }
}

#[cfg(test)]
mod tests {
    use armbridge_link::message::{Mode, TickOutput};
    use armbridge_sim::plant::{Grip, LeadPoint};

    use super::*;

    /// A hand from this time on that lets go after a second.
    fn lead(start_s: u64) -> Lead {
        Lead {
            grip: Grip {
                link: 1,
                stiffness_n_m: 300.0,
                damping_n_s_m: 10.0,
            },
            start_ns: start_s * 1_000_000_000,
            path: vec![LeadPoint {
                after_ns: 1_000_000_000,
                angle_rad: [0.0; JOINTS],
            }],
            release_ns: 1_000_000_000,
        }
    }

    /// The farthest of an arm whose joint 2 is at these angles in successive seconds.
    fn farthest_rad(leads: &[Lead], drive: Drive, angles_rad: &[f32]) -> Option<f64> {
        let mut monitor = StayMonitor::new(leads);
        for (second, angle_rad) in (0..).zip(angles_rad) {
            let record = Record {
                mode: Mode::Running(drive),
                output: TickOutput {
                    angle_rad: [0.0, *angle_rad],
                    ..TickOutput::NONE
                },
                ..Record::NONE
            };
            monitor.on_record(second * 1_000_000, &record);
        }
        monitor.farthest_rad()
    }

    /// What counts is the way after a hand has let go, and before the next has grasped the arm.
    #[test]
    fn an_arm_is_measured_from_where_a_hand_left_it() {
        let leads = [lead(1), lead(4)];
        let way = |angles: &[f32]| farthest_rad(&leads, Drive::Float, angles);
        assert_eq!(way(&[0.0, 0.5, 1.0, 1.25, 0.0, 0.5, 0.5]), Some(0.25));
        assert_eq!(way(&[0.0, 0.5, 1.0, 1.0, 0.0, 0.5, 0.0]), Some(0.5));
        assert_eq!(way(&[0.0, 0.5, 1.0, 1.0, 0.0]), Some(f64::INFINITY));
        let held = farthest_rad(&leads[..1], Drive::Regulate, &[0.0; 4]);
        assert_eq!(held, Some(f64::INFINITY));
        assert_eq!(farthest_rad(&[], Drive::Float, &[0.0; 4]), None);
    }
}
