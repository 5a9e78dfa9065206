//! Conversion of a tick's record to a message of the log, and back, to the bit.

use armbridge_shared::JOINTS;
use armbridge_shared::actuator;
use armbridge_shared::link::message::{Guards, Record, Sample, Timing};

use super::{enum_codes, proto};

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
    let joint = |j: usize| joint(record, j, joints.map(|joints| &joints[j]));
    proto::Telemetry {
        tick: Some(record.tick),
        board_us: Some(record.start_us),
        host_ns,
        sequence: sequence.into(),
        mode: mode.into(),
        fault: fault.into(),
        guard_bits: record.guards.bits().into(),
        joint1: Some(joint(0)),
        joint2: Some(joint(1)),
        start_error_us: Some(record.timing.start_error_us),
        bus_us: Some(record.timing.bus_us),
        compute_ns: Some(record.timing.compute_ns),
        missed_ticks: record.timing.missed,
        dropped_records: record.dropped,
    }
}

fn joint(record: &Record, j: usize, servo: Option<&actuator::Joint<f32>>) -> proto::Joint {
    let (counts, missing) = match record.samples[j] {
        Sample::Counts(counts) => (Some(counts), proto::Missing::None),
        Sample::Missing(missing) => (None, enum_codes::missing(missing)),
    };
    proto::Joint {
        position_counts: counts.map(u32::from),
        missing: missing.into(),
        alarm_bits: record.alarms[j].into(),
        pwm_counts: Some(record.pwm_in_force[j].into()),
        pwm_next_counts: Some(record.pwm_next[j].into()),
        measured_rad: counts.zip(servo).map(|(counts, servo)| servo.angle(counts)),
        reference_rad: Some(record.reference_rad[j]),
        reference_rad_s: Some(record.reference_speed_rad_s[j]),
        angle_rad: Some(record.angle_rad[j]),
        speed_rad_s: Some(record.speed_rad_s[j]),
        torque_nm: Some(record.torque_nm[j]),
        disturbance_nm: Some(record.disturbance_nm[j]),
    }
}

/// No board's clock gets there, in µs; sums of times below it do not overflow.
const CLOCK_END_US: u64 = 1 << 62;

/// The record and its frame number; `None` if a field is missing or
/// unknown.
pub(super) fn record(message: &proto::Telemetry) -> Option<(u16, Record)> {
    let joints = [message.joint1.as_ref()?, message.joint2.as_ref()?];
    let sequence = message.sequence.try_into().ok()?;
    let record = Record {
        tick: message.tick?,
        start_us: message.board_us.filter(|us| *us < CLOCK_END_US)?,
        mode: enum_codes::mode_from(
            message.mode.try_into().ok()?,
            message.fault.try_into().ok()?,
        )?,
        guards: Guards::from_bits(message.guard_bits.try_into().ok()?),
        samples: both(joints, sample)?,
        alarms: both(joints, |joint| joint.alarm_bits.try_into().ok())?,
        pwm_in_force: both(joints, |joint| joint.pwm_counts?.try_into().ok())?,
        pwm_next: both(joints, |joint| joint.pwm_next_counts?.try_into().ok())?,
        reference_rad: both(joints, |joint| joint.reference_rad)?,
        reference_speed_rad_s: both(joints, |joint| joint.reference_rad_s)?,
        angle_rad: both(joints, |joint| joint.angle_rad)?,
        speed_rad_s: both(joints, |joint| joint.speed_rad_s)?,
        torque_nm: both(joints, |joint| joint.torque_nm)?,
        disturbance_nm: both(joints, |joint| joint.disturbance_nm)?,
        timing: Timing {
            start_error_us: message.start_error_us?,
            bus_us: message.bus_us?,
            compute_ns: message.compute_ns?,
            missed: message.missed_ticks,
        },
        dropped: message.dropped_records,
    };
    Some((sequence, record))
}

fn both<T>(
    [first, second]: [&proto::Joint; JOINTS],
    value: impl Fn(&proto::Joint) -> Option<T>,
) -> Option<[T; JOINTS]> {
    Some([value(first)?, value(second)?])
}

fn sample(joint: &proto::Joint) -> Option<Sample> {
    match joint.position_counts {
        Some(counts) => Some(Sample::Counts(counts.try_into().ok()?)),
        None => enum_codes::missing_from(joint.missing.try_into().ok()?).map(Sample::Missing),
    }
}
