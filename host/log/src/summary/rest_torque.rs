//! Torque while the arm rests: whether it chatters, and how often limits act on it.
//!
//! Gains that are too high turn the encoder's noise into torque: the arm stands, but its motors
//! are driven to and fro in every tick. The arm rests from [`STEADY_S`](super::STEADY_S) after
//! its setpoint changed or it was pushed.

use armbridge_link::message::{Guards, Record};
use armbridge_servo::JOINTS;
use serde::Serialize;

use crate::run_info::RunFacts;

/// Change of torque from tick to tick, rms, as a share of the largest: the torque chatters
/// beyond it. The default gains make a hundredth of one count of noise.
const STEP_SHARE: f64 = 0.1;
/// Share of ticks in which a limit may act: an arm that stands needs none.
const LIMITED_SHARE: f64 = 0.005;

/// Torque while the arm rests.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RestTorque {
    /// Root mean square of the change of torque from tick to tick, in N m.
    pub step_rms_nm: [f64; JOINTS],
    /// Share of the ticks in which a limit changed the torque, 0 to 1.
    pub limited_share: f64,
}

impl RestTorque {
    /// Flaw, if there is one.
    pub(super) fn remark(&self, facts: &RunFacts) -> Option<String> {
        let [first, second] = self.step_rms_nm;
        let chatters =
            (0..JOINTS).any(|j| self.step_rms_nm[j] > STEP_SHARE * facts.torque_limit_nm(j, 0.0));
        let chatter = chatters.then(|| {
            format!(
                "the torque chatters: it changes by {first:.2} and {second:.2} N m rms from tick \
                 to tick"
            )
        });
        let limited = (self.limited_share > LIMITED_SHARE).then(|| {
            let percent = self.limited_share * 100.0;
            format!("limits hold the torque back in {percent:.1} % of the ticks")
        });
        let found: Vec<String> = chatter.into_iter().chain(limited).collect();
        (!found.is_empty()).then(|| format!("at rest {}; lower the gains", found.join(", and ")))
    }
}

/// The same, added tick by tick.
#[derive(Clone, Debug, Default)]
pub(super) struct RestTorqueTally {
    before_nm: Option<[f32; JOINTS]>,
    ticks: u64,
    limited: u64,
    step_square_nm2: [f64; JOINTS],
}

impl RestTorqueTally {
    /// Adds the next tick, in which the arm rests or does not.
    pub(super) fn add(&mut self, record: &Record, is_resting: bool) {
        let before_nm = self.before_nm.replace(record.output.torque_nm);
        let Some(before_nm) = before_nm.filter(|_| is_resting) else {
            return;
        };
        self.ticks += 1;
        self.limited += u64::from(record.output.guards != Guards::NONE);
        let pairs = record.output.torque_nm.iter().zip(before_nm);
        for (square_nm2, (torque_nm, before_nm)) in self.step_square_nm2.iter_mut().zip(pairs) {
            *square_nm2 += f64::from(torque_nm - before_nm).powi(2);
        }
    }

    /// Result; none if the arm never rested.
    pub(super) fn finished(&self) -> Option<RestTorque> {
        let ticks = self.ticks as f64;
        (self.ticks > 0).then(|| RestTorque {
            step_rms_nm: self.step_square_nm2.map(|square| (square / ticks).sqrt()),
            limited_share: self.limited as f64 / ticks,
        })
    }
}
