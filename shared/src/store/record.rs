//! Records of the settings store, as bytes.
//!
//! ```text
//! format u8 | kind u8 | generation u32 | body | CRC-32
//! ```
//!
//! Integers are little endian. Header and CRC stay as they are in every format;
//! a new format number means other bodies. There are two kinds:
//!
//! | kind    | body                                              | meaning         |
//! |---------|---------------------------------------------------|-----------------|
//! | `b'S'`  | hash of the schema of [`Settings`], then postcard | these are the settings |
//! | `b'R'`  | none                                              | the settings of this generation were written and read back |
//!
//! Generations count up with each save. A receipt without its settings is how a
//! damaged save is distinguished from one that power-off cut short: the latter has none.
//!
//! The storage crate has a CRC of its own. It covers what the crate was handed
//! until it hands it back, and its record layout may change with its version. This
//! CRC covers the rest of the way, encoder to decoder, RAM included, and makes a
//! forged record as unlikely as 64 bits do.

use crate::crc32;
use crate::link::message::Settings;
use postcard::experimental::max_size::MaxSize;
use postcard_schema::key::Key;

/// Number of this layout.
const FORMAT: u8 = 1;
const HEADER: usize = 6;
const CRC_LEN: usize = 4;
const HASH_LEN: usize = 8;
/// Changes when, and only when, the encoding of [`Settings`] may.
const HASH: [u8; HASH_LEN] = Key::for_path::<Settings>("armbridge/settings").to_bytes();

/// Longest record with settings of this build.
pub(super) const SETTINGS_MAX: usize = HEADER + HASH_LEN + Settings::POSTCARD_MAX_SIZE + CRC_LEN;
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

/// Reason why an intact record has no usable settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unusable {
    OtherVersion,
    /// The body of this version does not decode.
    Malformed,
}

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

    /// The same record with another generation.
    pub(super) fn renumbered(self, generation: u32) -> Self {
        Self { generation, ..self }
    }

    /// A receipt for settings of this generation.
    pub(super) fn receipt(generation: u32) -> Self {
        Self {
            format: FORMAT,
            kind: Kind::Receipt,
            generation,
            body: &[],
        }
    }

    /// As stored; `None` if it is longer than any.
    pub(super) fn bytes(&self) -> Option<Bytes> {
        let kind = match self.kind {
            Kind::Settings => b'S',
            Kind::Receipt => b'R',
        };
        let mut bytes = Bytes::new();
        bytes.extend_from_slice(&[self.format, kind]).ok()?;
        bytes
            .extend_from_slice(&self.generation.to_le_bytes())
            .ok()?;
        bytes.extend_from_slice(self.body).ok()?;
        let crc = crc32::checksum(&bytes);
        bytes.extend_from_slice(&crc.to_le_bytes()).ok()?;
        Some(bytes)
    }

    /// The settings in it.
    pub(super) fn settings(&self) -> Result<Settings, Unusable> {
        match self.body.split_first_chunk() {
            Some((hash, encoded)) if (self.format, *hash) == (FORMAT, HASH) => {
                match postcard::take_from_bytes(encoded) {
                    Ok((settings, [])) => Ok(settings),
                    _ => Err(Unusable::Malformed),
                }
            }
            _ => Err(Unusable::OtherVersion),
        }
    }
}

/// A record with these settings, as stored; `None` if they cannot be encoded.
pub(super) fn encode_settings(settings: &Settings, generation: u32) -> Option<Bytes> {
    let mut body = [0; SETTINGS_MAX];
    let (hash, rest) = body.split_first_chunk_mut()?;
    *hash = HASH;
    let len = HASH_LEN + postcard::to_slice(settings, rest).ok()?.len();
    let record = Record {
        format: FORMAT,
        kind: Kind::Settings,
        generation,
        body: body.get(..len)?,
    };
    record.bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_formats_and_schemas_are_told_from_nonsense() {
        let settings = Settings::default();
        let bytes = encode_settings(&settings, 7).unwrap();
        let record = Record::read(&bytes).unwrap();
        assert_eq!(record.generation, 7);
        assert_eq!(record.settings(), Ok(settings));

        let later = Record {
            format: 2,
            ..record
        };
        assert_eq!(later.settings(), Err(Unusable::OtherVersion));
        let mut body = record.body.to_vec();
        body[0] ^= 1;
        let other = Record {
            body: &body,
            ..record
        };
        assert_eq!(other.settings(), Err(Unusable::OtherVersion));
        body[0] ^= 1;
        body.push(0);
        let longer = Record {
            body: &body,
            ..record
        };
        assert_eq!(longer.settings(), Err(Unusable::Malformed));

        for at in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[at] ^= 0x10;
            assert!(Record::read(&bytes).is_none(), "byte {at}");
        }
    }
}
