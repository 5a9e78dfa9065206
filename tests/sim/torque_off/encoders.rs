//! Encoders that stop or drift while a controller holds the arm, with 0 to 3 counts of noise, at 1
//! to 45 ms, on arms with and without dry friction.
//!
//! The drive ends before a joint that stands or moves is [`FAR_RAD`] from its reference at periods
//! up to 10 ms, and in any case before it is [`BEYOND_RAD`] from upright: short of table and stops.

use armbridge_board::tick::limits::CHECK_PERIOD_MAX_US;
use armbridge_link::message::{Command, Controller, Fault, Gains, Limits, Mode, Refusal, Setup};
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::faults::sensor::SensorFault;
use armbridge_sim::plant::{PlantConfig, Push};
use armbridge_tests::sinusoid;
use armbridge_tests::torque_off::cases::{check, run_cases};
use armbridge_tests::torque_off::rig::{Rig, World, bench, between_obstacles, with_rig};

const FAR_RAD: f64 = 0.5;
const BEYOND_RAD: f64 = 1.4;
/// Torque in N m with which something leans against a joint.
const PRESSING_NM: [f64; JOINTS] = [0.15, 0.08];
/// Time in ms until the encoders' noise is known, and until the motors have been checked.
const READY_MS: u64 = 5_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Activity {
    Standing,
    Moving,
    /// It stands while something leans against it.
    Pressed,
}

#[derive(Clone, Copy, Debug)]
struct Case {
    noise_counts: f64,
    period_us: u32,
    has_friction: bool,
    is_best: bool,
    activity: Activity,
    joint: usize,
    after_ms: u64,
}

impl Case {
    fn all() -> Vec<Self> {
        let mut cases = Vec::new();
        for noise_counts in [0.0, 0.2, 0.4, 0.5, 0.7, 1.0, 3.0] {
            for (period_us, is_best) in [
                (1_000, true),
                (1_000, false),
                (5_000, true),
                (10_000, true),
                (45_000, false),
            ] {
                for has_friction in [true, false] {
                    for activity in [Activity::Standing, Activity::Moving, Activity::Pressed] {
                        for joint in 0..JOINTS {
                            cases.push(Self {
                                noise_counts,
                                period_us,
                                has_friction,
                                is_best,
                                activity,
                                joint,
                                after_ms: 1_500 + cases.len() as u64 * 37 % 1_000,
                            });
                        }
                    }
                }
            }
        }
        cases
    }

    fn setup(&self) -> Setup {
        let setup = if self.is_best {
            Setup::best()
        } else {
            Setup::default()
        };
        let controller = if self.period_us > CHECK_PERIOD_MAX_US {
            Controller::StateFeedback(Gains::Paper)
        } else {
            setup.controller
        };
        Setup {
            period_us: self.period_us,
            controller,
            ..setup
        }
    }

    /// Runs a test on the arm at its activity; `None` if the check of the motors ends in a
    /// fault: large noise is motion to it.
    fn with_arm<T>(&self, test: impl FnOnce(&mut Rig<'_>) -> T) -> Option<T> {
        let arm = PlantConfig {
            noise_lsb_rms: self.noise_counts,
            friction_on: self.has_friction,
            ..PlantConfig::default()
        };
        with_rig(World::Bench, bench(&arm, Firmware::Morpheus), |rig| {
            assert_eq!(rig.command(Command::Configure(self.setup())), Ok(()));
            if self.period_us > CHECK_PERIOD_MAX_US {
                let unchecked = Limits {
                    check_rad_s2: 0,
                    ..Limits::default()
                };
                assert_eq!(rig.command(Command::Limit(unchecked)), Ok(()));
                rig.pass_ms(READY_MS);
            }
            let session = rig.host().session();
            assert_eq!(rig.command(Command::Arm { session }), Ok(()));
            let is_over = |rig: &Rig<'_>| matches!(rig.mode(), Some(Mode::Armed | Mode::Fault(_)));
            rig.until("checked", READY_MS * 1_000, is_over);
            if rig.mode() != Some(Mode::Armed) {
                return None;
            }
            let command = match self.activity {
                Activity::Standing | Activity::Pressed => Command::Regulate([0.05, -0.05]),
                Activity::Moving => Command::Follow(sinusoid(60.0)),
            };
            assert_eq!(rig.command(command), Ok(()));
            rig.pass_ms(self.after_ms);
            if self.activity == Activity::Pressed {
                let push = Push {
                    joint: self.joint,
                    torque_nm: PRESSING_NM[self.joint],
                    start_ns: rig.now_us() * 1_000,
                    duration_ns: 60_000_000_000,
                };
                rig.cosim.bench.push(push);
            }
            Some(test(rig))
        })
    }
}

/// End of a drive, and how far the arm was from it until then.
#[derive(Debug)]
struct End {
    fault: Option<Fault>,
    after_ms: u64,
    /// From the reference, and from upright, in rad.
    farthest_rad: f64,
    beyond_rad: f64,
}

fn watch(rig: &mut Rig<'_>, for_ms: u64) -> End {
    let from_us = rig.now_us();
    let mut end = End {
        fault: None,
        after_ms: 0,
        farthest_rad: 0.0,
        beyond_rad: 0.0,
    };
    while end.after_ms < for_ms {
        rig.pass_ms(1);
        let now_us = rig.now_us();
        end.after_ms = (now_us - from_us) / 1_000;
        if let Some(Mode::Fault(fault)) = rig.mode() {
            end.fault = Some(fault);
            break;
        }
        let q = rig.cosim.bench.state_at(now_us).q;
        let record = rig.host().record.expect("a record");
        for joint in 0..JOINTS {
            let far_rad = (q[joint] - f64::from(record.output.reference_rad[joint])).abs();
            end.farthest_rad = end.farthest_rad.max(far_rad);
            end.beyond_rad = end.beyond_rad.max(q[joint].abs());
        }
    }
    end
}

#[test]
fn a_frozen_encoder_ends_the_drive_before_the_arm_is_far_off() {
    let (mut armed, mut longest_ms) = (0, 0);
    run_cases(Case::all(), |case| {
        let end = case.with_arm(|rig| {
            rig.cosim.bench.fail_sensor(case.joint, SensorFault::Frozen);
            watch(rig, 10_000)
        });
        let Some(end) = end else {
            return Ok(());
        };
        armed += 1;
        longest_ms = longest_ms.max(end.after_ms);
        let is_near = end.farthest_rad < FAR_RAD
            || case.activity == Activity::Pressed
            || case.period_us > CHECK_PERIOD_MAX_US;
        check(is_near && end.beyond_rad < BEYOND_RAD, || {
            format!("{end:?}")
        })
    });
    println!("{armed} arms, the longest for {longest_ms} ms");
    assert!(armed > 360 && longest_ms < 1_500, "{armed} {longest_ms}");
}

#[test]
fn a_quiet_encoder_that_works_ends_no_drive() {
    let cases = Case::all()
        .into_iter()
        .filter(|case| case.noise_counts < 1.5);
    run_cases(cases, |case| {
        let end = case.with_arm(|rig| watch(rig, 3_000));
        let is_fault_free = end.as_ref().is_some_and(|end| end.fault.is_none());
        check(is_fault_free, || format!("{end:?}"))
    });
}

/// Pressed against an obstacle, where it cannot follow its reference.
#[test]
fn a_quiet_arm_against_an_obstacle_proves_its_encoder_the_other_way() {
    let arm = PlantConfig {
        noise_lsb_rms: 0.0,
        ..between_obstacles()
    };
    with_rig(World::Bench, bench(&arm, Firmware::Morpheus), |rig| {
        rig.arm();
        assert_eq!(rig.command(Command::Regulate([0.15, -0.1])), Ok(()));
        let end = watch(rig, 10_000);
        assert_eq!(end.fault, None, "{end:?}");
    });
}

/// At 45 ms the motors cannot be checked: the user confirms that by a limit, or has them checked
/// at a shorter period before.
#[test]
fn motors_that_cannot_be_checked_are_not_armed_unless_that_is_confirmed() {
    let arm = PlantConfig::default();
    let slow = Setup {
        period_us: 45_000,
        ..Setup::default()
    };
    let unchecked = Limits {
        check_rad_s2: 0,
        ..Limits::default()
    };
    let armed_with = |prepare: &dyn Fn(&mut Rig<'_>)| {
        with_rig(World::Bench, bench(&arm, Firmware::Morpheus), |rig| {
            prepare(rig);
            assert_eq!(rig.command(Command::Configure(slow)), Ok(()));
            rig.pass_ms(READY_MS);
            let session = rig.host().session();
            rig.command(Command::Arm { session })
        })
    };
    assert_eq!(armed_with(&|_| {}), Err(Refusal::MotorsUnchecked));
    let confirm = |rig: &mut Rig<'_>| {
        assert_eq!(rig.command(Command::Limit(unchecked)), Ok(()));
    };
    assert_eq!(armed_with(&confirm), Ok(()));
    let check_before = |rig: &mut Rig<'_>| {
        rig.arm();
        assert_eq!(rig.command(Command::Idle), Ok(()));
    };
    assert_eq!(armed_with(&check_before), Ok(()));
}
