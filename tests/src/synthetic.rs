//! Records of a run that never was: a linear two-joint arm under state
//! feedback at 1 kHz, three setpoints, 10 s, encoder counts and stiction.
//!
//! Made here and not on the bench, so that what is reported is tested against
//! numbers that are known beforehand and does not change when the bench does.

use armbridge_control::estimate::Config;
use armbridge_link::message::{
    Controller, Drive, Gains, Missing, Mode, Record, Sample, Setup, TickInput, TickOutput, Timing,
};
use armbridge_log::run_info::RunFacts;

/// Angle of one encoder count: 300 degrees over 1023 counts.
pub const RAD_PER_COUNT: f64 = 300.0 / 1023.0 * std::f64::consts::PI / 180.0;

/// Inertia, damping and gravity of each joint about upright, and its gains.
const ARM: [[f64; 5]; 2] = [
    [0.0306, 0.24, 0.571, 1.65, 0.22],
    [0.0236, 0.16, 0.181, 1.10, 0.20],
];

/// References and the tick from which each holds.
pub const SETPOINTS: [(u32, [f32; 2]); 3] = [
    (0, [0.0, 0.0]),
    (4000, [0.15, -0.10]),
    (7000, [-0.10, 0.20]),
];

/// Facts of the synthetic run.
pub fn facts(friction_nm: Option<f64>) -> RunFacts {
    RunFacts {
        name: "demo".into(),
        world: "simulated: bench".into(),
        version: "0.1.0".into(),
        seed: Some(1),
        period_us: 1000,
        setup: Setup {
            period_us: 1000,
            controller: Controller::StateFeedback(Gains::Paper),
            estimator: Config::FiniteDifference { filter_s: 0.02 },
            ..Setup::default()
        },
        rad_per_count: [RAD_PER_COUNT; 2],
        zero_count: [512.0; 2],
        torque_limits_nm: [[-1.217, 1.181]; 2],
        static_friction_nm: friction_nm.map(|nm| [nm; 2]),
        stiction_offset_mrad: friction_nm.map(|nm| ARM.map(|[_, _, g, k, _]| nm / (k - g) * 1e3)),
    }
}

/// A cheap repeatable noise in 0..1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// State of one joint of the synthetic arm.
struct Joint {
    q: f64,
    dq: f64,
    angle: f64,
    speed: f64,
    torque: f64,
    pwm: u16,
}

/// The run: 10 s at 1 kHz after 20 ticks of bring-up.
pub fn run(friction_nm: f64) -> Vec<Record> {
    let mut noise = Noise(1);
    let mut joints = [0.30, -0.25].map(|q| Joint {
        q,
        dq: 0.0,
        angle: q,
        speed: 0.0,
        torque: 0.0,
        pwm: 1000,
    });
    let tick = |k: u32| {
        let (up, tick) = (k >= 20, k.saturating_sub(20));
        let reference = SETPOINTS
            .iter()
            .rev()
            .find(|(from, _)| tick >= *from)
            .unwrap()
            .1;
        let pwm_in_force = [joints[0].pwm, joints[1].pwm];
        let samples = std::array::from_fn(|j| {
            let [inertia, damping, gravity, kp, kd] = ARM[j];
            let joint = &mut joints[j];
            for _ in 0..10 {
                let drive = joint.torque + gravity * joint.q - damping * joint.dq;
                let stuck = joint.dq.abs() < 1e-3 && drive.abs() < friction_nm;
                let loss = joint.dq.signum() * friction_nm * 0.667;
                joint.dq = if stuck {
                    0.0
                } else {
                    joint.dq + (drive - loss) / inertia * 1e-4
                };
                joint.q += joint.dq * 1e-4;
            }
            if !up {
                (joint.q, joint.dq) = ([0.30, -0.25][j], 0.0);
                return Sample::Missing(Missing::NotAsked);
            }
            let count = (512.0 + joint.q / RAD_PER_COUNT + noise.next() - 0.5).round();
            let sample = (count - 512.0) * RAD_PER_COUNT;
            let before = joint.angle;
            joint.angle += 0.1 * (sample - joint.angle);
            joint.speed += 0.05 * ((joint.angle - before) * 1e3 - joint.speed);
            let reference = f64::from(reference[j]);
            let demand = -kp * (joint.angle - reference) - kd * joint.speed - gravity * reference;
            joint.pwm = (1015.0 + 834.0 * demand).round().clamp(0.0, 2000.0) as u16;
            joint.torque = (f64::from(joint.pwm) - 1015.0) / 834.0;
            if noise.next() < 3e-4 {
                return Sample::Missing(Missing::BadChecksum);
            }
            Sample::Counts(count as u16)
        });
        let start_error_us = if noise.next() < 0.02 {
            1 + (noise.next() * 6.0) as u32
        } else {
            0
        };
        Record {
            tick: k,
            mode: if up {
                Mode::Running(Drive::Regulate)
            } else {
                Mode::Boot
            },
            timing: Timing {
                start_error_us,
                bus_us: 470 + (noise.next() * 25.0) as u32,
                compute_ns: 1500 + (noise.next().powi(20) * 20_000.0) as u32,
                missed: 0,
            },
            input: TickInput {
                start_us: u64::from(k) * 1000 + u64::from(start_error_us),
                samples,
                pwm_in_force,
                ..TickInput::AT_REST
            },
            output: TickOutput {
                pwm: [joints[0].pwm, joints[1].pwm],
                reference_rad: if up { reference } else { [0.0; 2] },
                angle_rad: [joints[0].angle as f32, joints[1].angle as f32],
                speed_rad_s: [joints[0].speed as f32, joints[1].speed as f32],
                torque_nm: [joints[0].torque as f32, joints[1].torque as f32],
                ..TickOutput::NONE
            },
            ..Record::NONE
        }
    };
    (0..10_020).map(tick).collect()
}
