//! Conversion of a tick's record to a message of the log, and back, to the bit.

use armbridge_control::actuator;
use armbridge_link::message::{Guards, Record, Sample, Timing};
use armbridge_servo::JOINTS;

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
    let counts = record.samples.map(Sample::counts);
    let encoder_counts = counts.map(|counts| counts.map(u32::from));
    let missing = record.samples.map(|sample| match sample {
        Sample::Counts(_) => proto::Missing::None.into(),
        Sample::Missing(missing) => enum_codes::missing(missing).into(),
    });
    let measured = |j: usize| Some(joints?[j].angle(counts[j]?));
    proto::Telemetry {
        measured_rad_1: measured(0),
        measured_rad_2: measured(1),
        reference_rad_1: Some(record.reference_rad[0]),
        reference_rad_2: Some(record.reference_rad[1]),
        reference_speed_rad_s_1: Some(record.reference_speed_rad_s[0]),
        reference_speed_rad_s_2: Some(record.reference_speed_rad_s[1]),
        angle_rad_1: Some(record.angle_rad[0]),
        angle_rad_2: Some(record.angle_rad[1]),
        speed_rad_s_1: Some(record.speed_rad_s[0]),
        speed_rad_s_2: Some(record.speed_rad_s[1]),
        torque_nm_1: Some(record.torque_nm[0]),
        torque_nm_2: Some(record.torque_nm[1]),
        disturbance_nm_1: Some(record.disturbance_nm[0]),
        disturbance_nm_2: Some(record.disturbance_nm[1]),
        time_s: Some(seconds(record.start_us)),
        tick: Some(record.tick),
        board_mode: mode.into(),
        fault: fault.into(),
        guards: record.guards.bits().into(),
        encoder_counts_1: encoder_counts[0],
        encoder_counts_2: encoder_counts[1],
        missing_1: missing[0],
        missing_2: missing[1],
        alarms_1: record.alarms[0].into(),
        alarms_2: record.alarms[1].into(),
        pwm_counts_1: Some(record.pwm_in_force[0].into()),
        pwm_counts_2: Some(record.pwm_in_force[1].into()),
        pwm_next_counts_1: Some(record.pwm_next[0].into()),
        pwm_next_counts_2: Some(record.pwm_next[1].into()),
        start_error_us: Some(record.timing.start_error_us),
        bus_us: Some(record.timing.bus_us),
        compute_ns: Some(record.timing.compute_ns),
        missed_ticks: record.timing.missed,
        dropped_records: record.dropped,
        host_ns,
        sequence: sequence.into(),
    }
}

/// The record and its frame number; `None` if a field is missing or
/// unknown.
pub(super) fn record(message: &proto::Telemetry) -> Option<(u16, Record)> {
    let m = message;
    let record = Record {
        tick: m.tick?,
        start_us: microseconds(m.time_s?)?,
        mode: enum_codes::mode_from(m.board_mode.try_into().ok()?, m.fault.try_into().ok()?)?,
        guards: Guards::from_bits(m.guards.try_into().ok()?),
        samples: [
            sample(m.encoder_counts_1, m.missing_1)?,
            sample(m.encoder_counts_2, m.missing_2)?,
        ],
        alarms: [m.alarms_1.try_into().ok()?, m.alarms_2.try_into().ok()?],
        pwm_in_force: counts([m.pwm_counts_1?, m.pwm_counts_2?])?,
        pwm_next: counts([m.pwm_next_counts_1?, m.pwm_next_counts_2?])?,
        reference_rad: [m.reference_rad_1?, m.reference_rad_2?],
        reference_speed_rad_s: [m.reference_speed_rad_s_1?, m.reference_speed_rad_s_2?],
        angle_rad: [m.angle_rad_1?, m.angle_rad_2?],
        speed_rad_s: [m.speed_rad_s_1?, m.speed_rad_s_2?],
        torque_nm: [m.torque_nm_1?, m.torque_nm_2?],
        disturbance_nm: [m.disturbance_nm_1?, m.disturbance_nm_2?],
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
