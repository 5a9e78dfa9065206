//! Reach of a case's servos: times in which a packet may not arrive, or may not be the
//! board's.

use std::ops::Range;

use armbridge_servo::JOINTS;

use super::injection::Injection;
use super::kind::Kind;
use crate::half_duplex_bus::BusDirection;

/// Share of damaged bytes to the servos above which a packet may not arrive: the stop
/// sequence has 270 bytes, some of them redundant. A late byte counts like a lost one,
/// because it collides with a reply.
const BLOCKING_SHARE: f64 = 0.01;

/// Times, in µs.
#[derive(Debug, Default)]
pub(super) struct Reach {
    /// A servo could not be reached.
    blocked: Vec<(usize, Range<u64>)>,
    /// Servos may have received packets that the board did not send: bytes to them were
    /// damaged, at any rate, or there was another master. A checksum of eight bits accepts
    /// one damaged packet in 256, and the stop sequence has packets without a checksum.
    foreign: Vec<Range<u64>>,
    /// End of each servo's operation that a damaged packet has started, during which the
    /// servo receives nothing.
    busy_us: [u64; JOINTS],
}

impl Reach {
    /// Notes an injection that begins now.
    pub(super) fn begin(&mut self, injection: &Injection, now_us: u64) {
        let during_us = now_us..now_us.saturating_add(injection.lasts_us);
        if blocks(injection) {
            let servos = if injection.kind == Kind::ServoDeaf {
                injection.servo..injection.servo + 1
            } else {
                0..JOINTS
            };
            self.blocked
                .extend(servos.map(|servo| (servo, during_us.clone())));
        }
        if let Kind::Bytes(BusDirection::ToServos, _)
        | Kind::LineLow
        | Kind::LineHigh
        | Kind::SecondMaster
        | Kind::DuplicateId = injection.kind
        {
            self.foreign.push(during_us);
        }
    }

    /// Notes that a servo is in a long operation.
    pub(super) fn busy(&mut self, servo: usize, now_us: u64) {
        if let Some(busy_us) = self.busy_us.get_mut(servo) {
            *busy_us = now_us;
        }
    }

    /// Notes that all faults are removed.
    pub(super) fn repair(&mut self, now_us: u64) {
        let blocked = self.blocked.iter_mut().map(|(_, during_us)| during_us);
        for during_us in blocked.chain(&mut self.foreign) {
            during_us.end = during_us.end.min(now_us);
        }
    }

    /// Whether servos may receive packets that the board did not send, or may have within
    /// this time.
    pub(super) fn is_foreign(&self, now_us: u64, within_us: u64) -> bool {
        let mut foreign = self.foreign.iter();
        foreign.any(|at_us| (at_us.start..at_us.end.saturating_add(within_us)).contains(&now_us))
    }

    /// Whether a servo cannot be reached, or could not within this time.
    pub(super) fn is_cut_off(&self, now_us: u64, within_us: u64) -> bool {
        let is_recent = |during: &Range<u64>| {
            (during.start..during.end.saturating_add(within_us)).contains(&now_us)
        };
        self.blocked.iter().any(|(_, during)| is_recent(during))
            || self
                .busy_us
                .iter()
                .any(|at| *at > 0 && *at + within_us > now_us)
    }

    /// The part of a time that counts: from when this servo could be reached last.
    pub(super) fn reachable_from(&self, servo: usize, from_us: u64, until_us: u64) -> u64 {
        let busy_us = self.busy_us.get(servo).copied().unwrap_or(0);
        let mut from_us = from_us.max(busy_us);
        for (blocked, during_us) in &self.blocked {
            let counts = *blocked == servo && during_us.start < until_us;
            if counts && during_us.end > from_us {
                from_us = during_us.end;
            }
        }
        from_us
    }
}

/// Whether packets may not reach the servo during the injection.
pub(super) fn blocks(injection: &Injection) -> bool {
    match injection.kind {
        Kind::LineLow | Kind::LineHigh | Kind::ServoDeaf => true,
        Kind::Bytes(BusDirection::ToServos, _) => injection.amount > BLOCKING_SHARE,
        _ => false,
    }
}
