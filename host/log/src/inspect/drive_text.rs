//! Motions and experiments in words, with every number and its unit.

use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Experiment, Role};
use armbridge_link::motion::{Motion, Via};
use armbridge_servo::JOINTS;

/// A motion, as `minimum-jerk to 0, 0 rad in 2 s`.
pub(super) fn motion(motion: &Motion) -> String {
    match motion {
        Motion::MinimumJerk { to_rad, duration_s } => {
            let when = duration_s.map_or_else(
                || "as soon as the bounds permit".to_owned(),
                |duration_s| format!("in {duration_s} s"),
            );
            format!("minimum-jerk to {} rad {when}", pair(*to_rad))
        }
        Motion::Waypoints(vias) => {
            let points = vias.iter().map_while(Option::as_ref);
            let points: Vec<String> = points
                .map(|Via { at_s, angle_rad }| format!("{} rad at {at_s} s", pair(*angle_rad)))
                .collect();
            format!("waypoints {}", points.join("; "))
        }
        Motion::Sinusoid {
            centre_rad,
            amplitude_rad,
            frequency_hz,
            phase_rad,
            ramp_s,
            duration_s,
        } => format!(
            "sinusoid about {} rad, amplitude {} rad, {} Hz, phase {} rad, ramp {ramp_s} s, \
             for {duration_s} s",
            pair(*centre_rad),
            pair(*amplitude_rad),
            pair(*frequency_hz),
            pair(*phase_rad),
        ),
        Motion::Chirp {
            centre_rad,
            amplitude_rad,
            from_hz,
            to_hz,
            ramp_s,
            duration_s,
        } => format!(
            "chirp about {} rad, amplitude {} rad, from {} to {} Hz, ramp {ramp_s} s, \
             for {duration_s} s",
            pair(*centre_rad),
            pair(*amplitude_rad),
            pair(*from_hz),
            pair(*to_hz),
        ),
    }
}

/// An experiment, joint by joint, each with its envelope.
pub(super) fn experiment(experiment: &Experiment) -> String {
    let envelopes = experiment.angle_rad.iter().zip(&experiment.speed_rad_s);
    let joints = (1..).zip(experiment.roles.iter().zip(envelopes));
    let joints = joints.map(|(joint, (role, ([low, high], speed)))| {
        format!(
            "joint {joint} {}, within {low} to {high} rad and {speed} rad/s",
            driven(role)
        )
    });
    let joints: Vec<String> = joints.collect();
    format!("for {} s: {}", experiment.duration_s, joints.join("; "))
}

fn pair([first, second]: [f32; JOINTS]) -> String {
    format!("{first}, {second}")
}

fn driven(role: &Role) -> String {
    match role {
        Role::Off => "off".into(),
        Role::Hold => "held".into(),
        Role::Pwm(of) => format!("PWM {}", signal(of, "counts")),
        Role::Bias(of) => format!("PWM beside that which holds it, {}", signal(of, "counts")),
        Role::Torque(of) => format!("torque {}", signal(of, "N m")),
        Role::Angle(of) => format!("angle {}", signal(of, "rad")),
    }
}

fn signal(signal: &Signal<f32>, unit: &str) -> String {
    match signal {
        Signal::Constant(value) => format!("constant {value} {unit}"),
        Signal::Triangle {
            offset,
            amplitude,
            period_s,
        } => format!("triangle about {offset}, amplitude {amplitude} {unit}, period {period_s} s"),
        Signal::Staircase {
            from,
            to,
            steps,
            dwell_s,
        } => format!("staircase from {from} to {to} {unit} in {steps} steps, {dwell_s} s each"),
        Signal::Steps {
            first,
            increment,
            steps,
            on_s,
            off_s,
            alternating,
        } => {
            let signs = if *alternating { " of both signs" } else { "" };
            format!(
                "{steps} pulses{signs}, the first {first} {unit}, each {increment} {unit} more, \
                 {on_s} s on and {off_s} s off"
            )
        }
        Signal::Sinusoid {
            offset,
            amplitude,
            frequency_hz,
            ramp_s,
        } => format!(
            "sinusoid about {offset}, amplitude {amplitude} {unit}, {frequency_hz} Hz, \
             ramp {ramp_s} s"
        ),
        Signal::Chirp {
            offset,
            amplitude,
            from_hz,
            to_hz,
            ramp_s,
        } => format!(
            "chirp about {offset}, amplitude {amplitude} {unit}, from {from_hz} to {to_hz} Hz, \
             ramp {ramp_s} s"
        ),
        Signal::Multisine {
            amplitude,
            lowest_hz,
            lines,
            ramp_s,
        } => format!(
            "multisine of {lines} lines {lowest_hz} Hz apart, amplitude {amplitude} {unit}, \
             ramp {ramp_s} s"
        ),
        Signal::Prbs {
            amplitude,
            hold_s,
            seed,
        } => format!("random ±{amplitude} {unit}, held for {hold_s} s each, seed {seed}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_names_and_units() {
        let to_rest = |duration_s| Motion::MinimumJerk {
            to_rad: [0.5, -0.25],
            duration_s,
        };
        assert_eq!(
            motion(&to_rest(Some(1.5))),
            "minimum-jerk to 0.5, -0.25 rad in 1.5 s"
        );
        assert!(motion(&to_rest(None)).ends_with("as soon as the bounds permit"));
        let pulses = Signal::Steps {
            first: 0.01,
            increment: 0.02,
            steps: 20,
            on_s: 0.2,
            off_s: 0.3,
            alternating: true,
        };
        let plan = Experiment {
            roles: [Role::Off, Role::Torque(pulses)],
            duration_s: 10.0,
            angle_rad: [[-0.3, 0.3], [-0.1, 0.1]],
            speed_rad_s: [1.0, 2.0],
        };
        assert_eq!(
            experiment(&plan),
            "for 10 s: joint 1 off, within -0.3 to 0.3 rad and 1 rad/s; joint 2 torque 20 pulses \
             of both signs, the first 0.01 N m, each 0.02 N m more, 0.2 s on and 0.3 s off, \
             within -0.1 to 0.1 rad and 2 rad/s"
        );
    }
}
