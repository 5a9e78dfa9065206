//! Commands of a host: mostly valid, some with numbers that are not finite.

use armbridge_board::bridge::limits::{PERIOD_MAX_US, PERIOD_MIN_US, REFERENCE_MAX_RAD};
use armbridge_control::actuator::Joint;
use armbridge_control::design::placement::Poles;
use armbridge_control::estimate::{Config, Form, Tuning};
use armbridge_link::limits::{Milliradians, hard};
use armbridge_link::message::{Command, Controller, Gains, Hello, Limits, Setup, ToBoard};
use armbridge_link::motion::{Motion, Via};
use armbridge_link::schema;
use armbridge_tests::random::Random;

use super::experiments;

/// Numbers that break careless arithmetic, and some that do not.
const NASTY: [f32; 16] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    -1e20,
    1e20,
    0.0,
    -0.0,
    1.0,
    0.999_999_9,
    1e-6,
    0.05,
    15.0,
];

pub(super) fn nasty<const N: usize>(random: &mut Random) -> [f32; N] {
    [0; N].map(|_| match random.below(8) {
        0 => f32::from_bits(random.below(1 << 32) as u32),
        _ => random.one_of(&NASTY),
    })
}

/// Mostly a set-up that can be built, with one or two fields that are not.
fn setup(random: &mut Random) -> Setup {
    let mut setup = Setup::default();
    for _ in 0..=random.below(2) {
        match random.below(11) {
            0 => {
                setup.period_us =
                    random.one_of(&[0, 1, 999, 1_000, 1_001, 45_000, 100_000, 100_001, u32::MAX]);
            }
            1 => setup.controller = Controller::StateFeedback(Gains::Paper),
            2 => {
                let (q, r) = (nasty(random), nasty(random));
                setup.controller = Controller::StateFeedback(Gains::Design { q, r });
            }
            3 => {
                let [filter_s] = nasty(random);
                setup.estimator = Config::FiniteDifference { filter_s };
            }
            4 => {
                let poles_45ms = [0, 1].map(|_| {
                    let [a, b] = nasty(random);
                    if random.once_in(2) {
                        Poles::Real(a, b)
                    } else {
                        Poles::Conjugate { re: a, im: b }
                    }
                });
                setup.estimator = Config::Luenberger {
                    form: Form::Current,
                    poles_45ms,
                };
            }
            5 if random.once_in(2) => setup.integral = nasty(random),
            5 if random.once_in(2) => setup.friction_nm = nasty(random),
            5 => {
                // Some beyond what is accepted.
                let percent = |random: &mut Random| random.below(60) as u8;
                setup.friction_load_percent = [percent(random), percent(random)];
            }
            6 => {
                let gain = [nasty(random), nasty(random)];
                setup.controller = Controller::StateFeedback(Gains::Given(gain));
            }
            7 => {
                let (natural_rad_s, damping) = (nasty(random), nasty(random));
                setup.controller = Controller::ComputedTorque {
                    natural_rad_s,
                    damping,
                };
            }
            8 => {
                let [
                    angle_rad,
                    acceleration,
                    disturbance,
                    coulomb_nm,
                    slide_rad_s,
                ] = nasty(random);
                setup.estimator = Config::Kalman(Tuning {
                    angle_rad,
                    acceleration,
                    disturbance,
                    coulomb_nm,
                    slide_rad_s,
                });
            }
            9 => [setup.arm.i1x, setup.arm.b2, setup.arm.g] = nasty(random),
            _ => {
                [
                    setup.joints[1].zero_count,
                    setup.joints[0].gain_counts_per_nm,
                ] = nasty(random);
            }
        }
    }
    setup
}

fn motion(random: &mut Random) -> Motion {
    let [duration_s, ramp_s] = nasty(random);
    match random.below(4) {
        0 => Motion::MinimumJerk {
            to_rad: nasty(random),
            duration_s: (duration_s > 1.0).then_some(duration_s),
        },
        1 => {
            let vias = [(); 8].map(|()| {
                let [at_s] = nasty(random);
                let angle_rad = nasty(random);
                Some(Via { at_s, angle_rad })
            });
            Motion::Waypoints(vias)
        }
        2 => Motion::Sinusoid {
            centre_rad: nasty(random),
            amplitude_rad: nasty(random),
            frequency_hz: nasty(random),
            phase_rad: nasty(random),
            ramp_s,
            duration_s,
        },
        _ => Motion::Chirp {
            centre_rad: nasty(random),
            amplitude_rad: nasty(random),
            from_hz: nasty(random),
            to_hz: nasty(random),
            ramp_s,
            duration_s,
        },
    }
}

/// `session` is that of the board that is spoken to.
pub(super) fn message(random: &mut Random, session: u32) -> ToBoard {
    ToBoard::Command(match random.below(40) {
        0 if random.once_in(30) => return ToBoard::Hello(schema::HELLO),
        1 if random.once_in(30) => {
            let schema = [0; 8].map(|_| random.byte());
            let version = [0; 3].map(|_| random.byte());
            return ToBoard::Hello(Hello { schema, version });
        }
        0..=5 => return ToBoard::Heartbeat,
        6 => Command::Idle,
        7..=9 | 38..=39 => Command::ClearFault,
        10 => Command::Configure(setup(random)),
        11..=13 => Command::Torque(nasty(random)),
        14..=16 => Command::Regulate(nasty(random)),
        17 => Command::Torque([0.3, -0.2]),
        18 => Command::Follow(motion(random)),
        27 => Command::Experiment(experiments::random(random)),
        19 => {
            let at_us = random.below(2_000_000);
            let speed = nasty(random);
            Command::Stream {
                at_us,
                angle_rad: [0.1, -0.1],
                speed_rad_s: at_us.is_multiple_of(2).then_some(speed),
            }
        }
        20..=25 | 30..=37 => Command::Arm { session },
        26 => match random.below(6) {
            // Rarely: few cases get beyond the fault.
            0 if random.once_in(10) => return ToBoard::Stop,
            1 => return ToBoard::Goodbye,
            2 => Command::Arm {
                session: random.below(1 << 32) as u32,
            },
            3 => Command::Save,
            4 => Command::Park,
            _ => Command::Limit(limits(random)),
        },
        28 => Command::Float,
        _ => Command::Regulate([0.1, -1.0]),
    })
}

/// Mostly limits that are allowed.
fn limits(random: &mut Random) -> Limits {
    let mut limits = Limits::default();
    if random.once_in(2) {
        [limits.speed_rad_s, limits.torque_nm] = [nasty(random), nasty(random)];
    }
    limits.park = random.once_in(2).then(|| {
        let angle = |random: &mut Random| Milliradians(random.below(2_600) as i16 - 1_300);
        [angle(random), angle(random)]
    });
    limits.check_rad_s2 = random.one_of(&[0, 0, 0, 0, 0, 16]);
    limits
}

/// Whether a command may be accepted at all.
pub(super) fn is_acceptable(command: &Command) -> bool {
    let within = |values: &[f32], limit: f32| values.iter().all(|value| value.abs() <= limit);
    let finite = |values: &[f32]| values.iter().all(|value| value.is_finite());
    match command {
        Command::Idle
        | Command::Prepare
        | Command::Release
        | Command::ClearFault
        | Command::Arm { .. }
        | Command::Float
        | Command::Park
        | Command::Save => true,
        Command::Limit(limits) => limits.is_valid(),
        Command::Experiment(plan) => experiments::is_acceptable(plan),
        Command::Torque(torque_nm) => within(torque_nm, hard::TORQUE_NM),
        Command::Regulate(reference_rad) => within(reference_rad, REFERENCE_MAX_RAD),
        Command::Configure(setup) => {
            let estimator_is_stable = match setup.estimator {
                Config::FiniteDifference { filter_s } => filter_s.is_finite() && filter_s >= 0.0,
                Config::Luenberger { poles_45ms, .. } => poles_45ms.iter().all(|poles| {
                    let real = |pole| (0.0..1.0).contains(&pole);
                    match *poles {
                        Poles::Real(a, b) => real(a) && real(b),
                        Poles::Conjugate { re, im } => re.hypot(im) < 1.0,
                    }
                }),
                Config::Gain { gain, .. } => finite(gain.as_flattened()),
                Config::Kalman(tuning) => finite(&[
                    tuning.angle_rad,
                    tuning.acceleration,
                    tuning.disturbance,
                    tuning.coulomb_nm,
                    tuning.slide_rad_s,
                ]),
            };
            let gains_are_finite = match setup.controller {
                Controller::StateFeedback(Gains::Paper) => true,
                Controller::StateFeedback(Gains::Design { q, r }) => finite(&q) && finite(&r),
                Controller::StateFeedback(Gains::Given(rows)) => finite(rows.as_flattened()),
                Controller::ComputedTorque {
                    natural_rad_s,
                    damping,
                } => finite(&natural_rad_s) && finite(&damping),
            };
            (PERIOD_MIN_US..=PERIOD_MAX_US).contains(&setup.period_us)
                && estimator_is_stable
                && gains_are_finite
                && within(&setup.friction_nm, 1.0)
                && setup.friction_load_percent.iter().all(|load| *load <= 50)
                && setup.integral.iter().all(|gain| *gain >= 0.0)
                && setup.arm.is_valid()
                && setup.joints.iter().all(Joint::is_valid)
        }
        Command::Follow(motion) => match *motion {
            Motion::MinimumJerk { to_rad, duration_s } => {
                within(&to_rad, 1.0001 * REFERENCE_MAX_RAD) && duration_s.is_none_or(f32::is_finite)
            }
            Motion::Waypoints(vias) => vias
                .iter()
                .map_while(|via| *via)
                .all(|via| within(&via.angle_rad, 1.0001 * REFERENCE_MAX_RAD)),
            Motion::Sinusoid {
                centre_rad,
                amplitude_rad,
                ..
            }
            | Motion::Chirp {
                centre_rad,
                amplitude_rad,
                ..
            } => finite(&centre_rad) && finite(&amplitude_rad),
        },
        Command::Stream {
            angle_rad,
            speed_rad_s,
            ..
        } => within(angle_rad, REFERENCE_MAX_RAD) && speed_rad_s.is_none_or(|speed| finite(&speed)),
    }
}
