//! A host that does anything at any time, and its run through the board's code again.

use armbridge_link::limits::Limits;
use armbridge_link::message::{Command, Setup, ToBoard};
use armbridge_link::motion::Motion;
use armbridge_sim::half_duplex_bus::{BusDirection, ByteDamage, ByteFault};

use crate::experiments::{experiment, number};
use crate::plant;
use crate::random::Random;
use crate::tapped_bench::{Action, ScriptedHost, records, replay, tapped_run};

/// Length of a run in µs.
const RUN_US: u64 = 1_500_000;

fn angles(random: &mut Random) -> [f32; 2] {
    [(); 2].map(|()| random.below(400) as f32 * 1e-3 - 0.2)
}

fn act(random: &mut Random, now_us: u64) -> Action {
    let command = match random.below(18) {
        0 => Command::Idle,
        1..=3 => Command::Arm { session: 0 },
        4 => Command::Torque(angles(random)),
        5 | 6 => Command::Regulate(angles(random)),
        7 | 8 => Command::Follow(Motion::MinimumJerk {
            to_rad: angles(random),
            duration_s: (random.once_in(2)).then(|| 0.1 + random.below(500) as f32 * 1e-3),
        }),
        9 => Command::Follow(Motion::Sinusoid {
            centre_rad: angles(random),
            amplitude_rad: angles(random).map(f32::abs),
            frequency_hz: [1.0, 1.5],
            phase_rad: angles(random),
            ramp_s: 0.2,
            duration_s: 0.6,
        }),
        10 => Command::Stream {
            at_us: now_us + random.below(200_000),
            angle_rad: angles(random),
            speed_rad_s: None,
        },
        11 => Command::Configure(if random.once_in(2) {
            Setup::best()
        } else {
            Setup {
                period_us: random.one_of(&[1_000, 1_000, 1_000, 1_500]),
                ..Setup::default()
            }
        }),
        12 => Command::Limit(Limits {
            torque_nm: [0.2 + random.below(10) as f32 * 0.1; 2],
            torque_rate_nm_s: random.one_of(&[20.0, 1_000.0]),
            ..Limits::default()
        }),
        13 => Command::ClearFault,
        14 | 15 => Command::Experiment(experiment(random, number)),
        16 => return Action::Silence(random.below(700_000)),
        _ => {
            return Action::Message(random.one_of(&[
                ToBoard::Stop,
                ToBoard::Goodbye,
                ToBoard::Heartbeat,
                ToBoard::Hello(armbridge_link::schema::HELLO),
            ]));
        }
    };
    Action::Command(command)
}

/// A host without any plan on a line that loses some of everything; how many ticks were
/// compared, of how many.
pub fn run(seed: u64) -> (u64, usize) {
    let mut random = Random::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let mut at_us = 100_000 + random.below(100_000);
    let mut acts = Vec::new();
    while at_us < RUN_US {
        acts.push((at_us, act(&mut random, at_us)));
        at_us += random.below(60_000);
    }
    let share = random.one_of(&[0.0, 0.0, 0.001, 0.01]);
    let clock_ms = random.below(20_000);
    let events = tapped_run(
        ScriptedHost::new(acts, RUN_US),
        plant([0.05, -0.05], true),
        seed,
        |now_ms, bench, board| {
            if now_ms == 50 {
                bench.inject(ByteFault {
                    direction: BusDirection::ToMaster,
                    damage: ByteDamage::Lost,
                    share,
                    from_ns: 100_000_000,
                    until_ns: u64::MAX,
                    seed,
                });
            }
            // Now and then the board is late.
            if now_ms == clock_ms {
                board.shift_clock(4_321);
            }
        },
    );
    let report = replay(&events);
    assert_eq!(
        report.differing + report.answers_differing,
        0,
        "seed {seed}: {}",
        report.text()
    );
    (report.compared, records(&events).count())
}
