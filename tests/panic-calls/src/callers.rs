//! Callers of panics in an image for the Cortex-M4F.
//!
//! Every branch with link, and every far jump, is decoded. Those into
//! `core::panicking` are the panics; where the caller is itself one of the core
//! library's functions, such as the one that reports a bad index, its callers
//! are. The debug information has the source lines of each, with
//! everything that was inlined.

use std::collections::{BTreeSet, HashSet};
use std::error::Error;
use std::fmt;
use std::path::Path;

use addr2line::{FunctionName, Loader};
use object::{Object, ObjectSection};

/// Part of the names of the core library's panics.
const PANICKING: &str = "9panicking";
/// Part of the paths of its sources.
const CORE: &str = "/library/core/";

/// A call that leads to a panic: its places in the source, innermost first.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Call(Vec<Place>);

#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    function: String,
    file: String,
    line: u32,
}

impl Call {
    /// Whether a function of this name, or a closure in it, is among the places.
    pub(crate) fn is_in(&self, name: &str) -> bool {
        self.0.iter().any(|place| place.function.contains(name))
    }

    /// Whether all of it is the core library.
    fn is_core(&self) -> bool {
        self.0.iter().all(|place| place.file.contains(CORE))
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (depth, place) in self.0.iter().enumerate() {
            let by = if depth == 0 { "-" } else { " " };
            let (file, function) = (short(&place.file), &place.function);
            match place.line {
                // Alike calls of several places, made one.
                0 => writeln!(f, "  {by} {file}  {function}")?,
                line => writeln!(f, "  {by} {file}:{line}  {function}")?,
            }
        }
        Ok(())
    }
}

/// A path without where the project, the toolchain or the registry's copies are.
fn short(file: &str) -> &str {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/");
    let root = root.strip_suffix("tests/panic-calls/").unwrap_or(root);
    let registry = file.split_once("/registry/src/");
    let package = registry.and_then(|(_, rest)| rest.split_once('/'));
    package
        .map(|(_, rest)| rest)
        .or_else(|| file.find(CORE).and_then(|at| file.get(at + 1..)))
        .or_else(|| file.strip_prefix(root))
        .unwrap_or(file)
}

/// Every call in `image` that leads to a panic, core library left out.
pub(crate) fn of_panics(image: &Path) -> Result<Vec<Call>, Box<dyn Error>> {
    let bytes = std::fs::read(image)?;
    let text = object::File::parse(&*bytes)?
        .section_by_name(".text")
        .map(|section| Ok::<_, object::Error>(branches(section.data()?, section.address())))
        .ok_or("there is no code in it")??;
    let loader = Loader::new(image)?;
    // An odd address marks Thumb code in symbols.
    let function = |address: u64| loader.find_symbol_info(address | 1);
    let mut panicking: HashSet<u64> = text
        .iter()
        .filter_map(|branch| function(branch.to))
        .filter(|symbol| symbol.name().contains(PANICKING))
        .map(|symbol| symbol.address())
        .collect();
    let mut calls = BTreeSet::new();
    loop {
        let before = panicking.len();
        for branch in &text {
            let (Some(from), Some(to)) = (function(branch.from), function(branch.to)) else {
                continue;
            };
            if !panicking.contains(&to.address()) || panicking.contains(&from.address()) {
                continue;
            }
            let call = Call(places(&loader, branch.from)?);
            if call.is_core() {
                panicking.insert(from.address());
            } else {
                calls.insert(call);
            }
        }
        if panicking.len() == before {
            return Ok(calls.into_iter().collect());
        }
    }
}

fn places(loader: &Loader, address: u64) -> Result<Vec<Place>, Box<dyn Error>> {
    let mut frames = loader.find_frames(address)?;
    let mut places = Vec::new();
    while let Some(frame) = frames.next()? {
        let location = frame.location.as_ref();
        let name = frame.function.as_ref().map(FunctionName::demangle);
        places.push(Place {
            function: name.transpose()?.unwrap_or_default().into_owned(),
            file: location.and_then(|l| l.file).unwrap_or("?").to_owned(),
            line: location.and_then(|l| l.line).unwrap_or(0),
        });
    }
    Ok(places)
}

/// A `BL` or `B.W`.
#[derive(Debug, PartialEq)]
struct Branch {
    from: u64,
    to: u64,
}

/// Those in `code` at `begin`. What lies between two instructions is looked at
/// too, and data: such branches lead to no function's beginning.
fn branches(code: &[u8], begin: u64) -> Vec<Branch> {
    let halves: Vec<u32> = code
        .chunks_exact(2)
        .map(|half| u32::from(u16::from_le_bytes([half[0], half[1]])))
        .collect();
    let pairs = halves.windows(2).zip((begin..).step_by(2));
    pairs
        .filter_map(|(pair, from)| {
            let offset = offset(pair[0], pair[1])?;
            let to = from.checked_add_signed(4 + offset)?;
            Some(Branch { from, to })
        })
        .collect()
}

/// Reach of a `BL` (encoding T1) or `B.W` (T4), counted from 4 bytes on.
/// `11110 S imm10  1 x J1 1 J2 imm11`, Armv7-M Architecture Reference Manual,
/// A7.7.12 and A7.7.18.
fn offset(first: u32, second: u32) -> Option<i64> {
    if first >> 11 != 0b11110 || second & 0x9000 != 0x9000 {
        return None;
    }
    let sign = first >> 10 & 1;
    let bit = |at: u32| !(second >> at ^ sign) & 1;
    let offset = sign << 24 | bit(13) << 23 | bit(11) << 22 | (first & 0x3FF) << 12;
    let offset = offset | (second & 0x7FF) << 1;
    // From 25 bits, of which the first is the sign.
    Some(i64::from((offset << 7) as i32 >> 7))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_are_decoded_as_the_disassembler_does() {
        // bl +0xA06, and bl -0x2FA: both from the instruction's end.
        for (code, expected) in [
            ([0x00, 0xF0, 0x03, 0xFD], 0xA06),
            ([0xFF, 0xF7, 0x83, 0xFE], -0x2FA),
        ] {
            let to = 0x38D94_i64 + expected;
            let branch = Branch {
                from: 0x38D90,
                to: to as u64,
            };
            assert_eq!(branches(&code, 0x38D90), [branch]);
        }
        // mov r0, r2; mov r2, r1
        assert_eq!(branches(&[0x10, 0x46, 0x0A, 0x46], 0), []);
    }
}
