//! A case: set-up, activity and injected faults, derived from the seed.
//!
//! Seed 2k has one fault, seed 2k + 1 a pair. Kinds, pairs and activities alternate, so
//! that any sequence of seeds covers all evenly: 58 kinds in twelve activities are 696
//! singles, and there are 1653 pairs. All other properties are random.

mod variants;

use armbridge_board::tick::limits::CHECK_PERIOD_MAX_US;
use armbridge_control::actuator::{Direction, Joint};
use armbridge_control::arm::State;
use armbridge_control::encoder::Encoder;
use armbridge_link::limits::Milliradians;
use armbridge_link::message::{Command, Limits, Setup};
use armbridge_servo::protocol2::model::{self, Model};
use armbridge_servo::{ControlMode, Firmware, JOINTS};
use nalgebra::Vector2;
use serde::Serialize;

use super::activity::Activity;
use super::draw::Random;
use super::expect::STOP_US;
use super::injection::{Injection, Origin, draw_injection};
use super::kind::Kind;
use super::lead::LED_US;
use super::set_up::{Bus, SetUp};
use crate::plant::PlantConfig;

/// Observation time of a fault, in µs: three times the longest time that a limit
/// permits, which is the host's silence.
const OBSERVATION_US: u64 = 1_500_000;
/// The same where the board may take its time: a Morpheus servo reads its temperature every
/// 0.8 s, and a constant torque ends after 2 s.
const OBSERVATION_SLOW_US: u64 = 3_000_000;
/// The same for a drift of 5 to 50 counts a second.
const OBSERVATION_DRIFT_US: u64 = 6_000_000;
/// Ticks in which an encoder that has stopped must show.
const OBSERVED_TICKS: u64 = 600;
/// Bytes of a stop sequence, and of the rest of a packet that a servo waits for.
const STOP_BYTES: u64 = 270;
const REST_BYTES: u64 = 254;
/// Slowest speed that boards search servos at.
const SLOWEST_BAUD: u32 = 57_600;
/// Time in µs, and ticks beside it, until each servo's temperature has been read: there may be
/// no slot for it for a second.
const POLL_US: u64 = 1_500_000;
const POLL_TICKS: u64 = 70;
/// Servos that are driven by current: strong enough for the paper's arm, to whose viscous friction
/// their back-EMF adds.
const BY_CURRENT: &Model = &model::XM430_W210;
/// Distance in rad of obstacles from where the arm begins.
const OBSTACLE_RAD: f64 = 0.05;

/// One run.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is drawn independently, and they do not exclude each other"
)]
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// Seed of everything but the servos.
    pub seed: u64,
    /// Servos and the speed of their bus.
    pub bus: Bus,
    /// Period, estimator and controller.
    pub set_up: SetUp,
    /// Work of the board.
    pub activity: Activity,
    /// Dry friction in the joints.
    pub friction: bool,
    /// Obstacles are on both sides of the arm.
    pub is_obstructed: bool,
    /// Tighter limits than the default.
    pub is_tight: bool,
    /// The fault is cleared at the end.
    pub is_cleared: bool,
    /// Initial joint angles, in rad.
    pub initial_rad: [f64; JOINTS],
    /// Target angles, or amplitudes, in rad.
    pub to_rad: [f32; JOINTS],
    /// Injected faults.
    pub injections: Vec<Injection>,
    /// Standard deviation of the encoders' noise, in counts.
    pub noise_counts: f64,
    /// Pose in which the arm is parked, in mrad, if it has one.
    pub pose: Option<[i16; JOINTS]>,
    /// A hand leads the arm to its target angles and the opposite ones, to and fro, from where it
    /// began; faults come meanwhile.
    pub is_led: bool,
}

impl Case {
    /// The case of a seed.
    pub fn new(seed: u64) -> Self {
        Self::with_activity(seed, None)
    }

    /// The case of a seed, with this work of the board instead of the drawn one.
    pub fn with_activity(seed: u64, activity: Option<Activity>) -> Self {
        let mut draw = Random::new(seed);
        let index = seed / 2;
        let activities = Activity::DRAWN.len() as u64;
        let (kinds, rounds) = if seed.is_multiple_of(2) {
            let kinds = Kind::ALL.len() as u64;
            // Neighbours in one round have other activities as well.
            (
                vec![Kind::ALL[(index % kinds) as usize]],
                index / kinds + index,
            )
        } else {
            let (a, b, pairs) = pair(index);
            // The next occurrence of a pair has another activity.
            (vec![a, b], 2 * (index / pairs) + index)
        };
        let drawn = Activity::DRAWN[(rounds % activities) as usize];
        let activity = activity.unwrap_or(drawn);
        let can_do = |bus: &Bus| !bus.set_ups(activity).is_empty();
        let buses: Vec<Bus> = Bus::all().filter(can_do).collect();
        let bus = buses[draw.below(buses.len() as u64) as usize];
        let set_ups = bus.set_ups(activity);
        let set_up = set_ups[draw.below(set_ups.len() as u64) as usize];
        // Without a closed loop only friction holds the arm.
        let holds = !activity.is_balanced();
        let reach = if holds { 0.02 } else { 0.2 };
        let mut angles = |reach: f64| [0; JOINTS].map(|_| draw.uniform(-reach, reach));
        let (initial_rad, to_rad) = (angles(reach), angles(0.25).map(|q| q as f32));
        let is_early = activity == Activity::BringUp || draw.below(8) == 0;
        let origin = if is_early {
            Origin::PowerUp
        } else {
            Origin::Ready
        };
        let first_us = if is_early {
            draw.log_uniform_us(0.1, 100.0)
        } else {
            draw.log_uniform_us(1.0, 4_000.0)
        };
        let mut injections: Vec<Injection> = Vec::new();
        for (nth, kind) in kinds.into_iter().enumerate() {
            let later_us = if nth == 0 { 0 } else { draw.below(100_000) };
            let (origin, after_us) = if kind.is_from_start() {
                (Origin::PowerUp, 0)
            } else {
                (origin, first_us + later_us)
            };
            injections.push(draw_injection(kind, origin, after_us, &mut draw));
        }
        let friction = draw.coin() || holds;
        let is_obstructed = draw.coin() && activity.can_press();
        // Other limits are set by the host, where it sets any.
        let is_tight = draw.below(4) == 0
            && activity != Activity::Port
            && injections.iter().all(|it| it.kind != Kind::FlashRot);
        let is_cleared = draw.coin();
        // The last draws: another distribution of them changes nothing else of a case.
        let noise_counts = draw_noise_counts(&mut draw);
        let is_led = draw.coin() && activity == Activity::Float;
        let late = injections
            .iter_mut()
            .filter(|it| is_led && it.origin == Origin::Ready);
        late.for_each(|it| it.after_us += LED_US);
        Self {
            seed,
            bus,
            set_up,
            activity,
            friction,
            is_obstructed,
            is_tight,
            is_cleared,
            initial_rad,
            to_rad,
            injections,
            noise_counts,
            pose: None,
            is_led,
        }
    }

    /// Counts of an AX-12A's encoder that are as large an angle as these of the servos'.
    pub(super) fn ax12a_counts(&self, counts: f64) -> f64 {
        let rad_per_count = Encoder::of(self.servos()).nominal_rad_per_count();
        counts * rad_per_count / Encoder::Ax12a.nominal_rad_per_count()
    }

    /// Firmware of the servos.
    pub fn servos(&self) -> Firmware {
        self.bus.servos
    }

    /// Calibration of the servos, as the board has it.
    fn joints(&self) -> [Joint<f32>; JOINTS] {
        let own = match Encoder::of(self.servos()) {
            Encoder::Ax12a => Setup::default().joints,
            Encoder::XSeries => [Joint::x_series(); JOINTS],
        };
        match (self.bus.mode, BY_CURRENT.current) {
            (ControlMode::Current, Some(current)) => own.map(|joint| Joint {
                gain_counts_per_nm: current.counts_per_nm(),
                ..joint
            }),
            (ControlMode::Current, None) | (ControlMode::Pwm, _) => own,
        }
    }

    /// Parameters of the board that are right for the arm.
    pub(super) fn right_setup(&self) -> Setup {
        let mut setup = self.set_up.setup();
        setup.control_mode = self.bus.mode;
        setup.joints = self.joints();
        if let Some(rot) = self.find(Kind::FlashRot) {
            // The saved settings differ from the default in what matters most.
            setup.joints[rot.servo].direction = Direction::Reverse;
        }
        setup
    }

    /// Parameters that the host sets.
    pub fn setup(&self) -> Setup {
        let mut setup = self.right_setup();
        for injection in &self.injections {
            let joint = &mut setup.joints[injection.servo];
            match injection.kind {
                Kind::CalibrationScale => joint.rad_per_count *= injection.amount as f32,
                Kind::CalibrationZero => joint.zero_count += injection.amount as f32,
                Kind::CalibrationDirection => joint.direction = Direction::Reverse,
                _ => {}
            }
        }
        setup
    }

    /// Limits of the board.
    pub fn limits(&self) -> Limits {
        let mut limits = Limits {
            park: self.pose.map(|pose| pose.map(Milliradians)),
            ..Limits::default()
        };
        if self.is_tight {
            limits.pwm_counts = 800;
            limits.torque_nm = [0.8; JOINTS];
            limits.torque_age_ms = 1_000;
        }
        if self.set_up.period_us > CHECK_PERIOD_MAX_US {
            // The motors cannot be checked, and the host confirms it.
            limits.check_rad_s2 = 0;
        }
        limits
    }

    /// Whether the host sets parameters and limits: not where it relies on saved ones, and not
    /// before a client comes, for a command keeps clients off the bus.
    pub(super) fn is_configured(&self) -> bool {
        self.activity != Activity::Port && !self.has(Kind::FlashRot)
    }

    /// The virtual arm.
    pub fn plant(&self) -> PlantConfig {
        let plant = PlantConfig {
            friction_on: self.friction,
            initial: State::at_rest(Vector2::from(self.initial_rad)),
            noise_lsb_rms: self.noise_counts,
            ..PlantConfig::default()
        };
        let plant = match self.bus.mode {
            ControlMode::Pwm => plant,
            ControlMode::Current => plant.driven_by_duty(BY_CURRENT),
        };
        let mut joints = match Encoder::of(self.servos()) {
            Encoder::Ax12a => plant.joints,
            Encoder::XSeries => plant.joints.map(|joint| Joint {
                gain_counts_per_nm: joint.gain_counts_per_nm,
                ..Joint::x_series()
            }),
        };
        for (joint, right) in joints.iter_mut().zip(self.right_setup().joints) {
            joint.direction = right.direction;
        }
        let stops_rad = if self.is_obstructed {
            self.initial_rad
                .map(|q| [q - OBSTACLE_RAD, q + OBSTACLE_RAD])
        } else {
            plant.stops_rad
        };
        PlantConfig {
            joints,
            stops_rad,
            ..plant
        }
    }

    /// Command that starts the activity; `None` where there is none.
    pub fn command(&self) -> Option<Command> {
        self.activity
            .command(self.to_rad, self.is_obstructed, self.seed / 2)
    }

    /// Time in µs for which samples may be missing: 20 ms, and five ticks at least.
    pub(super) fn lost_us(&self) -> u64 {
        let ticks_us = 5 * u64::from(self.set_up.period_us);
        ticks_us.max(u64::from(self.limits().lost_ms) * 1_000)
    }

    /// Time in µs until each servo's temperature has been read.
    pub(super) fn poll_us(&self) -> u64 {
        POLL_US + POLL_TICKS * u64::from(self.set_up.period_us)
    }

    /// Longest time in µs from a fault to motors off, where the bus carries packets: 20 ms.
    ///
    /// On a slow bus it may take longer: two ticks, and twice a stop sequence and the rest of
    /// the longest packet that a servo may have been cut off in. Where a client may have set servos
    /// to any speed, the board tries all of them, and a stop sequence at the slowest may be under
    /// way when the bus comes back. An X servo that a board does not reach, as after a reset at
    /// another speed, is off by its watchdog, in units of 20 ms at least five periods.
    pub fn stop_us(&self) -> u64 {
        let bytes_us = |bytes: u64, baud: u32| bytes * 10_000_000 / u64::from(baud);
        let own_us = bytes_us(2 * (STOP_BYTES + REST_BYTES), self.bus.baud);
        let search_us = if self.has_client() {
            bytes_us(STOP_BYTES, SLOWEST_BAUD)
        } else {
            0
        };
        let period_us = u64::from(self.set_up.period_us);
        let watchdog_us = match self.bus.servos {
            Firmware::Morpheus | Firmware::Stock => 0,
            Firmware::XSeries => (5 * period_us).next_multiple_of(20_000),
        };
        STOP_US.max(2 * period_us + own_us).max(watchdog_us) + search_us
    }

    /// Whether the master receives its echo from the beginning.
    pub fn echoes(&self) -> bool {
        self.has(Kind::EchoOff)
    }

    /// The fault of this kind, if it is injected.
    pub(super) fn find(&self, kind: Kind) -> Option<&Injection> {
        self.injections.iter().find(|i| i.kind == kind)
    }

    /// Whether obstacles are about an arm that has a pose to be parked in.
    pub(super) fn has_obstructed_pose(&self) -> bool {
        self.is_obstructed && self.pose.is_some()
    }

    /// Whether a client of the transparent port has the bus at some time.
    pub(super) fn has_client(&self) -> bool {
        self.activity == Activity::Port || self.injections.iter().any(|it| it.kind.has_client())
    }

    /// Whether a fault of this kind is injected.
    pub fn has(&self, kind: Kind) -> bool {
        self.find(kind).is_some()
    }

    /// Observation time after the last injection, in µs.
    pub(crate) fn observation_us(&self) -> u64 {
        let period_us = u64::from(self.set_up.period_us);
        let needs = |injection: &Injection| match injection.kind {
            Kind::EncoderDrift => OBSERVATION_DRIFT_US,
            Kind::Hot => OBSERVATION_SLOW_US + self.poll_us(),
            Kind::HostHeartbeats => OBSERVATION_SLOW_US,
            Kind::Frozen if self.activity == Activity::Float => OBSERVATION_SLOW_US,
            Kind::Frozen => OBSERVED_TICKS * period_us,
            _ => OBSERVATION_US,
        };
        let needs_us = self.injections.iter().map(needs);
        needs_us.fold(OBSERVATION_US, u64::max)
    }
}

/// Noise of the encoders in counts: mostly that of a servo in use, sometimes more, and none,
/// with which an encoder repeats one count as a broken one does.
fn draw_noise_counts(draw: &mut Random) -> f64 {
    match draw.below(8) {
        0 => 0.0,
        1 => draw.uniform(1.5, 3.0),
        _ => draw.uniform(0.3, 1.5),
    }
}

/// Pair of kinds with this index, and the number of pairs.
fn pair(index: u64) -> (Kind, Kind, u64) {
    let kinds = Kind::ALL.len();
    let pairs = (kinds * (kinds - 1) / 2) as u64;
    // A stride coprime to the number of pairs visits all of them, and separates those
    // of one kind.
    let mut left = (index.wrapping_mul(271) % pairs) as usize;
    let mut first = 0;
    while left >= kinds - 1 - first {
        left -= kinds - 1 - first;
        first += 1;
    }
    (Kind::ALL[first], Kind::ALL[first + 1 + left], pairs)
}

#[cfg(test)]
mod tests;
