//! A free run: the arm that was found, simulated with all it has, dry friction and dead
//! zones too, by the PWM that a log has and nothing else of it.
//!
//! It begins where both joints rest, at the mean of what their encoders said in 0.1 s, and
//! lasts 5 s at most. An arm that stands falls away from where it is thought to be as fast as
//! its pole is unstable: a run is judged until the pole has made a count of the standard
//! error of that mean, a tenth of a count: for `ln 10` of the time constant.

use armbridge::bench::plant::{Friction, Plant, PlantConfig};
use armbridge::identify::{Found, Quantity};
use armbridge_shared::JOINTS;
use armbridge_shared::actuator::Joint;
use armbridge_shared::arm::State;
use armbridge_shared::link::message::{Drive, Record, Setup};
use nalgebra::Vector2;

/// Most ticks of a run.
const TICKS: usize = 5_000;
/// Ticks over whose mean it begins.
const REST: usize = 100;
/// A tick in ns.
const TICK_NS: u64 = 1_000_000;

/// The arm that was found, as a board is told it, and with what only the bench can use.
pub(crate) fn model(told: &Setup, found: &Found) -> PlantConfig {
    let number = |joint: usize, quantity: Quantity| found.number(joint, quantity).0;
    let counts = |joint: usize, quantity| number(joint, quantity).round() as u16;
    PlantConfig {
        arm: told.arm.map(f64::from),
        joints: told.joints.map(|joint| Joint {
            zero_count: joint.zero_count.into(),
            rad_per_count: joint.rad_per_count.into(),
            direction: joint.direction,
            gain_counts_per_nm: joint.gain_counts_per_nm.into(),
            offset_counts: joint.offset_counts.into(),
        }),
        friction: core::array::from_fn(|joint| {
            let coulomb_nm = number(joint, Quantity::Coulomb);
            let static_nm = found.friction[joint].map_or(coulomb_nm, |of| of.torque_nm);
            Friction {
                coulomb_nm,
                static_nm: static_nm.max(coulomb_nm),
                stribeck_rad_s: 0.0,
            }
        }),
        dead_zone_counts: core::array::from_fn(|joint| {
            [Quantity::DeadBelow, Quantity::DeadAbove].map(|edge| counts(joint, edge))
        }),
        input_delay_ns: core::array::from_fn(|joint| {
            (number(joint, Quantity::Delay).max(0.0) * 1e9) as u64
        }),
        noise_lsb_rms: 0.0,
        held: false,
        ..PlantConfig::default()
    }
}

/// Free runs from the beginning of every experiment of a log, of an arm whose unstable pole
/// has this time constant: their length in s, and of each the root mean square of measured
/// less simulated in counts, without the encoder's noise. The least comes first.
pub(crate) fn free_runs(model: &PlantConfig, records: &[Record], pole_s: f64) -> (f64, Vec<f64>) {
    let lasts_s = pole_s * (REST as f64).sqrt().ln();
    let ticks = ((lasts_s * 1e3) as usize).min(TICKS);
    let is_one = |record: &Record| record.mode.drive() == Some(Drive::Experiment);
    let begins = (REST..records.len().saturating_sub(TICKS))
        .filter(|&k| is_one(&records[k]) && !is_one(&records[k - 1]));
    let noise = 1.0 + 1.0 / 12.0;
    let rms = |squares: f64| (squares / (JOINTS * ticks) as f64 - noise).max(0.0).sqrt();
    let runs = begins.filter_map(|begin| free_run(model, records, begin, ticks));
    let mut runs: Vec<f64> = runs.map(rms).collect();
    runs.sort_by(f64::total_cmp);
    (lasts_s, runs)
}

/// Sum of the squares of both joints' errors in so many ticks; none if the arm does not rest
/// there.
fn free_run(model: &PlantConfig, records: &[Record], begin: usize, ticks: usize) -> Option<f64> {
    let counts = |k: usize, joint: usize| records[k].samples[joint].counts().map(f64::from);
    let mut start = [0.0; JOINTS];
    for (joint, start) in start.iter_mut().enumerate() {
        let rest: Option<Vec<f64>> = (begin - REST..begin).map(|k| counts(k, joint)).collect();
        let rest = rest?;
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let (early, late) = rest.split_at(REST / 2);
        if (mean(early) - mean(late)).abs() > 0.8 {
            return None;
        }
        *start = mean(&rest);
    }
    let angle = |joint: usize| {
        let servo = model.joints[joint];
        (start[joint] - servo.position(0.0)) / (servo.position(1.0) - servo.position(0.0))
    };
    let initial = State::at_rest(Vector2::new(angle(0), angle(1)));
    let mut run = Plant::new(PlantConfig { initial, ..*model }, 1);
    let mut squares = 0.0;
    for tick in 0..ticks {
        let (record, now_ns) = (&records[begin + tick], tick as u64 * TICK_NS);
        for joint in 0..JOINTS {
            run.drive(joint, now_ns, record.pwm_in_force[joint]);
        }
        run.advance(now_ns);
        let state = run.state();
        for joint in 0..JOINTS {
            let position = model.joints[joint].position(state.q[joint]);
            squares += (counts(begin + tick, joint)? - position).powi(2);
        }
    }
    Some(squares)
}
