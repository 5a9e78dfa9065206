//! A set of exceptions, by their numbers from 0 to 255.

/// A set of exceptions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Exceptions(pub(crate) [u64; 4]);

impl Exceptions {
    /// Whether the exception is one.
    pub(crate) fn has(&self, number: u16) -> bool {
        self.0[usize::from(number >> 6 & 3)] >> (number & 63) & 1 != 0
    }

    /// Adds or removes one.
    pub(crate) fn set(&mut self, number: u16, member: bool) {
        let word = &mut self.0[usize::from(number >> 6 & 3)];
        let bit = 1 << (number & 63);
        *word = if member { *word | bit } else { *word & !bit };
    }

    /// Their numbers, ascending.
    pub(crate) fn iter(self) -> impl Iterator<Item = u16> {
        (0_u16..).zip(self.0).flat_map(|(index, word)| {
            let mut rest = word;
            std::iter::from_fn(move || {
                let bit = rest.trailing_zeros();
                rest &= rest.wrapping_sub(1);
                (bit < 64).then_some(index * 64 + bit as u16)
            })
        })
    }

    /// Those in both.
    pub(crate) fn and(self, other: Self) -> Self {
        Self(std::array::from_fn(|index| self.0[index] & other.0[index]))
    }
}
