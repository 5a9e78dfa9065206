//! Modes, faults and kinds of missing samples as the numbers of the log's schema, which has them
//! by the same names.

use super::proto;
use armbridge_client::enum_names::{self, MISSING, MODES};
use armbridge_link::message::{Fault, Missing, Mode};
use std::sync::LazyLock;

/// Values and their numbers.
type Codes<T, N> = LazyLock<Vec<(T, N)>>;

static MODE: Codes<Mode, proto::Mode> =
    LazyLock::new(|| codes(&MODES, "MODE", enum_names::mode, proto::Mode::from_str_name));
static FAULT: Codes<Fault, proto::Fault> = LazyLock::new(|| {
    codes(
        &Fault::ALL,
        "FAULT",
        Fault::name,
        proto::Fault::from_str_name,
    )
});
static KIND: Codes<Missing, proto::Missing> = LazyLock::new(|| {
    codes(
        &MISSING,
        "MISSING",
        enum_names::missing,
        proto::Missing::from_str_name,
    )
});

/// Pairs each value with the number that has its name.
fn codes<T: Copy, N>(
    all: &[T],
    prefix: &str,
    name_of: fn(T) -> &'static str,
    number_of: fn(&str) -> Option<N>,
) -> Vec<(T, N)> {
    let number = |value: &T| {
        let name = name_of(*value).to_uppercase();
        Some((*value, number_of(&format!("{prefix}_{name}"))?))
    };
    all.iter().filter_map(number).collect()
}

fn code<T: PartialEq, N: Copy + Default>(codes: &Codes<T, N>, value: &T) -> N {
    let found = codes.iter().find(|(known, _)| known == value);
    found.map_or_else(N::default, |(_, number)| *number)
}

fn value<T: Copy, N: PartialEq>(codes: &Codes<T, N>, number: &N) -> Option<T> {
    let found = codes.iter().find(|(_, known)| known == number);
    found.map(|(value, _)| *value)
}

/// Numbers of a mode and its fault.
pub(super) fn mode(mode: Mode) -> (proto::Mode, proto::Fault) {
    match mode {
        Mode::Fault(fault) => (proto::Mode::Fault, code(&FAULT, &fault)),
        driven => (code(&MODE, &driven), proto::Fault::None),
    }
}

/// The mode of these numbers; `None` for a fault without a cause.
pub(super) fn mode_from(mode: proto::Mode, fault: proto::Fault) -> Option<Mode> {
    match mode {
        proto::Mode::Fault => value(&FAULT, &fault).map(Mode::Fault),
        driven => value(&MODE, &driven),
    }
}

/// Number of a kind of missing sample.
pub(super) fn missing(missing: Missing) -> proto::Missing {
    code(&KIND, &missing)
}

/// The kind of missing sample of this number.
pub(super) fn missing_from(missing: proto::Missing) -> Option<Missing> {
    value(&KIND, &missing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_maps_back_to_its_value() {
        let modes = MODES.into_iter();
        for known in modes.chain(Fault::ALL.into_iter().map(Mode::Fault)) {
            let (number, fault) = mode(known);
            assert_eq!(mode_from(number, fault), Some(known));
        }
        for known in MISSING {
            assert_eq!(missing_from(missing(known)), Some(known));
        }
    }
}
