//! Run-up and run-out of a motion that begins or ends with a speed: a smooth path from rest
//! to that speed and acceleration.

use armbridge_servo::JOINTS;

use super::resample::{Joints, Knot, intervals};

/// Speed in rad/s below which a motion begins at rest.
const REST_RAD_S: f64 = 0.005;

/// Points from rest to a speed and an acceleration at time 0, without that point; empty if
/// there is none to reach.
pub(super) fn run_up(to: &Knot, spacing_s: f64, acceleration_rad_s2: f64) -> Vec<Knot> {
    /// Shortest run-up in s.
    const LEAST_S: f64 = 0.3;
    /// Share of the permitted acceleration.
    const SHARE: f64 = 0.5;

    let largest = |values: &Joints| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let (speed, acceleration) = (largest(&to.dq), largest(&to.ddq));
    if speed < REST_RAD_S {
        return Vec::new();
    }
    // The speed grows by a smooth step, whose steepest slope is 1.875 times the mean.
    let room = (SHARE * acceleration_rad_s2 - acceleration).max(0.2 * acceleration_rad_s2);
    let length_s = (1.875 * speed / room).max(LEAST_S).max(2.0 * spacing_s);
    let count = intervals(length_s, spacing_s);
    let knot = |number: u32| {
        let x = f64::from(number) / count;
        // Integral, value and slope of the smooth step, and of x³ - x², which ends with a
        // slope of 1: the acceleration.
        let step = [
            x.powi(4) * (2.5 + x * (-3.0 + x)) - 0.5,
            x.powi(3) * (10.0 + x * (-15.0 + 6.0 * x)),
            30.0 * x * x * (1.0 - x).powi(2),
        ];
        let bend = [
            x.powi(3) * (0.25 * x - 1.0 / 3.0) + 1.0 / 12.0,
            x * x * (x - 1.0),
            x * (3.0 * x - 2.0),
        ];
        let mut knot = Knot {
            at_s: to.at_s - length_s * (1.0 - x),
            ..*to
        };
        for joint in 0..JOINTS {
            let (v, a) = (to.dq[joint], to.ddq[joint]);
            knot.q[joint] += length_s * (v * step[0] + a * length_s * bend[0]);
            knot.dq[joint] = v * step[1] + a * length_s * bend[1];
            knot.ddq[joint] = v * step[2] / length_s + a * bend[2];
        }
        knot
    };
    (0..count as u32).map(knot).collect()
}

/// Points from a speed to rest, without that at which it begins: a run-up in reverse.
pub(super) fn run_out(from: &Knot, spacing_s: f64, acceleration_rad_s2: f64) -> Vec<Knot> {
    let reversed = |knot: &Knot| Knot {
        at_s: -knot.at_s,
        dq: knot.dq.map(|speed| -speed),
        ..*knot
    };
    let knots = run_up(&reversed(from), spacing_s, acceleration_rad_s2);
    knots.iter().rev().map(reversed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_up_reaches_speed_and_acceleration_from_rest() {
        let to = Knot {
            at_s: 0.0,
            q: [0.2, 0.0],
            dq: [0.0, 0.63],
            ddq: [-1.97, 0.0],
        };
        let knots = run_up(&to, 0.002, 20.0);
        let first = knots[0];
        assert!(
            first.dq.iter().chain(&first.ddq).all(|x| x.abs() < 1e-12),
            "{first:?}"
        );
        // Each point follows from the one before by its derivatives.
        for pair in knots.iter().chain([&to]).collect::<Vec<_>>().windows(2) {
            let dt = pair[1].at_s - pair[0].at_s;
            for joint in 0..JOINTS {
                let mean = 0.5 * (pair[0].dq[joint] + pair[1].dq[joint]);
                let moved = pair[1].q[joint] - pair[0].q[joint];
                assert!((moved - mean * dt).abs() < 1e-4 * dt, "{pair:?}");
                let mean = 0.5 * (pair[0].ddq[joint] + pair[1].ddq[joint]);
                let gained = pair[1].dq[joint] - pair[0].dq[joint];
                assert!((gained - mean * dt).abs() < 2e-2 * dt, "{pair:?}");
            }
        }
        let out = run_out(&to, 0.01, 20.0);
        let last = out[out.len() - 1];
        assert!(
            last.at_s > 0.29 && last.dq.iter().all(|x| x.abs() < 1e-12),
            "{last:?}"
        );
        let at_rest = Knot {
            dq: [0.0; JOINTS],
            ..to
        };
        assert!(run_up(&at_rest, 0.01, 20.0).is_empty());
    }
}
