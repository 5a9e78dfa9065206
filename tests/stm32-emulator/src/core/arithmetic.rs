//! Integer arithmetic with flags: addition with carry, shifts, conditions, IT state, saturation.
//!
//! Pure functions. Source: DDI 0403, A2.2.1 (shifts and addition), A7.3 (conditions), D6.

use super::instruction::Shift;

/// Sum of two numbers and a carry, and its carry and overflow.
#[inline]
pub(crate) fn add_with_carry(x: u32, y: u32, carry: bool) -> (u32, bool, bool) {
    let (sum, first) = x.overflowing_add(y);
    let (sum, second) = sum.overflowing_add(u32::from(carry));
    let overflow = ((x ^ sum) & (y ^ sum)) >> 31 != 0;
    (sum, first | second, overflow)
}

/// Shifts by 0 to 255 places; the carry stays as it is when there are none.
#[inline]
pub(crate) fn shift(value: u32, kind: Shift, amount: u32, carry: bool) -> (u32, bool) {
    if kind == Shift::Rrx {
        return (value >> 1 | u32::from(carry) << 31, value & 1 != 0);
    }
    if amount == 0 {
        return (value, carry);
    }
    let bit = |number: u32| value >> number & 1 != 0;
    match kind {
        Shift::Lsl => match amount {
            1..=31 => (value << amount, bit(32 - amount)),
            32 => (0, bit(0)),
            _ => (0, false),
        },
        Shift::Lsr => match amount {
            1..=31 => (value >> amount, bit(amount - 1)),
            32 => (0, bit(31)),
            _ => (0, false),
        },
        Shift::Asr => {
            let places = amount.min(32);
            let sign = (value as i32 >> 31) as u32;
            if places == 32 {
                (sign, bit(31))
            } else {
                ((value as i32 >> places) as u32, bit(places - 1))
            }
        }
        Shift::Ror | Shift::Rrx => {
            let result = value.rotate_right(amount & 31);
            (result, result >> 31 != 0)
        }
    }
}

/// The flags of the program status register.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "they are four flags")]
pub(crate) struct Flags {
    pub(crate) n: bool,
    pub(crate) z: bool,
    pub(crate) c: bool,
    pub(crate) v: bool,
}

impl Flags {
    /// From bits 31 to 28 of a status register.
    pub(crate) fn from_bits(bits: u32) -> Self {
        let bit = |number: u32| bits >> number & 1 != 0;
        Self {
            n: bit(31),
            z: bit(30),
            c: bit(29),
            v: bit(28),
        }
    }

    /// Bits 31 to 28 of a status register.
    pub(crate) fn bits(self) -> u32 {
        let bit = |flag: bool, number: u32| u32::from(flag) << number;
        bit(self.n, 31) | bit(self.z, 30) | bit(self.c, 29) | bit(self.v, 28)
    }

    /// Whether a condition (bits 3 to 0) holds.
    #[inline]
    pub(crate) fn hold(self, condition: u8) -> bool {
        let holds = match condition >> 1 & 7 {
            0 => self.z,
            1 => self.c,
            2 => self.n,
            3 => self.v,
            4 => self.c && !self.z,
            5 => self.n == self.v,
            6 => self.n == self.v && !self.z,
            _ => return true,
        };
        holds != (condition & 1 != 0)
    }
}

/// State of an IT block after one of its instructions.
#[inline]
pub(crate) fn advance_it(state: u8) -> u8 {
    if matches!(state & 7, 0) {
        0
    } else {
        state & 0xE0 | state << 1 & 0x1F
    }
}

/// The nearest number in the signed range of so many bits, 1 to 32, and whether it differs.
pub(crate) fn saturate_signed(value: i64, bits: u32) -> (u32, bool) {
    let limit = 1_i64 << (bits - 1);
    let result = value.clamp(-limit, limit - 1);
    (result as u32, result != value)
}

/// The nearest number in the unsigned range of so many bits, 0 to 32, and whether it differs.
pub(crate) fn saturate_unsigned(value: i64, bits: u32) -> (u32, bool) {
    let result = value.clamp(0, (1_i64 << bits) - 1);
    (result as u32, result != value)
}

/// Sign-extends the low `bits` bits.
#[inline]
pub(crate) fn sign_extend(value: u32, bits: u32) -> i32 {
    let places = 32 - bits;
    (value << places) as i32 >> places
}
