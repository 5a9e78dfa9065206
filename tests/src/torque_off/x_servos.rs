//! Scenarios of servos of the X series, and the arm of two XL330 that they move.

use armbridge_link::message::{Command, Mode, Setup};
use armbridge_servo::protocol2::register;
use armbridge_servo::{ControlMode, Firmware, JOINTS};
use armbridge_sim::Bench;
use armbridge_sim::half_duplex_bus::Device;
use armbridge_sim::plant::{Plant, PlantConfig, PlantFile};

use super::rig::{World, bench, with_rig};
use crate::calibrations;

/// The arm of two XL330 that ships.
pub fn xl330(initial_rad: [f64; JOINTS]) -> PlantConfig {
    PlantFile::load("xl330").unwrap().config(initial_rad)
}

/// The bench that it is on.
pub fn xl330_bench(arm: &PlantConfig) -> Bench {
    Bench::new(Plant::new(*arm, 1))
}

/// Its parameters, for commands of this kind.
pub fn xl330_setup(mode: ControlMode) -> Setup {
    let arm = xl330([0.0; JOINTS]);
    let mut setup = arm.board_setup(Setup::best());
    setup.control_mode = mode;
    if mode == ControlMode::Current {
        let current = arm.x_servo.current.unwrap();
        for joint in &mut setup.joints {
            joint.gain_counts_per_nm = current.counts_per_nm();
        }
        // A current is not braked by back-EMF, which is all of this arm's viscous friction.
        setup.arm.b1 = 1e-4;
        setup.arm.b2 = 1e-4;
    }
    setup
}

/// A register of a servo on the bench.
pub fn register_of(bench: &Bench, servo: usize, address: u16) -> i32 {
    match &bench.servos()[servo] {
        Device::X(servo) => servo.register(address).expect("a register"),
        Device::Morpheus(_) | Device::Stock(_) => panic!("an X servo"),
    }
}

/// The arm is held by commands of this kind for so long; the distance of its worse joint from the
/// setpoint in rad.
pub fn is_held(world: World, mode: ControlMode, for_ms: u64) -> f64 {
    with_rig(world, xl330_bench(&xl330([0.2, -0.1])), |rig| {
        assert_eq!(rig.command(Command::Configure(xl330_setup(mode))), Ok(()));
        rig.prepare();
        rig.drive(Command::Regulate([0.3, 0.2]));
        rig.pass_ms(for_ms);
        assert!(
            matches!(rig.mode(), Some(Mode::Running(_))),
            "{:?}",
            rig.mode()
        );
        let (code, goals) = match mode {
            ControlMode::Pwm => (16, None),
            ControlMode::Current => (0, Some([885; JOINTS])),
        };
        let registers = |address| [0, 1].map(|servo| register_of(&rig.cosim.bench, servo, address));
        assert_eq!(registers(register::OPERATING_MODE), [code; JOINTS]);
        assert!(goals.is_none_or(|goals| registers(register::GOAL_PWM) == goals));
        let q = rig.cosim.bench.plant().state().q;
        let off_rad = (q.x - 0.3).abs().max((q.y - 0.2).abs());
        println!("{mode:?}: off by {off_rad:.4} rad");
        off_rad
    })
}

/// Settings are saved between ticks of servos that are ready: none of them is off by its watchdog after
/// it, and the arm is held at once.
pub fn settings_are_saved_while_servos_are_ready(world: World) {
    let arm = PlantConfig::default();
    with_rig(world, bench(&arm, Firmware::XSeries), |rig| {
        let setup = Setup {
            joints: calibrations(Firmware::XSeries),
            ..Setup::best()
        };
        assert_eq!(rig.command(Command::Configure(setup)), Ok(()));
        rig.prepare();
        for _ in 0..3 {
            assert_eq!(rig.command(Command::Save), Ok(()));
        }
        rig.pass_ms(100);
        assert_eq!(rig.mode(), Some(Mode::Idle));
        rig.drive(Command::Regulate([0.0; JOINTS]));
        rig.pass_ms(200);
        assert!(
            matches!(rig.mode(), Some(Mode::Running(_))),
            "{:?}",
            rig.mode()
        );
        assert_eq!(rig.fault(), None);
        rig.reports_are_true().unwrap();
    });
}
