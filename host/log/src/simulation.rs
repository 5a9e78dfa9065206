//! Truth of a simulated arm in a log: its state at each tick, and the pushes on it.
//!
//! | topic               | message           | when                                   |
//! |---------------------|-------------------|----------------------------------------|
//! | `/simulation/state` | `SimulationState` | at the start of each tick, before the tick's record |
//! | `/simulation/push`  | `SimulationPush`  | when a push begins                     |
//!
//! A simulation passes more states than ticks; [`StateQueue`] finds that of a record by its
//! time. A state takes 93 bytes of the file, of the 409 of a tick.

use std::collections::VecDeque;

pub use armbridge_client::simulation::{Push, SimulationEvent, TrueState};
use armbridge_servo::JOINTS;

use super::proto;
use super::telemetry::{microseconds, seconds};

/// States that wait for a record; a board sends one for each tick, so that few do.
const WAITING_MAX: usize = 1 << 16;

/// States whose record has not arrived, in the order of time.
#[derive(Debug, Default)]
pub struct StateQueue(VecDeque<TrueState>);

impl StateQueue {
    /// Adds a state.
    pub fn push(&mut self, state: TrueState) {
        if self.0.len() == WAITING_MAX {
            self.0.pop_front();
        }
        self.0.push_back(state);
    }

    /// The state at this time of the board's clock; earlier ones are dropped.
    pub fn take(&mut self, start_us: u64) -> Option<TrueState> {
        let at_ns = start_us.saturating_mul(1_000);
        while let Some(state) = self.0.front()
            && state.at_ns <= at_ns
        {
            let state = self.0.pop_front()?;
            if state.at_ns == at_ns {
                return Some(state);
            }
        }
        None
    }
}

/// Message for a state.
pub(super) fn state_message(tick: u32, state: &TrueState) -> proto::SimulationState {
    proto::SimulationState {
        true_angle_rad_1: state.angle_rad[0],
        true_angle_rad_2: state.angle_rad[1],
        true_speed_rad_s_1: state.speed_rad_s[0],
        true_speed_rad_s_2: state.speed_rad_s[1],
        true_torque_nm_1: state.torque_nm[0],
        true_torque_nm_2: state.torque_nm[1],
        true_friction_nm_1: state.friction_nm[0],
        true_friction_nm_2: state.friction_nm[1],
        true_push_nm_1: state.push_nm[0],
        true_push_nm_2: state.push_nm[1],
        time_s: seconds(state.at_ns / 1_000),
        tick,
    }
}

/// The tick and the state of a message; `None` if its time is none.
pub(super) fn state(message: &proto::SimulationState) -> Option<(u32, TrueState)> {
    let state = TrueState {
        at_ns: microseconds(message.time_s)? * 1_000,
        angle_rad: [message.true_angle_rad_1, message.true_angle_rad_2],
        speed_rad_s: [message.true_speed_rad_s_1, message.true_speed_rad_s_2],
        torque_nm: [message.true_torque_nm_1, message.true_torque_nm_2],
        friction_nm: [message.true_friction_nm_1, message.true_friction_nm_2],
        push_nm: [message.true_push_nm_1, message.true_push_nm_2],
    };
    Some((message.tick, state))
}

/// Message for a push.
pub(super) fn push_message(push: &Push) -> proto::SimulationPush {
    proto::SimulationPush {
        joint: push.joint as u32 + 1,
        torque_nm: push.torque_nm,
        start_s: push.start_ns as f64 / 1e9,
        duration_s: push.duration_ns as f64 / 1e9,
    }
}

/// The push of a message; `None` if its joint or one of its times is none.
pub(super) fn push(message: &proto::SimulationPush) -> Option<Push> {
    let nanoseconds = |s: f64| {
        let ns = (s * 1e9).round();
        (0.0..9e18).contains(&ns).then_some(ns as u64)
    };
    let joint = (message.joint as usize).checked_sub(1)?;
    (joint < JOINTS).then_some(())?;
    Some(Push {
        joint,
        torque_nm: message.torque_nm,
        start_ns: nanoseconds(message.start_s)?,
        duration_ns: nanoseconds(message.duration_s)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(us: u64) -> TrueState {
        TrueState {
            at_ns: us * 1_000,
            angle_rad: [us as f32, -0.25],
            friction_nm: [0.0, f32::MIN_POSITIVE],
            ..TrueState::default()
        }
    }

    #[test]
    fn a_record_gets_the_state_of_its_own_start() {
        let mut queue = StateQueue::default();
        for us in [0, 240, 1_000, 1_240, 2_003] {
            queue.push(at(us));
        }
        assert_eq!(queue.take(1_000), Some(at(1_000)));
        // A clock that is not that of the simulation.
        assert_eq!(queue.take(1_999), None);
        assert_eq!(queue.take(2_003), Some(at(2_003)));
        assert_eq!(queue.take(2_003), None);
    }

    #[test]
    fn messages_give_back_states_and_pushes() {
        // Five years, to the microsecond.
        for us in [0, 1, 999_999, 157_680_000_000_001] {
            assert_eq!(state(&state_message(7, &at(us))), Some((7, at(us))));
        }
        let push_1 = Push {
            joint: 1,
            torque_nm: -0.3,
            start_ns: 12_345_678_901,
            duration_ns: 200_000_001,
        };
        assert_eq!(push(&push_message(&push_1)), Some(push_1));
        let message = push_message(&push_1);
        for wrong in [
            proto::SimulationPush {
                joint: 0,
                ..message
            },
            proto::SimulationPush {
                joint: 3,
                ..message
            },
            proto::SimulationPush {
                start_s: f64::NAN,
                ..message
            },
            proto::SimulationPush {
                duration_s: -1.0,
                ..message
            },
        ] {
            assert_eq!(push(&wrong), None);
        }
    }
}
