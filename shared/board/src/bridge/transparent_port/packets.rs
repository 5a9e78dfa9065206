//! For tests: packets of both protocols, made and taken apart.

extern crate std;

use armbridge_servo::{morpheus, protocol1};
use std::vec::Vec;

/// Id, code and parameters of the one packet in these bytes.
pub(super) fn stock_frame(bytes: &[u8]) -> (u8, u8, Vec<u8>) {
    let mut parser = protocol1::Parser::<259>::new();
    let (last, before) = bytes.split_last().unwrap();
    assert!(before.iter().all(|byte| parser.push(*byte).is_none()));
    let frame = parser.push(*last).unwrap().unwrap();
    (frame.id, frame.code, frame.parameters.to_vec())
}

/// Destination, source and data of the one packet in these bytes.
pub(super) fn morpheus_frame(bytes: &[u8]) -> (u8, u8, Vec<u8>) {
    let mut parser = morpheus::frame::Parser::<130>::new();
    let (last, before) = bytes.split_last().unwrap();
    assert!(before.iter().all(|byte| parser.push(*byte).is_none()));
    let frame = parser.push(*last).unwrap().unwrap();
    (frame.destination, frame.source, frame.data.to_vec())
}

/// A Protocol 1.0 packet.
pub(super) fn stock(id: u8, code: u8, parameters: &[u8]) -> Vec<u8> {
    let frame = protocol1::Frame {
        id,
        code,
        parameters,
    };
    frame.encode::<259>().unwrap().to_vec()
}

/// A Morpheus packet, of any length.
pub(super) fn morpheus(destination: u8, source: u8, data: &[u8]) -> Vec<u8> {
    let length = data.len() as u8 + 2;
    let mut bytes = std::vec![0xAA, length, destination, source];
    bytes.extend_from_slice(data);
    bytes.push(morpheus::checksum(&bytes[1..]));
    bytes
}
