//! Comparison of the recorded with the computed outputs of a tick, field by field, bit by bit.

use std::fmt;

use armbridge_link::message::{Record, TickOutput};
use armbridge_link::record::TickEvents;
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

/// Whether both are equal to the last bit. All NaNs are equal:
/// processors differ in their bits.
pub(super) fn is_same(recorded: &TickOutput, computed: &TickOutput) -> bool {
    let numbers = |output: &TickOutput| {
        [
            output.angle_rad,
            output.speed_rad_s,
            output.disturbance_nm,
            output.reference_rad,
            output.reference_speed_rad_s,
            output.torque_nm,
        ]
        .map(|joints| joints.map(bits))
    };
    recorded.pwm == computed.pwm
        && recorded.guards == computed.guards
        && recorded.is_complete == computed.is_complete
        && events(recorded.events) == events(computed.events)
        && numbers(recorded) == numbers(computed)
}

/// Events with the bits of their numbers.
fn events(events: Option<TickEvents>) -> Option<(TickEvents, [u32; 2])> {
    let mut events = events?;
    let values = events.fault.as_mut().map(|fault| {
        let values = [&mut fault.value, &mut fault.limit];
        values.map(|value| bits(std::mem::take(value)))
    });
    Some((events, values.unwrap_or_default()))
}

/// The first field that differs. The PWM in force is that `decided` in the tick before, or off.
pub(super) fn difference(
    recorded: &Record,
    decided: [u16; JOINTS],
    computed: &TickOutput,
) -> Option<Difference> {
    let sent = recorded.input.pwm_in_force;
    let (field, recorded_value, computed_value) = first(&recorded.output, computed)
        .or_else(|| first_differing_integer("pwm_counts", sent, decided))?;
    Some(Difference {
        tick: recorded.tick,
        start_us: recorded.input.start_us,
        field,
        recorded: recorded_value,
        computed: computed_value,
    })
}

/// Causes before their effects.
fn first(was: &TickOutput, is: &TickOutput) -> Option<(String, String, String)> {
    let number =
        |name, of: fn(&TickOutput) -> [f32; JOINTS]| first_differing_number(name, of(was), of(is));
    number("angle_rad", |o| o.angle_rad)
        .or_else(|| number("speed_rad_s", |o| o.speed_rad_s))
        .or_else(|| number("disturbance_nm", |o| o.disturbance_nm))
        .or_else(|| number("reference_rad", |o| o.reference_rad))
        .or_else(|| number("reference_speed_rad_s", |o| o.reference_speed_rad_s))
        .or_else(|| {
            let is_same = events(was.events) == events(is.events);
            (!is_same).then(|| first_differing_event(was.events, is.events))
        })
        .or_else(|| {
            let [was, is] = [was, is].map(|output| [u8::from(output.is_complete)]);
            first_differing_integer("is_complete", was, is)
        })
        .or_else(|| {
            let [was, is] = [was, is].map(|output| [output.guards.bits()]);
            first_differing_integer("guards", was, is)
        })
        .or_else(|| number("torque_nm", |o| o.torque_nm))
        .or_else(|| first_differing_integer("pwm_next_counts", was.pwm, is.pwm))
}

/// The kind of event that differs.
fn first_differing_event(
    recorded: Option<TickEvents>,
    computed: Option<TickEvents>,
) -> (String, String, String) {
    let texts = |name: &str, of: fn(TickEvents) -> String| {
        let [was, is] = [recorded, computed].map(|events| events.map_or_else(String::new, of));
        (name.to_owned(), was, is)
    };
    let kinds = [
        texts("fault", |events| format!("{:?}", events.fault)),
        texts("fallback", |events| format!("{:?}", events.fallback)),
        texts("experiment_end", |e| format!("{:?}", e.experiment_end)),
        texts("are_motors_checked", |e| e.are_motors_checked.to_string()),
    ];
    let mut differing = kinds.into_iter().filter(|(_, was, is)| was != is);
    let none = || ("events".to_owned(), String::new(), String::new());
    differing.next().unwrap_or_else(none)
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
