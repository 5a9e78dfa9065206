//! Configuration of the virtual arm.

use core::f64::consts::FRAC_PI_2;

use armbridge_control::actuator::Joint;
use armbridge_control::arm::{Parameters, State};
use armbridge_control::encoder::Encoder;
use armbridge_link::message::{Settings, Setup};
use armbridge_servo::protocol2::model::{self, Model};
use armbridge_servo::{ControlMode, Firmware, JOINTS, Pwm};
use nalgebra::Vector2;

use super::body::Friction;

/// A virtual arm. The default is the bench's: the paper's arm and servos, with
/// dry friction, one count of sensor noise, upright and held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantConfig {
    /// The arm's true parameters, before the two scales below.
    pub arm: Parameters<f64>,
    /// Factor on mass matrix and Coriolis torque.
    pub inertia_scale: f64,
    /// Factor on the gravity torque.
    pub gravity_scale: f64,
    /// The servos' true calibration. Dead-zone compensation is ignored.
    pub joints: [Joint<f64>; JOINTS],
    /// Whether there is dry friction.
    pub friction_on: bool,
    /// Dry friction of each joint, if there is any.
    pub friction: [Friction; JOINTS],
    /// PWM counts below and above off up to which each servo gives no torque:
    /// none for `1000 - below <= PWM <= 1000 + above`.
    pub dead_zone_counts: [[u16; 2]; JOINTS],
    /// Time in ns from a PWM's arrival in each servo to its torque.
    pub input_delay_ns: [u64; JOINTS],
    /// Factor on every motor torque: supply voltage, or a wrong 834.
    pub torque_gain: f64,
    /// PWM counts by which the motors' true zero lies above the calibrated one.
    pub pwm_offset_counts: f64,
    /// Largest motor torque in N m.
    pub torque_limit_nm: f64,
    /// Smallest and largest angle of each joint in rad.
    pub stops_rad: [[f64; 2]; JOINTS],
    /// Model of the servos if they are of the X series.
    pub x_servo: &'static Model,
    /// Standard deviation of the encoders' noise in counts.
    pub noise_lsb_rms: f64,
    /// State at time zero.
    pub initial: State<f64>,
    /// The arm is held where it is until a servo receives a PWM more than a count from 1000,
    /// which a stop sequence does not have.
    pub held: bool,
}

impl Default for PlantConfig {
    fn default() -> Self {
        // 0.06 N m are the 50 PWM counts of the paper's dead zone; a sliding
        // gear takes about two thirds of that.
        let friction = Friction {
            coulomb_nm: 0.04,
            static_nm: 0.06,
            stribeck_rad_s: 0.0,
            load: 0.0,
        };
        Self {
            arm: Parameters::paper(),
            inertia_scale: 1.0,
            gravity_scale: 1.0,
            joints: [Joint::paper(); JOINTS],
            friction_on: true,
            friction: [friction; JOINTS],
            dead_zone_counts: [[0; 2]; JOINTS],
            input_delay_ns: [0; JOINTS],
            torque_gain: 1.0,
            pwm_offset_counts: 0.0,
            // Stall torque of an AX-12A at 12 V; larger than that of equation (5).
            torque_limit_nm: 1.5,
            // The table stops joint 1; the servo's 300 degree stop joint 2.
            stops_rad: [
                [-FRAC_PI_2, FRAC_PI_2],
                [-150_f64.to_radians(), 150_f64.to_radians()],
            ],
            x_servo: &model::XL430_W250,
            noise_lsb_rms: 1.0,
            initial: State::at_rest(Vector2::zeros()),
            held: true,
        }
    }
}

/// The number that a board's number of single precision was rounded from, as far as it shows.
fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| value.into())
}

impl PlantConfig {
    /// The dead zone that the paper describes: no torque for 950 < PWM < 1050.
    pub const PAPER_DEAD_ZONE_COUNTS: [u16; 2] = [49, 49];

    /// The arm that a board with these settings takes its own for: without dead zones and delays, and
    /// with as much static friction as Coulomb friction, both with the load friction of the settings.
    ///
    /// A plant's motors have a duty. If the board's commands are currents, its servos are of the
    /// model with the nearest torque per count, and their back-EMF adds to the viscous friction.
    pub fn of_board(settings: &Settings) -> Self {
        let setup = &settings.setup;
        let load = setup.friction_load_percent.map(f64::from);
        let friction = core::array::from_fn(|joint| Friction {
            coulomb_nm: decimal(setup.friction_nm[joint]),
            static_nm: decimal(setup.friction_nm[joint]),
            stribeck_rad_s: 0.0,
            load: load[joint] / 100.0,
        });
        let plant = Self {
            arm: setup.arm.map(decimal),
            joints: setup.joints.map(|joint| Joint {
                zero_count: decimal(joint.zero_count),
                rad_per_count: decimal(joint.rad_per_count),
                direction: joint.direction,
                gain_counts_per_nm: decimal(joint.gain_counts_per_nm),
                offset_counts: decimal(joint.offset_counts),
            }),
            friction_on: friction != [Friction::NONE; JOINTS],
            friction,
            ..Self::default()
        };
        if setup.control_mode == ControlMode::Current {
            let model = Model::nearest_by_current(setup.joints[0].gain_counts_per_nm);
            return plant.driven_by_duty(model.unwrap_or(plant.x_servo));
        }
        plant
    }

    /// This set-up of a board that knows the arm, its servos and its friction.
    #[must_use]
    pub fn board_setup(&self, setup: Setup) -> Setup {
        Setup {
            arm: self.arm.map(|number| number as f32),
            joints: self.joints.map(|joint| Joint {
                zero_count: joint.zero_count as f32,
                rad_per_count: joint.rad_per_count as f32,
                direction: joint.direction,
                gain_counts_per_nm: joint.gain_counts_per_nm as f32,
                offset_counts: joint.offset_counts as f32,
            }),
            friction_nm: self.friction.map(|friction| friction.coulomb_nm as f32),
            friction_load_percent: self
                .friction
                .map(|friction| (friction.load * 100.0).round() as u8),
            ..setup
        }
    }

    /// With servos of this model, which turns a command into a duty by itself; their motors have its
    /// torque and back-EMF.
    #[must_use]
    pub fn driven_by_duty(mut self, model: &'static Model) -> Self {
        self.x_servo = model;
        self.torque_limit_nm = decimal(model.stall_nm);
        for joint in &mut self.joints {
            joint.gain_counts_per_nm = decimal(model.pwm_counts_per_nm());
        }
        let back_emf = decimal(model.back_emf_nm_s());
        self.arm.b1 += back_emf;
        self.arm.b2 += back_emf;
        self
    }

    /// Firmware of the servos whose encoders this arm has; that of AX-12A is Morpheus.
    pub fn firmware(&self) -> Firmware {
        match self.joints[0].encoder() {
            Some(Encoder::XSeries) => Firmware::XSeries,
            Some(Encoder::Ax12a) | None => Firmware::Morpheus,
        }
    }

    /// The same arm with servos of this firmware, if it has others: their encoders, at zero in the middle, and
    /// for the X series the motors of its model.
    #[must_use]
    pub fn with_servos(mut self, firmware: Firmware) -> Self {
        let encoder = Encoder::of(firmware);
        for joint in &mut self.joints {
            if joint.encoder() == Some(encoder) {
                continue;
            }
            *joint = match encoder {
                Encoder::Ax12a => Joint::paper(),
                Encoder::XSeries => Joint {
                    gain_counts_per_nm: decimal(self.x_servo.pwm_counts_per_nm()),
                    ..Joint::x_series()
                },
            };
        }
        self
    }

    /// True parameters of the arm, with both scales.
    pub fn true_arm(&self) -> Parameters<f64> {
        let (arm, scale) = (self.arm, self.inertia_scale);
        Parameters {
            m1: arm.m1 * scale,
            m2: arm.m2 * scale,
            // Gravity torque is mass times g: the masses' scale must not show.
            g: arm.g * self.gravity_scale / scale,
            i1x: arm.i1x * scale,
            i1y: arm.i1y * scale,
            i1z: arm.i1z * scale,
            i2x: arm.i2x * scale,
            i2y: arm.i2y * scale,
            i2z: arm.i2z * scale,
            ..arm
        }
    }

    /// Static friction of each joint in N m; none if it has no dry friction.
    pub fn static_friction_nm(&self) -> Option<[f64; JOINTS]> {
        self.friction_on
            .then(|| self.friction.map(|friction| friction.static_nm))
    }

    pub(super) fn true_friction(&self) -> [Friction; JOINTS] {
        if self.friction_on {
            self.friction
        } else {
            [Friction::NONE; JOINTS]
        }
    }

    /// Joint torque in N m of a servo at a PWM: equation (5) with the motor's true zero
    /// and gain.
    pub(super) fn torque(&self, servo: usize, pwm: u16) -> f64 {
        let off = Pwm::OFF.counts();
        let [below, above] = self.dead_zone_counts[servo];
        if off.saturating_sub(below) <= pwm && pwm <= off.saturating_add(above) {
            return 0.0;
        }
        let calibrated = self.joints[servo];
        let motor = Joint {
            offset_counts: calibrated.offset_counts + self.pwm_offset_counts,
            ..calibrated
        };
        let torque_nm = motor.torque(Pwm::saturating(pwm)) * self.torque_gain;
        torque_nm.clamp(-self.torque_limit_nm, self.torque_limit_nm)
    }
}
