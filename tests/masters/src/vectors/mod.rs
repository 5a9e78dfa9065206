//! Packets that the masters make of instructions, in the form of `shared/servo/tests/protocol2`:
//!
//!     masters vectors > ../../shared/servo/tests/protocol2/masters.txt
//!
//! Each line has an instruction in words and its packet, under the masters that have the instruction;
//! where both have it, their packets are the same. `dynamixel2` 0.9.1 is out of step after FF FF FF,
//! and may leave an FF FF FD that ends in FF FF FF FD as it is, which the vendor's SDK does not: where
//! that may be so, its packet is left out.

mod instruction;
mod packets;

use instruction::instructions;
use packets::{Dynamixel2, Rustypot};

use crate::check::Result;

/// Whether `dynamixel2` may have left out a byte of stuffing.
fn is_out_of_step(packet: &[u8]) -> bool {
    packet
        .windows(4)
        .any(|four| four == [0xFF, 0xFF, 0xFF, 0xFD])
}

/// Prints the packets.
pub(crate) fn print() -> Result {
    let (mut rustypot, mut dynamixel2) = (Rustypot::new()?, Dynamixel2::new()?);
    let [mut both, mut first, mut second] = [const { Vec::new() }; 3];
    for instruction in instructions() {
        let packets = (
            rustypot.packet(&instruction)?,
            dynamixel2.packet(&instruction)?,
        );
        let (packet, list) = match packets {
            (Some(a), Some(b)) if a == b => (a, &mut both),
            (Some(a), None) => (a, &mut first),
            (Some(a), Some(b)) if is_out_of_step(&b) => (a, &mut first),
            (Some(a), Some(b)) => {
                return Err(format!("{instruction}: {a:02X?} and {b:02X?}").into());
            }
            (None, Some(b)) if is_out_of_step(&b) => continue,
            (None, Some(b)) => (b, &mut second),
            (None, None) => return Err(format!("no master has {instruction}").into()),
        };
        list.push(format!("{instruction} | {}", instruction::hex(&packet)));
    }
    println!("# Made by `masters vectors` in tests/masters.");
    for (makers, lines) in [
        ("rustypot 1.13.1 and dynamixel2 0.9.1", both),
        ("rustypot 1.13.1", first),
        ("dynamixel2 0.9.1", second),
    ] {
        println!("# {makers}");
        for line in lines {
            println!("{line}");
        }
    }
    Ok(())
}
