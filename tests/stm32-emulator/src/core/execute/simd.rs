//! Bit fields, extension, saturation and parallel arithmetic.
//! Source: DDI 0403, A4.4.4 to A4.4.9 and A7.7.

use super::super::Core;
use super::super::arithmetic::{saturate_signed, saturate_unsigned, shift, sign_extend};
use super::super::instruction::{Extend, Lanes, Parallel, Reg, Reverse, Shift};

/// Ones in so many low bits, 1 to 32.
fn ones(width: u8) -> u32 {
    u32::MAX >> (32 - width)
}

/// Both halves made of one function.
fn halves(function: impl Fn(u32) -> u32) -> u32 {
    function(0) & 0xFFFF | function(16) << 16
}

impl Core {
    pub(super) fn extend(&mut self, kind: Extend, d: Reg, n: Reg, m: Reg, rotate: u8) {
        let value = self.get(m).rotate_right(u32::from(rotate));
        let addend = if n == 15 { 0 } else { self.get(n) };
        let result = match kind {
            Extend::SignedByte => addend.wrapping_add(value as i8 as u32),
            Extend::SignedHalf => addend.wrapping_add(value as i16 as u32),
            Extend::Byte => addend.wrapping_add(value & 0xFF),
            Extend::Half => addend.wrapping_add(value & 0xFFFF),
            Extend::SignedBytes => halves(|place| {
                let byte = (value >> place) as i8 as u32;
                (addend >> place).wrapping_add(byte)
            }),
            Extend::Bytes => halves(|place| (addend >> place).wrapping_add(value >> place & 0xFF)),
        };
        self.put(d, result);
    }

    pub(super) fn reverse(&mut self, kind: Reverse, d: Reg, m: Reg) {
        let value = self.get(m);
        let result = match kind {
            Reverse::Bytes => value.swap_bytes(),
            Reverse::BytesOfHalves => value.swap_bytes().rotate_left(16),
            Reverse::SignedHalf => (value as u16).swap_bytes() as i16 as u32,
            Reverse::Bits => value.reverse_bits(),
            Reverse::Count => value.leading_zeros(),
        };
        self.put(d, result);
    }

    pub(super) fn insert(&mut self, d: Reg, n: Reg, lsb: u8, width: u8) {
        let mask = ones(width) << lsb;
        let value = if n == 15 { 0 } else { self.get(n) << lsb };
        self.put(d, self.get(d) & !mask | value & mask);
    }

    pub(super) fn extract(&mut self, signed: bool, d: Reg, n: Reg, lsb: u8, width: u8) {
        let value = self.get(n) >> lsb;
        let result = if signed {
            sign_extend(value, u32::from(width)) as u32
        } else {
            value & ones(width)
        };
        self.put(d, result);
    }

    pub(super) fn saturate(&mut self, signed: bool, d: Reg, n: Reg, to: u8, by: (Shift, u8)) {
        let (value, _) = shift(self.get(n), by.0, u32::from(by.1), false);
        let value = i64::from(value as i32);
        let (result, saturated) = if signed {
            saturate_signed(value, u32::from(to))
        } else {
            saturate_unsigned(value, u32::from(to))
        };
        self.saturated |= saturated;
        self.put(d, result);
    }

    pub(super) fn saturate_halves(&mut self, signed: bool, d: Reg, n: Reg, to: u8) {
        let value = self.get(n);
        let one = |place: u32| {
            let half = i64::from((value >> place) as i16);
            if signed {
                saturate_signed(half, u32::from(to))
            } else {
                saturate_unsigned(half, u32::from(to))
            }
        };
        self.saturated |= one(0).1 | one(16).1;
        self.put(d, halves(|place| one(place).0));
    }

    pub(super) fn saturating_add(&mut self, subtract: bool, double: bool, d: Reg, n: Reg, m: Reg) {
        let (x, mut y) = (i64::from(self.get(m) as i32), i64::from(self.get(n) as i32));
        if double {
            let (doubled, saturated) = saturate_signed(y * 2, 32);
            self.saturated |= saturated;
            y = i64::from(doubled as i32);
        }
        let sum = if subtract { x - y } else { x + y };
        let (result, saturated) = saturate_signed(sum, 32);
        self.saturated |= saturated;
        self.put(d, result);
    }

    pub(super) fn pack(&mut self, top: bool, d: Reg, n: Reg, m: Reg, amount: u8) {
        let kind = if top { Shift::Asr } else { Shift::Lsl };
        let (shifted, _) = shift(self.get(m), kind, u32::from(amount), false);
        let other = self.get(n);
        let result = if top {
            other & 0xFFFF_0000 | shifted & 0xFFFF
        } else {
            shifted & 0xFFFF_0000 | other & 0xFFFF
        };
        self.put(d, result);
    }

    /// Bytes of n where GE is set, of m where not.
    pub(super) fn select(&mut self, d: Reg, n: Reg, m: Reg) {
        let (x, y) = (self.get(n).to_le_bytes(), self.get(m).to_le_bytes());
        let byte = |lane: usize| {
            if self.greater >> lane & 1 != 0 {
                x[lane]
            } else {
                y[lane]
            }
        };
        let result = u32::from_le_bytes(std::array::from_fn(byte));
        self.put(d, result);
    }

    pub(super) fn parallel(&mut self, lanes: Lanes, op: Parallel, d: Reg, n: Reg, m: Reg) {
        let (x, y) = (self.get(n), self.get(m));
        let bits = match op {
            Parallel::Add8 | Parallel::Subtract8 => 8,
            _ => 16,
        };
        let signed = matches!(
            lanes,
            Lanes::Signed | Lanes::SignedSaturating | Lanes::SignedHalving
        );
        let lane = |value: u32, place: u32| {
            let value = value >> place & (u32::MAX >> (32 - bits));
            if signed {
                i64::from(sign_extend(value, bits))
            } else {
                i64::from(value)
            }
        };
        let (mut result, mut greater) = (0, 0);
        for place in (0..32).step_by(bits as usize) {
            // What the first lane does, the exchanging ones do crosswise.
            let (subtracts, other) = match op {
                Parallel::Add8 | Parallel::Add16 => (false, place),
                Parallel::Subtract8 | Parallel::Subtract16 => (true, place),
                Parallel::AddSubtract => (place == 0, 16 - place),
                Parallel::SubtractAdd => (place != 0, 16 - place),
            };
            let (a, b) = (lane(x, place), lane(y, other));
            let sum = if subtracts { a - b } else { a + b };
            let is_greater = match (signed, subtracts) {
                (true, _) | (false, true) => sum >= 0,
                (false, false) => sum >> bits != 0,
            };
            if is_greater {
                greater |= (if bits == 8 { 1 } else { 3 }) << (place / 8);
            }
            let value = match lanes {
                Lanes::Signed | Lanes::Unsigned => sum as u32,
                Lanes::SignedHalving | Lanes::UnsignedHalving => (sum >> 1) as u32,
                Lanes::SignedSaturating => saturate_signed(sum, bits).0,
                Lanes::UnsignedSaturating => saturate_unsigned(sum, bits).0,
            };
            result |= (value & (u32::MAX >> (32 - bits))) << place;
        }
        if matches!(lanes, Lanes::Signed | Lanes::Unsigned) {
            self.greater = greater;
        }
        self.put(d, result);
    }
}
