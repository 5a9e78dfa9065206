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
}

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
    },
    Mutation {
        name: "age of a torque ignored",
        file: TIME_OUT,
        find: "Drive::Torque => limits.torque_age_ms,",
        replacement: "Drive::Torque => 0,",
    },
    Mutation {
        name: "read-back \"on\" taken for off",
        file: FORCE_OFF,
        find: "match firmware.decode_off(data) {",
        replacement: "match firmware.decode_off(data).map(|_| true) {",
    },
    Mutation {
        name: "off report always \"off\"",
        file: FORCE_OFF,
        find: "_ if silent_ticks >= SILENT_TICKS => OffState::OutOfReach,
                _ => OffState::Unconfirmed,",
        replacement: "_ => OffState::Off,",
    },
    Mutation {
        name: "stop sent once only",
        file: FORCE_OFF,
        find: "is_late && !self.is_off()",
        replacement: "self.stops == 0 && is_late && !self.is_off()",
    },
    Mutation {
        name: "supply left on in an emergency stop",
        file: SUPPLY,
        find: "Mode::Fault(Fault::EmergencyStop(_) | Fault::Corrupted) => Self::Off,",
        replacement: "Mode::Fault(Fault::EmergencyStop(_) | Fault::Corrupted) => Self::On,",
    },
    Mutation {
        name: "supply left on with motors unconfirmed",
        file: SUPPLY,
        find: "Mode::Fault(_) if unconfirmed_us >= CONFIRM_US => Self::Off,",
        replacement: "Mode::Fault(_) if unconfirmed_us >= CONFIRM_US => self,",
    },
    Mutation {
        name: "angle limit dropped",
        file: "shared/src/control_loop/monitors/motion.rs",
        find: "if angle > limits.angle_rad {",
        replacement: "if angle > f32::INFINITY {",
    },
    Mutation {
        name: "direction test of the motors dropped",
        file: "shared/src/control_loop/motor_check.rs",
        find: "if ratio < -MOVED {",
        replacement: "if ratio < f32::NEG_INFINITY {",
    },
    Mutation {
        name: "motor check dropped",
        file: "shared/src/bridge/app_core/commands.rs",
        find: "let is_check_due = !self.are_motors_checked",
        replacement: "let is_check_due = false && !self.are_motors_checked",
    },
    Mutation {
        name: "fault not latched",
        file: "shared/src/supervisor/mod.rs",
        find: "self.word = State::Fault.word();",
        replacement: "",
    },
    Mutation {
        name: "goodbye does not disarm",
        file: "shared/src/bridge/requests.rs",
        find: "signals.goodbye && !signals.hello",
        replacement: "false && signals.goodbye",
    },
    Mutation {
        name: "torque limit not applied",
        file: "shared/src/control_loop/monitors/torque.rs",
        find: "let in_limit = |torque| within(torque, -limit, limit);",
        replacement: "let in_limit = |torque: f32| torque;",
    },
    Mutation {
        name: "PWM limit not applied",
        file: "shared/src/control_loop/motor_command.rs",
        find: "let pwm_max = config.limits().pwm_counts;",
        replacement: "let pwm_max = 1_000;",
    },
    Mutation {
        name: "stopped encoder ignored",
        file: MONITORS,
        find: "if let Some(longest) = longest {",
        replacement: "if let Some(longest) = longest.filter(|_| false) {",
    },
    Mutation {
        name: "innovation gate dropped",
        file: MONITORS,
        find: "*measured = measured.filter(|rad| !is_far(rad));",
        replacement: "let _ = (is_far, measured);",
    },
    Mutation {
        name: "temperature ignored",
        file: "shared/src/bridge/bus_events.rs",
        find: "if let (Some(violation), true) = (violation, self.core.state().is_armed()) {",
        replacement: "if let (Some(violation), true) = (violation, false) {",
    },
];
