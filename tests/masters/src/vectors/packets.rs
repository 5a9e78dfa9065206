//! The masters at pseudo-terminals without servos: the packets that they send.

use std::io::Read;
use std::time::Duration;

use dynamixel2::instructions::{BulkReadData, BulkWriteData, FactoryResetKind, SyncWriteData};
use rustypot::DynamixelProtocolHandler;
use serialport::{SerialPort, TTYPort};

use super::instruction::Instruction as I;
use crate::check::{BAUD, Result};

const HEADER: [u8; 4] = [0xFF, 0xFF, 0xFD, 0];
/// Time to wait for the answer that does not come.
const SILENCE: Duration = Duration::from_millis(5);

/// The next packet, by its length.
fn packet(port: &mut impl Read) -> Result<Vec<u8>> {
    let mut head = [0; 7];
    port.read_exact(&mut head)?;
    if !head.starts_with(&HEADER) {
        return Err(format!("{head:02X?} is no beginning of a packet").into());
    }
    let mut rest = vec![0; u16::from_le_bytes([head[5], head[6]]).into()];
    port.read_exact(&mut rest)?;
    Ok([&head[..], &rest].concat())
}

pub(super) struct Rustypot {
    protocol: DynamixelProtocolHandler,
    port: TTYPort,
    other_end: TTYPort,
}

impl Rustypot {
    pub(super) fn new() -> Result<Self> {
        let (other_end, mut port) = TTYPort::pair()?;
        port.set_timeout(SILENCE)?;
        Ok(Self {
            protocol: DynamixelProtocolHandler::v2(),
            port,
            other_end,
        })
    }

    /// Its packet, if it has the instruction.
    pub(super) fn packet(&mut self, instruction: &I) -> Result<Option<Vec<u8>>> {
        let (protocol, port) = (&self.protocol, &mut self.port);
        // No servo answers: the results are errors, or say so.
        match instruction {
            I::Ping(id) => drop(protocol.ping(port, *id)),
            I::Reboot(id) => drop(protocol.reboot(port, *id)),
            I::FactoryReset(id) => drop(protocol.factory_reset(port, *id, true, false)),
            I::Read(id, address, count) => drop(protocol.read(port, *id, *address, *count)),
            I::Write(id, address, data) => drop(protocol.write(port, *id, *address, data)),
            I::SyncRead(address, count, ids) => {
                drop(protocol.sync_read(port, ids, *address, *count));
            }
            I::FastSyncRead(address, count, ids) => {
                drop(protocol.fast_sync_read(port, ids, *address, *count));
            }
            I::SyncWrite(address, blocks) => {
                let (ids, data): (Vec<u8>, Vec<Vec<u8>>) = blocks.iter().cloned().unzip();
                protocol.sync_write(port, &ids, *address, &data)?;
            }
            I::Action(_)
            | I::ClearTurns(_)
            | I::RegWrite(..)
            | I::BulkRead(..)
            | I::BulkWrite(_) => return Ok(None),
        }
        packet(&mut self.other_end).map(Some)
    }
}

pub(super) struct Dynamixel2 {
    bus: dynamixel2::Bus<Vec<u8>, Vec<u8>>,
    other_end: TTYPort,
}

impl Dynamixel2 {
    pub(super) fn new() -> Result<Self> {
        let (other_end, port) = TTYPort::pair()?;
        let name = port.name().ok_or("a terminal without a name")?;
        let bus = dynamixel2::Bus::open(name, BAUD)?;
        Ok(Self { bus, other_end })
    }

    /// Its packet, if it has the instruction.
    pub(super) fn packet(&mut self, instruction: &I) -> Result<Option<Vec<u8>>> {
        let bus = &mut self.bus;
        // No servo answers: where there should be a reply, the results are errors.
        match instruction {
            I::Ping(id) => drop(bus.ping(*id)),
            I::Reboot(id) => drop(bus.reboot(*id)),
            I::Action(id) => drop(bus.action(*id)),
            I::ClearTurns(id) => drop(bus.clear_revolution_counter(*id)),
            I::FactoryReset(id) => drop(bus.factory_reset(*id, FactoryResetKind::KeepId)),
            I::Read(id, address, count) => {
                drop(bus.read(*id, u16::from(*address), u16::from(*count)));
            }
            I::Write(id, address, data) => drop(bus.write(*id, u16::from(*address), data)),
            I::RegWrite(id, address, data) => {
                drop(bus.reg_write(*id, u16::from(*address), data));
            }
            I::SyncRead(address, count, ids) => {
                drop(bus.sync_read(ids, u16::from(*address), u16::from(*count)));
            }
            I::SyncWrite(address, blocks) => {
                let count = blocks.first().map_or(0, |(_, data)| data.len());
                let blocks = blocks.iter().cloned();
                let blocks = blocks.map(|(motor_id, data)| SyncWriteData { motor_id, data });
                let blocks: Vec<_> = blocks.collect();
                bus.sync_write(u16::from(*address), u16::try_from(count)?, &blocks)?;
            }
            I::BulkRead(id, address, count) => {
                let read = BulkReadData {
                    motor_id: *id,
                    address: u16::from(*address),
                    count: u16::from(*count),
                };
                drop(bus.bulk_read(&[&read]));
            }
            I::BulkWrite(blocks) => {
                let blocks = blocks.iter().cloned();
                let blocks = blocks.map(|(motor_id, address, data)| BulkWriteData {
                    motor_id,
                    address: u16::from(address),
                    data,
                });
                bus.bulk_write(&blocks.collect::<Vec<_>>())?;
            }
            I::FastSyncRead(..) => return Ok(None),
        }
        packet(&mut self.other_end).map(Some)
    }
}
