//! Records of the settings store, as bytes.
//!
//! ```text
//! format u8 | kind u8 | generation u32 | body | CRC-32
//! ```
//!
//! Integers are little endian. Header and CRC stay as they are in every format;
//! a new format number means other bodies. There are two kinds:
//!
//! | kind    | body                  | meaning         |
//! |---------|-----------------------|-----------------|
//! | `b'S'`  | groups of settings    | these are the settings |
//! | `b'R'`  | none                  | the settings of this generation were written and read back |
//!
//! A group is encoded by itself, so that another version reads those whose encoding it has not
//! changed:
//!
//! ```text
//! group u8 | hash of the group's schema, 8 bytes | length u16 | postcard
//! ```
//!
//! Generations count up with each save. A receipt without its settings is how a
//! damaged save is distinguished from one that power-off cut short: the latter has none.
//!
//! The storage crate has a CRC of its own. It covers what the crate was handed
//! until it hands it back, and its record layout may change with its version. This
//! CRC covers the rest of the way, encoder to decoder, RAM included, and makes a
//! forged record as unlikely as 64 bits do.

use armbridge_control::actuator::Joint;
use armbridge_control::arm::Parameters;
use armbridge_control::estimate::Config;
use armbridge_link::crc32;
use armbridge_link::message::{Controller, Limits, Settings, SettingsGroups};
use armbridge_servo::{ControlMode, JOINTS};
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use postcard_schema::key::Key;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Number of this layout.
const FORMAT: u8 = 2;
pub(super) const HEADER: usize = 6;
const CRC_LEN: usize = 4;
const HASH_LEN: usize = 8;
const GROUP_HEADER: usize = 1 + HASH_LEN + 2;

/// Period, controller, its integral action, estimator and friction compensation.
type ControlGroup = (
    u32,
    Controller,
    [f32; JOINTS],
    Config<f32>,
    ([f32; JOINTS], [u8; JOINTS]),
);
/// Calibration of the servos, and what their commands are.
type JointsGroup = (Joint<f32>, Joint<f32>, ControlMode);

/// Longest body with settings of this build.
const BODY_MAX: usize = 4 * GROUP_HEADER
    + ControlGroup::POSTCARD_MAX_SIZE
    + Parameters::<f32>::POSTCARD_MAX_SIZE
    + JointsGroup::POSTCARD_MAX_SIZE
    + Limits::POSTCARD_MAX_SIZE;
/// Longest record with settings of this build.
pub(super) const SETTINGS_MAX: usize = HEADER + BODY_MAX + CRC_LEN;
/// Length of a receipt.
pub(super) const RECEIPT_LEN: usize = HEADER + CRC_LEN;
/// Longest record that is read: more than this build writes, so that one of
/// another version is known for what it is.
pub(super) const MAX: usize = 1_024;
const _: () = assert!(SETTINGS_MAX <= MAX);

/// The bytes of a record.
pub(super) type Bytes = heapless::Vec<u8, MAX>;

/// Kind of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Settings,
    Receipt,
}

/// A record whose CRC is right.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record<'a> {
    pub(super) format: u8,
    pub(super) kind: Kind,
    pub(super) generation: u32,
    body: &'a [u8],
}

/// An intact record of this version that does not decode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Malformed;

impl<'a> Record<'a> {
    /// The record in these bytes, if they are one.
    pub(super) fn read(bytes: &'a [u8]) -> Option<Self> {
        let (plain, crc) = bytes.split_last_chunk::<CRC_LEN>()?;
        if crc32::checksum(plain) != u32::from_le_bytes(*crc) {
            return None;
        }
        let ([format, kind, generation @ ..], body) = plain.split_first_chunk::<HEADER>()?;
        let kind = match kind {
            b'S' => Kind::Settings,
            b'R' => Kind::Receipt,
            _ => return None,
        };
        Some(Self {
            format: *format,
            kind,
            generation: u32::from_le_bytes(*generation),
            body,
        })
    }

    /// The settings in it; groups that another version encoded otherwise are the defaults.
    pub(super) fn settings(&self) -> Result<(Settings, SettingsGroups), Malformed> {
        let mut settings = Settings::default();
        if self.format != FORMAT {
            return Ok((settings, SettingsGroups::ALL));
        }
        let setup = &mut settings.setup;
        let mut lost = SettingsGroups::NONE;
        match self.group(Tag::Control)? {
            Some(control) => {
                let (period_us, controller, integral, estimator, friction): ControlGroup = control;
                (setup.period_us, setup.controller) = (period_us, controller);
                setup.integral = integral;
                setup.estimator = estimator;
                (setup.friction_nm, setup.friction_load_percent) = friction;
            }
            None => lost = lost.or(SettingsGroups::CONTROL),
        }
        match self.group(Tag::Arm)? {
            Some(arm) => setup.arm = arm,
            None => lost = lost.or(SettingsGroups::ARM),
        }
        match self.group(Tag::Joints)? {
            Some((a, b, mode)) => (setup.joints, setup.control_mode) = ([a, b], mode),
            None => lost = lost.or(SettingsGroups::JOINTS),
        }
        match self.group(Tag::Limits)? {
            Some(limits) => settings.limits = limits,
            None => lost = lost.or(SettingsGroups::LIMITS),
        }
        Ok((settings, lost))
    }

    /// The values of a group; `None` if it is missing or encoded otherwise.
    fn group<T: Schema + DeserializeOwned>(&self, tag: Tag) -> Result<Option<T>, Malformed> {
        let mut rest = self.body;
        while let Some((head, after)) = rest.split_first_chunk::<GROUP_HEADER>() {
            let [found, hash @ .., low, high] = head;
            let len = usize::from(u16::from_le_bytes([*low, *high]));
            let (encoded, after) = after.split_at_checked(len).ok_or(Malformed)?;
            rest = after;
            if *found == tag as u8 && *hash == schema_hash::<T>() {
                return match postcard::take_from_bytes(encoded) {
                    Ok((values, [])) => Ok(Some(values)),
                    _ => Err(Malformed),
                };
            }
        }
        Ok(None)
    }
}

/// Groups, as stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tag {
    Control = 1,
    Arm = 2,
    Joints = 3,
    Limits = 4,
}

/// Changes when, and only when, the encoding of the group may.
fn schema_hash<T: Schema + ?Sized>() -> [u8; HASH_LEN] {
    Key::for_path::<T>("armbridge/settings").to_bytes()
}

/// A receipt for settings of this generation, as stored.
pub(super) fn encode_receipt(generation: u32) -> [u8; RECEIPT_LEN] {
    let [g0, g1, g2, g3] = generation.to_le_bytes();
    let mut bytes = [FORMAT, b'R', g0, g1, g2, g3, 0, 0, 0, 0];
    seal(&mut bytes);
    bytes
}

/// A record with these settings, as stored; `None` if they cannot be encoded.
pub(super) fn encode_settings(
    settings: &Settings,
    generation: u32,
) -> Option<heapless::Vec<u8, SETTINGS_MAX>> {
    let Settings { setup, limits } = settings;
    let mut record = heapless::Vec::from_array([FORMAT, b'S', 0, 0, 0, 0]);
    let control: ControlGroup = (
        setup.period_us,
        setup.controller,
        setup.integral,
        setup.estimator,
        (setup.friction_nm, setup.friction_load_percent),
    );
    append(&mut record, Tag::Control, &control)?;
    append(&mut record, Tag::Arm, &setup.arm)?;
    let [a, b] = setup.joints;
    let joints: JointsGroup = (a, b, setup.control_mode);
    append(&mut record, Tag::Joints, &joints)?;
    append(&mut record, Tag::Limits, limits)?;
    record.extend_from_slice(&[0; CRC_LEN]).ok()?;
    renumber(&mut record, generation);
    Some(record)
}

/// Appends a group; `None` if it cannot be encoded.
fn append<T: Schema + Serialize>(
    record: &mut heapless::Vec<u8, SETTINGS_MAX>,
    tag: Tag,
    values: &T,
) -> Option<()> {
    let start = record.len();
    record.resize_default(SETTINGS_MAX).ok()?;
    let room = record.get_mut(start..)?;
    let (head, room) = room.split_first_chunk_mut::<GROUP_HEADER>()?;
    let len = postcard::to_slice(values, room).ok()?.len();
    let [found, hash @ .., low, high] = head;
    *found = tag as u8;
    *hash = schema_hash::<T>();
    [*low, *high] = u16::try_from(len).ok()?.to_le_bytes();
    record.truncate(start + GROUP_HEADER + len);
    Some(())
}

/// Gives a record another generation.
pub(super) fn renumber(record: &mut [u8], generation: u32) {
    if let Some([_, _, number @ ..]) = record.first_chunk_mut::<HEADER>() {
        *number = generation.to_le_bytes();
    }
    seal(record);
}

/// Writes the CRC.
fn seal(record: &mut [u8]) {
    if let Some((plain, crc)) = record.split_last_chunk_mut::<CRC_LEN>() {
        *crc = crc32::checksum(plain).to_le_bytes();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_link::message::Setup;

    #[test]
    fn groups_of_other_formats_and_schemas_are_told_from_nonsense() {
        let settings = Settings {
            setup: Setup {
                period_us: 2_000,
                ..Setup::best()
            },
            limits: Limits {
                lost_ms: 30,
                ..Limits::default()
            },
        };
        let bytes = encode_settings(&settings, 7).unwrap();
        let record = Record::read(&bytes).unwrap();
        assert_eq!(record.generation, 7);
        assert_eq!(record.settings(), Ok((settings, SettingsGroups::NONE)));

        let later = Record {
            format: FORMAT + 1,
            ..record
        };
        let none = (Settings::default(), SettingsGroups::ALL);
        assert_eq!(later.settings(), Ok(none));

        // Each group by another version, which its hash shows; the others are read.
        let mut at = 0;
        let mut groups = heapless::Vec::<_, 4>::new();
        while at < record.body.len() {
            let mut body = Bytes::from_slice(record.body).unwrap();
            body[at + 1] ^= 1;
            let other = Record {
                body: &body,
                ..record
            };
            let (read, lost) = other.settings().unwrap();
            let is_lost = |group| lost.contains(group);
            groups.push(lost).unwrap();
            let defaults = Settings::default();
            let limits = if is_lost(SettingsGroups::LIMITS) {
                defaults.limits
            } else {
                settings.limits
            };
            let period_us = if is_lost(SettingsGroups::CONTROL) {
                1_000
            } else {
                2_000
            };
            assert_eq!((read.limits, read.setup.period_us), (limits, period_us));
            at += GROUP_HEADER + usize::from(record.body[at + 9]);
        }
        let all = [
            SettingsGroups::CONTROL,
            SettingsGroups::ARM,
            SettingsGroups::JOINTS,
            SettingsGroups::LIMITS,
        ];
        assert_eq!(groups.as_slice(), all);

        let mut body = Bytes::from_slice(record.body).unwrap();
        body.push(0).unwrap();
        let longer = Record {
            body: &body[..record.body.len() - 1],
            ..record
        };
        assert_eq!(longer.settings(), Err(Malformed));
    }
}
