//! Balances the two-joint arm upright: a Kalman filter and an LQR at 1 kHz, simulated in `f64`.
//!
//! ```text
//! cargo run --package armbridge-control --example pendulum
//! ```
//!
//! The simulated arm is integrated in steps of 0.1 ms. Its servos are as real ones are: angles
//! are whole encoder counts of 5 mrad, torques whole counts of PWM that act one period after
//! the samples from which they are computed. From 2 s on a disturbance of 0.1 N m acts on joint
//! 1: the filter estimates it, and the controller subtracts the estimate.

use armbridge_control::actuator::Joint;
use armbridge_control::arm::{Parameters, State};
use armbridge_control::controller::{Lqr, Setpoint, Weights};
use armbridge_control::estimate::{Config, Tuning};
use nalgebra::Vector2;

/// Period of the loop.
const PERIOD_S: f64 = 1e-3;
/// Steps of the simulation in a period.
const STEPS: u32 = 10;
/// Ticks of the simulation.
const TICKS: u32 = 4_000;
/// Tick at which the push begins.
const PUSHED_FROM: u32 = 2_000;
/// Largest distance of a PWM from off.
const PWM_MAX: u16 = 1_000;

fn main() {
    let arm = Parameters::<f64>::paper();
    let servo = Joint::<f64>::paper();
    let upright = Vector2::zeros();

    let model = arm.linearise(upright).zero_order_hold(PERIOD_S);
    let lqr = Lqr::design(&model, &Weights::paper()).expect("the arm can be stabilised");
    let setpoint = Setpoint::new(&arm, upright);
    // This arm has no dry friction.
    let tuning = Tuning {
        coulomb_nm: 0.0,
        ..Tuning::standing()
    };
    let filter = Config::Kalman(tuning).build(&arm, PERIOD_S);
    let filter = filter.expect("the tuning is valid");

    let mut plant = State::at_rest(Vector2::new(0.2, -0.15));
    let counts = |q: f64| servo.position(q).round() as u16;
    let mut estimate = filter.at_rest(plant.q.map(|q| servo.angle(counts(q))));
    let mut torque_nm = Vector2::zeros();

    println!("   time     q1     q2  torque 1  disturbance 1");
    for tick in 0..=TICKS {
        // The samples of this tick, and the state at the next one, until which the torque acts
        // that was decided in the tick before.
        let samples = [plant.q.x, plant.q.y].map(|q| Some(servo.angle(counts(q))));
        filter.correct(&mut estimate, samples);
        let ahead = filter.advance(&arm, &mut estimate, torque_nm);
        if tick % 250 == 0 {
            println!(
                "{:5.2} s {:6.1} {:6.1} mrad {:5.3} {:11.3} N m",
                f64::from(tick) * PERIOD_S,
                plant.q.x * 1e3,
                plant.q.y * 1e3,
                torque_nm.x,
                estimate.disturbance().x,
            );
        }

        let push = if tick < PUSHED_FROM { 0.0 } else { 0.1 };
        let acting_nm = torque_nm + Vector2::new(push, 0.0);
        for _ in 0..STEPS {
            let step_s = PERIOD_S / f64::from(STEPS);
            plant.dq += arm.acceleration(&plant, acting_nm) * step_s;
            plant.q += plant.dq * step_s;
        }

        let wanted_nm = lqr.torque(&ahead, &setpoint) - estimate.disturbance();
        torque_nm = wanted_nm.map(|nm| {
            let command = servo.command(nm, PWM_MAX).expect("the torque is finite");
            command.torque_nm
        });
    }
    assert!(plant.q.amax() < 0.01, "it does not stand: {}", plant.q);
    assert!((estimate.disturbance().x - 0.1).abs() < 0.02);
    println!("the arm stands");
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_arm_stands() {
        super::main();
    }
}
