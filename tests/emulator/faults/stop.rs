//! The stop sequence, as bytes on the bus.

use armbridge_board::bridge::SERVO_IDS;
use armbridge_servo::stop::{StopStep, stop_steps};

/// All its bytes, without the pauses.
pub(crate) fn sequence() -> Vec<u8> {
    let bytes = stop_steps(SERVO_IDS).flat_map(|step| match step {
        StopStep::Send(packet) => packet.to_vec(),
        StopStep::Repeat(byte, count) => vec![byte; usize::from(count)],
        StopStep::Pause { .. } => Vec::new(),
    });
    bytes.collect()
}

/// Where complete sequences begin in what the master sent.
pub(crate) fn find(sent: &[u8]) -> Vec<usize> {
    let sequence = sequence();
    let windows = sent.windows(sequence.len()).enumerate();
    let found = windows.filter(|(_, window)| *window == sequence);
    found.map(|(index, _)| index).collect()
}
