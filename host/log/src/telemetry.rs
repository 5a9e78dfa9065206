//! Conversion of a tick's record to a message of the log, and back, to the bit.

use armbridge_control::actuator;
use armbridge_link::message::{Guards, Record, Sample, TickInput, TickOutput, Timing};
use armbridge_link::record::{Permission, TickEvents};
use armbridge_servo::JOINTS;
use serde::{Deserialize, Serialize};

use super::{enum_codes, proto};

/// Times of a board's clock end here, in µs: 71 years, below which they are exact in
/// [`seconds`] and back, and sums of them do not overflow.
const CLOCK_END_US: f64 = (1u64 << 51) as f64;

/// Time of the board's clock in s.
pub(super) fn seconds(us: u64) -> f64 {
    us as f64 / 1e6
}

/// The time in µs; `None` if it is none of a board's clock.
pub(super) fn microseconds(time_s: f64) -> Option<u64> {
    let us = (time_s * 1e6).round();
    let is_known = (0.0..CLOCK_END_US).contains(&us) && (us / 1e6).to_bits() == time_s.to_bits();
    is_known.then_some(us as u64)
}

/// Message for a record.
///
/// `joints` are the servos' calibrations, if the settings are known: they convert
/// counts to angles.
pub(super) fn telemetry(
    host_ns: u64,
    sequence: u16,
    record: &Record,
    joints: Option<&[actuator::Joint<f32>; JOINTS]>,
) -> proto::Telemetry {
    let (mode, fault) = enum_codes::mode(record.mode);
    let counts = record.input.samples.map(Sample::counts);
    let encoder_counts = counts.map(|counts| counts.map(u32::from));
    let missing = record.input.samples.map(|sample| match sample {
        Sample::Counts(_) => proto::Missing::None.into(),
        Sample::Missing(missing) => enum_codes::missing(missing).into(),
    });
    let measured = |j: usize| Some(joints?[j].angle(counts[j]?));
    proto::Telemetry {
        measured_rad_1: measured(0),
        measured_rad_2: measured(1),
        reference_rad_1: Some(record.output.reference_rad[0]),
        reference_rad_2: Some(record.output.reference_rad[1]),
        reference_speed_rad_s_1: Some(record.output.reference_speed_rad_s[0]),
        reference_speed_rad_s_2: Some(record.output.reference_speed_rad_s[1]),
        angle_rad_1: Some(record.output.angle_rad[0]),
        angle_rad_2: Some(record.output.angle_rad[1]),
        speed_rad_s_1: Some(record.output.speed_rad_s[0]),
        speed_rad_s_2: Some(record.output.speed_rad_s[1]),
        torque_nm_1: Some(record.output.torque_nm[0]),
        torque_nm_2: Some(record.output.torque_nm[1]),
        disturbance_nm_1: Some(record.output.disturbance_nm[0]),
        disturbance_nm_2: Some(record.output.disturbance_nm[1]),
        time_s: Some(seconds(record.input.start_us)),
        tick: Some(record.tick),
        board_mode: mode.into(),
        fault: fault.into(),
        guards: record.output.guards.bits().into(),
        encoder_counts_1: encoder_counts[0],
        encoder_counts_2: encoder_counts[1],
        missing_1: missing[0],
        missing_2: missing[1],
        alarms_1: record.input.alarms[0].into(),
        alarms_2: record.input.alarms[1].into(),
        pwm_counts_1: Some(record.input.pwm_in_force[0].into()),
        pwm_counts_2: Some(record.input.pwm_in_force[1].into()),
        pwm_next_counts_1: Some(record.output.pwm[0].into()),
        pwm_next_counts_2: Some(record.output.pwm[1].into()),
        start_error_us: Some(record.timing.start_error_us),
        bus_us: Some(record.timing.bus_us),
        compute_ns: Some(record.timing.compute_ns),
        missed_ticks: record.timing.missed,
        dropped_records: record.dropped,
        host_ns,
        sequence: sequence.into(),
        // Plain data: the encoding cannot fail.
        replay: postcard::to_stdvec(&ReplayPart::of(record)).unwrap_or_default(),
    }
}

/// Inputs and outputs of a tick that are no columns.
#[derive(Serialize, Deserialize)]
struct ReplayPart {
    lead_us: u32,
    permission: Permission,
    is_first: bool,
    is_config_intact: bool,
    host_silent_ms: u16,
    is_complete: bool,
    events: Option<TickEvents>,
}

impl ReplayPart {
    fn of(record: &Record) -> Self {
        let Record { input, output, .. } = record;
        Self {
            lead_us: input.lead_us,
            permission: input.permission,
            is_first: input.is_first,
            is_config_intact: input.is_config_intact,
            host_silent_ms: input.host_silent_ms,
            is_complete: output.is_complete,
            events: output.events,
        }
    }
}

/// The record and its frame number; `None` if a field is missing or unknown. What another version
/// wrote for replays is left out: that version alone repeats its ticks.
pub(super) fn record(message: &proto::Telemetry) -> Option<(u16, Record)> {
    let m = message;
    let part = postcard::from_bytes(&m.replay);
    let part: ReplayPart = part.unwrap_or_else(|_| ReplayPart::of(&Record::NONE));
    let record = Record {
        tick: m.tick?,
        mode: enum_codes::mode_from(m.board_mode.try_into().ok()?, m.fault.try_into().ok()?)?,
        input: TickInput {
            start_us: microseconds(m.time_s?)?,
            lead_us: part.lead_us,
            permission: part.permission,
            is_first: part.is_first,
            is_config_intact: part.is_config_intact,
            host_silent_ms: part.host_silent_ms,
            samples: [
                sample(m.encoder_counts_1, m.missing_1)?,
                sample(m.encoder_counts_2, m.missing_2)?,
            ],
            alarms: [m.alarms_1.try_into().ok()?, m.alarms_2.try_into().ok()?],
            pwm_in_force: counts([m.pwm_counts_1?, m.pwm_counts_2?])?,
        },
        output: TickOutput {
            pwm: counts([m.pwm_next_counts_1?, m.pwm_next_counts_2?])?,
            torque_nm: [m.torque_nm_1?, m.torque_nm_2?],
            reference_rad: [m.reference_rad_1?, m.reference_rad_2?],
            reference_speed_rad_s: [m.reference_speed_rad_s_1?, m.reference_speed_rad_s_2?],
            angle_rad: [m.angle_rad_1?, m.angle_rad_2?],
            speed_rad_s: [m.speed_rad_s_1?, m.speed_rad_s_2?],
            disturbance_nm: [m.disturbance_nm_1?, m.disturbance_nm_2?],
            guards: Guards::from_bits(m.guards.try_into().ok()?),
            is_complete: part.is_complete,
            events: part.events,
        },
        timing: Timing {
            start_error_us: m.start_error_us?,
            bus_us: m.bus_us?,
            compute_ns: m.compute_ns?,
            missed: m.missed_ticks,
        },
        dropped: m.dropped_records,
    };
    Some((m.sequence.try_into().ok()?, record))
}

fn counts([first, second]: [u32; JOINTS]) -> Option<[u16; JOINTS]> {
    Some([first.try_into().ok()?, second.try_into().ok()?])
}

fn sample(counts: Option<u32>, missing: i32) -> Option<Sample> {
    match counts {
        Some(counts) => Some(Sample::Counts(counts.try_into().ok()?)),
        None => enum_codes::missing_from(missing.try_into().ok()?).map(Sample::Missing),
    }
}
