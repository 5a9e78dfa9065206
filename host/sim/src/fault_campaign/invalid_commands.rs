//! Invalid commands: numbers that a board must refuse.

use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Experiment, Role};
use armbridge_link::message::{Command, Limits, Setup};
use armbridge_servo::JOINTS;

/// The command of this turn; they are sent in rotation.
pub(super) fn out_of_range(turn: usize) -> Command {
    let limits = Limits::default();
    let commands = [
        Command::Torque([f32::NAN; JOINTS]),
        Command::Regulate([9.0, 0.0]),
        Command::Torque([0.0, 1e9]),
        Command::Regulate([f32::INFINITY; JOINTS]),
        Command::Limit(Limits {
            angle_rad: [3.0; JOINTS],
            ..limits
        }),
        Command::Limit(Limits {
            silence_ms: u16::MAX,
            ..limits
        }),
        Command::Configure(Setup {
            period_us: 1,
            ..Setup::default()
        }),
        Command::Arm { session: 0 },
        Command::Experiment(Experiment {
            roles: [Role::Torque(Signal::Constant(f32::NAN)), Role::Hold],
            duration_s: 1.0,
            angle_rad: [[-1.0, 1.0]; JOINTS],
            speed_rad_s: [1.0; JOINTS],
        }),
        Command::Stream {
            at_us: u64::MAX,
            angle_rad: [f32::NAN; JOINTS],
            speed_rad_s: None,
        },
    ];
    commands[turn % commands.len()]
}
