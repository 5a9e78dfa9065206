//! Check words: whether numbers in memory are still those that were set.
//!
//! A [`CheckWord`] is a sum over 32-bit words, kept beside what it protects and
//! compared before that is used. A word that changes in any of its bits changes
//! the sum for certain: each step, `sum = (sum xor word) * 16777619` (FNV-1a, on
//! words instead of bytes), is invertible in the word. Changes of several words
//! go unnoticed once in 2^32 times.
//!
//! That takes three instructions a word on a Cortex-M4, so it runs in every tick;
//! a CRC-32 by table, which would notice the same, takes some 25.
//!
//! [`Checked`] lists the words of a value.
//!
//! A choice between a few values is kept as a code word instead, far from any other's, by
//! which a [`CodeTable`] finds the value.

use nalgebra::{ArrayStorage, Const, Matrix};

/// Offset basis and prime of the 32-bit FNV-1a.
const BASIS: u32 = 0x811C_9DC5;
const PRIME: u32 = 0x0100_0193;

/// A sum over words, see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct CheckWord(u32);

impl CheckWord {
    /// The sum over the words of `value`.
    pub fn compute(value: &(impl Checked + ?Sized)) -> Self {
        let mut sum = Self(BASIS);
        value.check(&mut sum);
        sum
    }

    /// Adds a word.
    #[inline]
    pub fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ word).wrapping_mul(PRIME);
    }
}

/// Data under a [`CheckWord`].
pub trait Checked {
    /// Adds all its words, in a fixed order.
    fn check(&self, sum: &mut CheckWord);
}

/// Places of a [`CodeTable`].
const PLACES: usize = 16;

/// Values with their code words, whose last four bits are their place.
#[derive(Clone, Copy, Debug)]
pub struct CodeTable<T>([(T, u32); PLACES]);

impl<T: Copy> CodeTable<T> {
    /// A table of these values, in the order of their places.
    ///
    /// # Panics
    /// At compile time: without a value, and with a word in another place than its own.
    pub const fn new<const N: usize>(codes: &[(T, u32); N]) -> Self {
        assert!(N > 0 && N <= PLACES);
        // The word 0 is in none of the places that are left over.
        let mut table = [(codes[0].0, 0); PLACES];
        let mut place = 0;
        while place < N {
            assert!(codes[place].1 as usize % PLACES == place);
            table[place] = codes[place];
            place += 1;
        }
        Self(table)
    }

    /// The value with this code word; `None` if the word is no value's.
    #[inline]
    pub fn decode(&self, word: u32) -> Option<T> {
        let (value, code) = self.0[word as usize % PLACES];
        (code == word).then_some(value)
    }
}

macro_rules! integers {
    ($($integer:ty),*) => {$(
        impl Checked for $integer {
            #[inline]
            fn check(&self, sum: &mut CheckWord) {
                sum.word(u32::from(*self));
            }
        }
    )*};
}

integers!(bool, u8, u16, u32);

impl Checked for u64 {
    fn check(&self, sum: &mut CheckWord) {
        sum.word(*self as u32);
        sum.word((*self >> 32) as u32);
    }
}

impl Checked for f32 {
    #[inline]
    fn check(&self, sum: &mut CheckWord) {
        sum.word(self.to_bits());
    }
}

impl<T: Checked> Checked for [T] {
    #[inline]
    fn check(&self, sum: &mut CheckWord) {
        for value in self {
            value.check(sum);
        }
    }
}

impl<T: Checked, const N: usize> Checked for [T; N] {
    #[inline]
    fn check(&self, sum: &mut CheckWord) {
        self.as_slice().check(sum);
    }
}

impl<T: Checked, const N: usize> Checked for heapless::Vec<T, N> {
    fn check(&self, sum: &mut CheckWord) {
        self.as_slice().check(sum);
    }
}

impl<T: Checked, const N: usize> Checked for heapless::Deque<T, N> {
    fn check(&self, sum: &mut CheckWord) {
        for value in self {
            value.check(sum);
        }
    }
}

impl<T: Checked> Checked for Option<T> {
    fn check(&self, sum: &mut CheckWord) {
        sum.word(self.is_some().into());
        if let Some(value) = self {
            value.check(sum);
        }
    }
}

impl<T: Checked, const R: usize, const C: usize> Checked
    for Matrix<T, Const<R>, Const<C>, ArrayStorage<T, R, C>>
{
    #[inline]
    fn check(&self, sum: &mut CheckWord) {
        self.data.0.check(sum);
    }
}

/// Lists the fields of a checked type.
#[macro_export]
macro_rules! checked {
    ($name:ident { $($field:ident),* $(,)? }) => {
        impl $crate::check_word::Checked for $name {
            #[inline]
            fn check(&self, sum: &mut $crate::check_word::CheckWord) {
                let Self { $($field),* } = self;
                $($crate::check_word::Checked::check($field, sum);)*
            }
        }
    };
    ($name:ident<T> { $($field:ident),* $(,)? }) => {
        impl<T: $crate::check_word::Checked> $crate::check_word::Checked for $name<T> {
            #[inline]
            fn check(&self, sum: &mut $crate::check_word::CheckWord) {
                let Self { $($field),* } = self;
                $($crate::check_word::Checked::check($field, sum);)*
            }
        }
    };
}
pub use crate::checked;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_bit_and_any_exchange_of_two_words_shows() {
        let words = [0.5_f32, -1.5, 0.0, 3.25];
        let before = CheckWord::compute(&words);
        for index in 0..words.len() {
            for bit in 0..32 {
                let mut changed = words;
                changed[index] = f32::from_bits(words[index].to_bits() ^ 1 << bit);
                assert_ne!(
                    CheckWord::compute(&changed),
                    before,
                    "word {index}, bit {bit}"
                );
            }
            for other in 0..index {
                let mut exchanged = words;
                exchanged.swap(index, other);
                assert_ne!(
                    CheckWord::compute(&exchanged),
                    before,
                    "{index} and {other}"
                );
            }
        }
    }
}
