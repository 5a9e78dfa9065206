//! Random numbers for tests: varied, seeded, the same on every machine.

/// Marsaglia's xorshift64.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of this seed, which must not be 0.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number from 0 to `limit` - 1.
    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % limit
    }

    /// True once in `times`.
    pub fn once_in(&mut self, times: u64) -> bool {
        self.below(times) == 0
    }

    /// Any byte.
    pub fn byte(&mut self) -> u8 {
        self.below(256) as u8
    }

    /// One of these.
    pub fn one_of<T: Copy>(&mut self, choice: &[T]) -> T {
        choice[self.below(choice.len() as u64) as usize]
    }

    /// Up to `most` bytes, any of `choice` or, where that is empty, of all.
    pub fn bytes(&mut self, most: u64, choice: &[u8]) -> Vec<u8> {
        (0..self.below(most + 1))
            .map(|_| match choice {
                [] => self.byte(),
                _ => self.one_of(choice),
            })
            .collect()
    }

    /// Changes, drops, doubles or inserts a byte, or cuts the rest off.
    pub fn damage(&mut self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let at = self.below(bytes.len() as u64) as usize;
        match self.below(5) {
            0 => bytes[at] = self.byte(),
            1 => drop(bytes.remove(at)),
            2 => bytes.insert(at, bytes[at]),
            3 => bytes.insert(at, self.byte()),
            _ => bytes.truncate(at),
        }
    }
}
