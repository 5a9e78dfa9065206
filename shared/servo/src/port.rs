//! Serial port of the bus master: a change of speed, beside `embedded-hal-nb`'s
//! traits.

use core::ops::RangeInclusive;

/// Baud rates at which discovery searches for servos, the likeliest first: the actual
/// rates of an AX-12A at register values 1, 3, 16 and 34 (2 000 000 / (n + 1)), which
/// are called 1 M, 500 k, 115200 and 57600; then those above [`AX12A_BAUD_MAX`] that the X series
/// has.
pub const BAUD_RATES: [u32; 8] = [
    1_000_000, 500_000, 117_647, 57_142, 2_000_000, 3_000_000, 4_000_000, 4_500_000,
];

/// Fastest baud rate at which AX-12A are searched for: Morpheus overruns at 2 M, and no tool sets a
/// stock servo to more than 1 M.
pub const AX12A_BAUD_MAX: u32 = 1_000_000;

/// Rates in bits per second that a servo can be set to: the slowest of an AX-12A, the fastest of the
/// X series.
pub const SERVO_BAUD: RangeInclusive<u32> = 7_800..=SERVO_BAUD_MAX;

/// The fastest of [`SERVO_BAUD`].
pub const SERVO_BAUD_MAX: u32 = 4_500_000;

/// The [`BAUD_RATES`] up to the fastest of a port.
pub fn baud_rates_to(max: u32) -> &'static [u32] {
    let count = BAUD_RATES.iter().position(|rate| *rate > max);
    let rates = count.and_then(|count| BAUD_RATES.get(..count));
    rates.unwrap_or(&BAUD_RATES)
}

/// Time of one byte on the wire: ten bits at 1 Mbaud.
pub const BYTE_US: u64 = 10;

/// A serial port whose speed can be changed.
pub trait SetBaud {
    /// Sends and receives at this many bits per second from now on. Called only
    /// while nothing is being sent.
    fn set_baud(&mut self, baud: u32);
}

/// Time of a byte on the wire in ns: ten bits, each rounded up. The tick computes
/// with it, so it is 32 bits wide: the processor divides those in hardware.
pub const fn byte_ns(baud: u32) -> u32 {
    1_000_000_000_u32
        .div_ceil(if baud == 0 { 1 } else { baud })
        .saturating_mul(10)
}

/// Time of this many bytes on the wire in µs, rounded up.
pub const fn bytes_us(bytes: u32, baud: u32) -> u64 {
    bytes.saturating_mul(byte_ns(baud)).div_ceil(1_000) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_takes_ten_bits() {
        assert_eq!(bytes_us(1, 1_000_000), 10);
        assert_eq!(bytes_us(14, 57_142), 2_451);
    }

    #[test]
    fn the_fastest_rates_are_last() {
        assert_eq!(baud_rates_to(1_000_000), &BAUD_RATES[..4]);
        assert_eq!(baud_rates_to(3_100_000), &BAUD_RATES[..6]);
        assert_eq!(baud_rates_to(u32::MAX), BAUD_RATES);
    }
}
