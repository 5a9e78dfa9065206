//! Comparison of two records of one tick, field by field, bit by bit.

use std::fmt;

use armbridge_client::enum_names;
use armbridge_link::message::{Mode, Record};
use armbridge_servo::JOINTS;
use serde::Serialize;

/// The first field of a tick that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Number of the tick.
    pub tick: u32,
    /// Start of the tick, on the board's clock in µs.
    pub start_us: u64,
    /// The field, by its column name in the log.
    pub field: String,
    /// Recorded value.
    pub recorded: String,
    /// Computed value.
    pub computed: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            tick,
            start_us,
            field,
            recorded,
            computed,
        } = self;
        let at_s = *start_us as f64 * 1e-6;
        write!(
            f,
            "tick {tick} at {at_s:.6} s, {field}: recorded {recorded}, computed {computed}"
        )
    }
}

/// Name of a mode; faults have their own names.
pub(super) fn mode(mode: Mode) -> String {
    match mode {
        Mode::Fault(fault) => format!("fault {}", enum_names::fault(fault)),
        Mode::Boot
        | Mode::Idle
        | Mode::MotorCheck
        | Mode::Armed
        | Mode::Running(_)
        | Mode::Degraded(_)
        | Mode::Passthrough => enum_names::mode(mode).to_owned(),
    }
}

/// Whether both are equal to the last bit. All NaNs are equal:
/// processors differ in their bits.
pub(super) fn same(recorded: &Record, computed: &Record) -> bool {
    let numbers = |record: &Record| {
        [
            record.angle_rad,
            record.speed_rad_s,
            record.disturbance_nm,
            record.reference_rad,
            record.reference_speed_rad_s,
            record.torque_nm,
        ]
        .map(|joints| joints.map(bits))
    };
    recorded.mode == computed.mode
        && recorded.guards == computed.guards
        && recorded.timing.missed == computed.timing.missed
        && recorded.pwm_in_force == computed.pwm_in_force
        && recorded.pwm_next == computed.pwm_next
        && numbers(recorded) == numbers(computed)
}

/// The first field that differs.
pub(super) fn difference(recorded: &Record, computed: &Record) -> Option<Difference> {
    let (field, recorded_value, computed_value) = first(recorded, computed)?;
    Some(Difference {
        tick: recorded.tick,
        start_us: recorded.start_us,
        field,
        recorded: recorded_value,
        computed: computed_value,
    })
}

/// Causes before their effects.
fn first(recorded: &Record, computed: &Record) -> Option<(String, String, String)> {
    let (was, is) = (recorded, computed);
    first_differing_integer("missed_ticks", [was.timing.missed], [is.timing.missed])
        .or_else(|| first_differing_integer("pwm_counts", was.pwm_in_force, is.pwm_in_force))
        .or_else(|| first_differing_number("angle_rad", was.angle_rad, is.angle_rad))
        .or_else(|| first_differing_number("speed_rad_s", was.speed_rad_s, is.speed_rad_s))
        .or_else(|| first_differing_number("disturbance_nm", was.disturbance_nm, is.disturbance_nm))
        .or_else(|| first_differing_number("reference_rad", was.reference_rad, is.reference_rad))
        .or_else(|| {
            let [was, is] = [was, is].map(|record| record.reference_speed_rad_s);
            first_differing_number("reference_speed_rad_s", was, is)
        })
        .or_else(|| {
            let [was, is] = [was.mode, is.mode].map(mode);
            (was != is).then(|| ("board_mode".into(), was, is))
        })
        .or_else(|| first_differing_integer("guards", [was.guards.bits()], [is.guards.bits()]))
        .or_else(|| first_differing_number("torque_nm", was.torque_nm, is.torque_nm))
        .or_else(|| first_differing_integer("pwm_next_counts", was.pwm_next, is.pwm_next))
}

/// The first integer that differs.
fn first_differing_integer<T: Copy + PartialEq + fmt::Display, const N: usize>(
    name: &str,
    recorded: [T; N],
    computed: [T; N],
) -> Option<(String, String, String)> {
    let mut both = (1..).zip(recorded.into_iter().zip(computed));
    let (joint, (recorded, computed)) = both.find(|(_, (was, is))| was != is)?;
    let name = if N == JOINTS {
        format!("{name}_{joint}")
    } else {
        name.to_owned()
    };
    Some((name, recorded.to_string(), computed.to_string()))
}

/// The joint whose number differs in a bit.
fn first_differing_number(
    name: &str,
    recorded: [f32; JOINTS],
    computed: [f32; JOINTS],
) -> Option<(String, String, String)> {
    let mut both = (1..).zip(recorded.into_iter().zip(computed));
    let (joint, (recorded, computed)) = both.find(|(_, (was, is))| bits(*was) != bits(*is))?;
    // Enough digits to distinguish two neighbouring numbers.
    let [was, is] = [recorded, computed].map(|value| format!("{value:?}"));
    Some((format!("{name}_{joint}"), was, is))
}

fn bits(value: f32) -> u32 {
    if value.is_nan() { f32::NAN } else { value }.to_bits()
}
