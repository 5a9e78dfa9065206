//! Mutations as data. Each takes out one guard and nothing else.

use Judge::{Campaign, Test};

/// A change of the board's code.
pub(super) struct Mutation {
    /// The guard that is missing.
    pub(super) name: &'static str,
    /// File from the root of the workspace.
    pub(super) file: &'static str,
    /// Text that occurs exactly once in it.
    pub(super) find: &'static str,
    /// Text in its place.
    pub(super) replacement: &'static str,
    /// Tests that must notice it.
    pub(super) judge: Judge,
}

/// Check that notices a mutation.
#[derive(Clone, Copy)]
pub(super) enum Judge {
    /// Cases of the fault campaign.
    Campaign(Cases),
    /// The whole-system test with this name, for a guard that few cases need.
    Test(&'static str),
}

/// Cases of the fault campaign, as its arguments.
pub(super) type Cases = &'static [&'static str];

/// Cases of all kinds, for guards that many need.
const ALL: Cases = &["--seeds", "200"];
const MORE: Cases = &["--seeds", "600"];
/// Cases of the few kinds in which a guard acts, as many as are needed.
const FROZEN: Cases = &["--seeds", "12000", "--kinds", "frozen"];
const GOODBYE: Cases = &["--seeds", "3000", "--kinds", "goodbye"];
const HEARTBEATS: Cases = &["--seeds", "15000", "--kinds", "host-heartbeats"];
const PUSHED: Cases = &["--seeds", "12000", "--kinds", "push,servos-swapped"];
const SILENT_HOST: Cases = &["--seeds", "3000", "--kinds", "host-schema,host-vanish"];
const TORQUE_SIGN: Cases = &["--seeds", "20000", "--kinds", "torque-sign"];
const TO_SERVOS: Cases = &[
    "--seeds",
    "10000",
    "--kinds",
    "lost-to-servos,late-to-servos,doubled-to-servos,flipped-to-servos,cut-to-servos",
];
const WRONG_SAMPLES: Cases = &[
    "--seeds",
    "12000",
    "--kinds",
    "flipped-to-master,encoder-step",
];

/// Tests that make the few cases which need a guard.
const ANOTHER_MASTER: &str = "torque_off::foreign_master::what_another_master_sets_on_is_off_within_100_ms_for_as_long_as_it_tries";
const HOT_SERVO: &str = "torque_off::limits::a_driven_servo_that_gets_hot_ends_the_drive";
const LARGEST_PWM: &str = "supervisor::limits_are_set_while_idle_and_within_hard_bounds_only";
const LONG_PACKET: &str =
    "torque_off::outages::a_servo_that_waits_for_a_long_packet_after_an_outage_is_off";
const PUSHED_BEYOND: &str =
    "torque_off::limits::an_arm_that_is_pushed_beyond_its_angle_limit_is_off_within_two_ticks";

const ENCODER_PROOF: &str = "shared/board/src/tick/monitors/encoder_proof.rs";
const FORCE_OFF: &str = "shared/board/src/sequencer/force_off.rs";
const MONITORS: &str = "shared/board/src/tick/monitors/mod.rs";
const SUPPLY: &str = "shared/board/src/bridge/supply_relay.rs";
const TIME_OUT: &str = "shared/board/src/tick/drive_source.rs";

/// All mutations.
pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "silence of the host ignored",
        file: TIME_OUT,
        find: "(silent_ms > limits.silence_ms)",
        replacement: "(silent_ms > limits.silence_ms.saturating_add(60_000))",
        judge: Campaign(SILENT_HOST),
    },
    Mutation {
        name: "age of a torque ignored",
        file: TIME_OUT,
        find: "Drive::Torque => limits.torque_age_ms,",
        replacement: "Drive::Torque => 0,",
        judge: Campaign(HEARTBEATS),
    },
    Mutation {
        name: "read-back \"on\" taken for off",
        file: FORCE_OFF,
        find: "match firmware.decode_off(data) {",
        replacement: "match firmware.decode_off(data).map(|_| true) {",
        judge: Test(ANOTHER_MASTER),
    },
    Mutation {
        name: "off report always \"off\"",
        file: FORCE_OFF,
        find: "_ if silent_ticks >= SILENT_TICKS => OffState::OutOfReach,
                _ => OffState::Unconfirmed,",
        replacement: "_ => OffState::Off,",
        judge: Campaign(TO_SERVOS),
    },
    Mutation {
        name: "stop sent once only",
        file: FORCE_OFF,
        find: "is_late && !self.is_off()",
        replacement: "self.stops == 0 && is_late && !self.is_off()",
        judge: Test(LONG_PACKET),
    },
    Mutation {
        name: "supply left on in an emergency stop",
        file: SUPPLY,
        find: "Some(Fault::EmergencyStop(_) | Fault::Corrupted) => Self::Off,",
        replacement: "Some(Fault::EmergencyStop(_) | Fault::Corrupted) => Self::On,",
        judge: Campaign(ALL),
    },
    Mutation {
        name: "supply left on with motors unconfirmed",
        file: SUPPLY,
        find: "Some(_) if unconfirmed_us >= CONFIRM_US => Self::Off,",
        replacement: "Some(_) if unconfirmed_us >= CONFIRM_US => self,",
        judge: Campaign(MORE),
    },
    Mutation {
        name: "angle limit dropped",
        file: "shared/board/src/tick/monitors/motion.rs",
        find: "if angle > limits.angle_rad {",
        replacement: "if angle > f32::INFINITY {",
        judge: Test(PUSHED_BEYOND),
    },
    Mutation {
        name: "direction test of the motors dropped",
        file: "shared/board/src/tick/motor_check.rs",
        find: "if ratio < -MOVED {",
        replacement: "if ratio < f32::NEG_INFINITY {",
        judge: Campaign(TORQUE_SIGN),
    },
    Mutation {
        name: "motor check dropped",
        file: "shared/board/src/bridge/app_core/commands.rs",
        find: "let is_check_due = !self.are_motors_checked",
        replacement: "let is_check_due = false && !self.are_motors_checked",
        judge: Campaign(TORQUE_SIGN),
    },
    Mutation {
        name: "fault not latched",
        file: "shared/board/src/supervisor/mod.rs",
        find: "self.word = State::Fault.word();",
        replacement: "",
        judge: Campaign(ALL),
    },
    Mutation {
        name: "goodbye does not disarm",
        file: "shared/board/src/bridge/requests.rs",
        find: "signals.goodbye && !signals.hello",
        replacement: "false && signals.goodbye",
        judge: Campaign(GOODBYE),
    },
    Mutation {
        name: "torque limit not applied",
        file: "shared/board/src/tick/monitors/torque.rs",
        find: "let in_limit = |torque| within(torque, -limit, limit);",
        replacement: "let in_limit = |torque: f32| torque;",
        judge: Campaign(PUSHED),
    },
    Mutation {
        name: "PWM limit not applied",
        file: "shared/board/src/tick/actuator_command.rs",
        find: "(limited.torque_nm, config.limits().pwm_counts);",
        replacement: "(limited.torque_nm, 1_000);",
        judge: Test(LARGEST_PWM),
    },
    Mutation {
        name: "stopped encoder ignored",
        file: ENCODER_PROOF,
        find: "if is_too_long || self.ramp.is_some_and(|ramp| ramp.tick > ramps) {",
        replacement: "if false && (is_too_long || self.ramp.is_some_and(|ramp| ramp.tick > ramps)) {",
        judge: Campaign(FROZEN),
    },
    Mutation {
        name: "quiet encoder not put to the proof",
        file: ENCODER_PROOF,
        find: "is_due.then_some(Ramp {",
        replacement: "(is_due && false).then_some(Ramp {",
        judge: Campaign(FROZEN),
    },
    Mutation {
        name: "innovation gate dropped",
        file: MONITORS,
        find: "*measured = measured.filter(|rad| !is_far(rad));",
        replacement: "let _ = (is_far, measured);",
        judge: Campaign(WRONG_SAMPLES),
    },
    Mutation {
        name: "temperature ignored",
        file: "shared/board/src/bridge/bus_events.rs",
        find: "if let (Some(violation), true) = (violation, self.core.state().is_armed()) {",
        replacement: "if let (Some(violation), true) = (violation, false) {",
        judge: Test(HOT_SERVO),
    },
];
