//! Mutations as data. Each takes out one guard and nothing else.

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
    /// Cases in which it must show.
    pub(super) cases: Cases,
}

/// Cases of the fault campaign, as its arguments.
pub(super) type Cases = &'static [&'static str];

/// Cases of all kinds.
const ALL: Cases = &["--seeds", "1000"];
/// Cases of the few kinds in which a guard acts, as many as are needed.
const HEARTBEATS: Cases = &["--seeds", "40000", "--kinds", "host-heartbeats"];
const HOT: Cases = &["--seeds", "60000", "--kinds", "hot"];
const SECOND_MASTER: Cases = &["--seeds", "150000", "--kinds", "second-master"];
const TORQUE_SIGN: Cases = &["--seeds", "20000", "--kinds", "torque-sign"];
const WRONG_SAMPLES: Cases = &[
    "--seeds",
    "20000",
    "--kinds",
    "flipped-to-master,encoder-step",
];
const CUT_PACKETS: Cases = &[
    "--seeds",
    "40000",
    "--kinds",
    "doubled-to-servos,cut-to-servos",
];

const FORCE_OFF: &str = "shared/src/sequencer/force_off.rs";
const MONITORS: &str = "shared/src/control_loop/monitors/mod.rs";
const SUPPLY: &str = "shared/src/bridge/supply.rs";
const TIME_OUT: &str = "shared/src/control_loop/time_out.rs";

/// All mutations.
pub(super) const MUTATIONS: &[Mutation] = &[
    Mutation {
        name: "silence of the host ignored",
        file: TIME_OUT,
        find: "if silent_us > allowed_us(limits.silence_ms) {",
        replacement: "if silent_us > allowed_us(u16::MAX) {",
        cases: ALL,
    },
    Mutation {
        name: "age of a torque ignored",
        file: TIME_OUT,
        find: "Drive::Torque => limits.torque_age_ms,",
        replacement: "Drive::Torque => 0,",
        cases: HEARTBEATS,
    },
    Mutation {
        name: "read-back \"on\" taken for off",
        file: FORCE_OFF,
        find: "match firmware.decode_off(data) {",
        replacement: "match firmware.decode_off(data).map(|_| true) {",
        cases: SECOND_MASTER,
    },
    Mutation {
        name: "off report always \"off\"",
        file: FORCE_OFF,
        find: "_ if silent_ticks >= SILENT_TICKS => OffState::OutOfReach,
                _ => OffState::Unconfirmed,",
        replacement: "_ => OffState::Off,",
        cases: ALL,
    },
    Mutation {
        name: "stop sent once only",
        file: FORCE_OFF,
        find: "is_late && !self.is_off()",
        replacement: "self.stops == 0 && is_late && !self.is_off()",
        cases: CUT_PACKETS,
    },
    Mutation {
        name: "supply left on in an emergency stop",
        file: SUPPLY,
        find: "Mode::Fault(Fault::EmergencyStop(_) | Fault::Corrupted) => Self::Off,",
        replacement: "Mode::Fault(Fault::EmergencyStop(_) | Fault::Corrupted) => Self::On,",
        cases: ALL,
    },
    Mutation {
        name: "supply left on with motors unconfirmed",
        file: SUPPLY,
        find: "Mode::Fault(_) if unconfirmed_us >= CONFIRM_US => Self::Off,",
        replacement: "Mode::Fault(_) if unconfirmed_us >= CONFIRM_US => self,",
        cases: ALL,
    },
    Mutation {
        name: "angle limit dropped",
        file: "shared/src/control_loop/monitors/motion.rs",
        find: "if angle > limits.angle_rad {",
        replacement: "if angle > f32::INFINITY {",
        cases: ALL,
    },
    Mutation {
        name: "direction test of the motors dropped",
        file: "shared/src/control_loop/motor_check.rs",
        find: "if ratio < -MOVED {",
        replacement: "if ratio < f32::NEG_INFINITY {",
        cases: TORQUE_SIGN,
    },
    Mutation {
        name: "motor check dropped",
        file: "shared/src/bridge/app_core/commands.rs",
        find: "let is_check_due = !self.are_motors_checked",
        replacement: "let is_check_due = false && !self.are_motors_checked",
        cases: ALL,
    },
    Mutation {
        name: "fault not latched",
        file: "shared/src/supervisor/mod.rs",
        find: "self.word = State::Fault.word();",
        replacement: "",
        cases: ALL,
    },
    Mutation {
        name: "goodbye does not disarm",
        file: "shared/src/bridge/requests.rs",
        find: "signals.goodbye && !signals.hello",
        replacement: "false && signals.goodbye",
        cases: ALL,
    },
    Mutation {
        name: "torque limit not applied",
        file: "shared/src/control_loop/monitors/torque.rs",
        find: "let in_limit = |torque| within(torque, -limit, limit);",
        replacement: "let in_limit = |torque: f32| torque;",
        cases: ALL,
    },
    Mutation {
        name: "PWM limit not applied",
        file: "shared/src/control_loop/motor_command.rs",
        find: "let pwm_max = config.limits().pwm_counts;",
        replacement: "let pwm_max = 1_000;",
        cases: ALL,
    },
    Mutation {
        name: "stopped encoder ignored",
        file: MONITORS,
        find: "if let Some(longest) = longest {",
        replacement: "if let Some(longest) = longest.filter(|_| false) {",
        cases: ALL,
    },
    Mutation {
        name: "innovation gate dropped",
        file: MONITORS,
        find: "*measured = measured.filter(|rad| !is_far(rad));",
        replacement: "let _ = (is_far, measured);",
        cases: WRONG_SAMPLES,
    },
    Mutation {
        name: "temperature ignored",
        file: "shared/src/bridge/bus_events.rs",
        find: "if let (Some(violation), true) = (violation, self.core.state().is_armed()) {",
        replacement: "if let (Some(violation), true) = (violation, false) {",
        cases: HOT,
    },
];
