//! Output of postcard's for short numbers.

use postcard::ser_flavors::Flavor;

/// A slice, and the length so far.
///
/// A number has 1 to 5 bytes, or 4, for which a call of `memcpy` costs more than the
/// bytes themselves, as postcard's own output for slices has one.
pub(super) struct Output<'a> {
    into: &'a mut [u8],
    len: usize,
}

impl<'a> Output<'a> {
    /// Nothing written yet.
    pub(super) fn new(into: &'a mut [u8]) -> Self {
        Self { into, len: 0 }
    }

    #[inline]
    fn put<const N: usize>(&mut self, bytes: [u8; N]) -> postcard::Result<()> {
        let rest = self.into.get_mut(self.len..);
        let slots = rest.and_then(|rest| rest.first_chunk_mut());
        *slots.ok_or(postcard::Error::SerializeBufferFull)? = bytes;
        self.len += N;
        Ok(())
    }
}

impl Flavor for Output<'_> {
    type Output = usize;

    #[inline]
    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.put([byte])
    }

    #[inline]
    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        match *bytes {
            [a, b, c, d] => self.put([a, b, c, d]),
            _ => bytes.iter().try_for_each(|byte| self.try_push(*byte)),
        }
    }

    fn finalize(self) -> postcard::Result<usize> {
        Ok(self.len)
    }
}
