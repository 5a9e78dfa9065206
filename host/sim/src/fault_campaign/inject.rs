//! Injection of each kind of fault into a fixture, its end, and the repair of all.

use armbridge_board::bridge::MemoryRegion;
use armbridge_servo::JOINTS;

use super::driver::HostFault;
use super::fixture::{Fixture, THIRD};
use super::injection::Injection;
use super::kind::Kind;
use super::second_master::SecondMaster;
use crate::cosim::Cosim;
use crate::faults::host::LinkFault;
use crate::faults::sensor::SensorFault;
use crate::half_duplex_bus::{BusDirection, ByteFault, Device};
use crate::morpheus_servo::Deafness;
use crate::plant::{MotorFault, Push};

/// Heating of a stock servo in °C for one count of a Morpheus servo's converter: its limit
/// of 70 °C, 45 above the air, is reached in 0.5 to 1.5 s.
const CELSIUS_PER_COUNT: f64 = 0.1;

/// Draws among which each bit of what drives comes.
const DRIVE_BITS: u64 = 384;

impl Fixture<'_> {
    /// Starts an injection.
    pub(super) fn begin(&mut self, injection: &Injection) {
        self.is_fault_free = false;
        let now_us = self.now_us();
        self.reach.begin(injection, now_us);
        match injection.kind {
            Kind::ClientHang => self.client.hang(now_us),
            Kind::ClientBaud => self.client.change_rate(now_us),
            Kind::ClientStop => self.stop_us = Some(self.client.hang_inside_a_packet(now_us)),
            Kind::BrownOut => {
                if injection.amount > 0.5 {
                    self.power_cycle();
                }
                let until_us = now_us + injection.lasts_us;
                self.cosim.board.brown_out(until_us);
            }
            Kind::SecondMaster => {
                let during_us = now_us..now_us.saturating_add(injection.lasts_us);
                let (servos, seed) = (self.case.servos(), injection.seed);
                let master = SecondMaster::new(servos, injection.amount, &during_us, seed);
                self.second_master = Some(master);
            }
            Kind::ServosSwapped | Kind::SwappedFirst => {
                self.cosim.bench.swap_servos();
                self.is_swapped = !self.is_swapped;
            }
            Kind::ServosReset => self.power_cycle(),
            kind if is_of_host(kind) => self.begin_at_host(injection, now_us),
            _ => self.begin_at_bench(injection, now_us),
        }
    }

    fn power_cycle(&mut self) {
        for servo in 0..JOINTS {
            self.cosim.bench.power_cycle(servo);
        }
    }

    fn begin_at_host(&mut self, injection: &Injection, now_us: u64) {
        let Injection { amount, seed, .. } = *injection;
        let during_us = now_us..now_us.saturating_add(injection.lasts_us);
        let host = &mut self.cosim.host;
        let link_fault = match injection.kind {
            Kind::HostVanish => LinkFault::Vanish,
            Kind::HostStall => LinkFault::Stall,
            Kind::HostFlood => LinkFault::Flood,
            Kind::HostGarbage => LinkFault::Garbage,
            Kind::HostReplay if amount > 0.5 => LinkFault::RepeatOnly,
            Kind::HostReplay => LinkFault::Repeat,
            Kind::HostSchema => return host.host.inject(HostFault::OtherSchema),
            Kind::HostRange => return host.host.inject(HostFault::OutOfRange),
            Kind::HostHeartbeats => return host.host.inject(HostFault::Heartbeats),
            Kind::HostHello => return host.host.burst(amount as usize),
            Kind::Goodbye => return host.host.inject(HostFault::Goodbye),
            _ => return host.host.stop(),
        };
        host.inject(link_fault, during_us, seed);
    }

    fn begin_at_bench(&mut self, injection: &Injection, now_us: u64) {
        let Injection {
            kind,
            lasts_us,
            servo,
            amount,
            late_us,
            seed,
            ..
        } = *injection;
        let Cosim { board, bench, .. } = &mut self.cosim;
        let board = &mut board.board;
        let motor = |gain, offset_counts| MotorFault {
            gain,
            offset_counts,
        };
        match kind {
            Kind::Bytes(direction, damage) => bench.inject(ByteFault {
                direction,
                damage: damage.damage(late_us * 1_000),
                share: amount,
                from_ns: now_us * 1_000,
                until_ns: now_us.saturating_add(lasts_us).saturating_mul(1_000),
                seed,
            }),
            Kind::EchoOn | Kind::EchoOff => bench.echo(kind == Kind::EchoOn),
            Kind::LineLow => bench.hold_low(lasts_us),
            Kind::LineHigh => bench.hold_high(lasts_us),
            Kind::DuplicateId => bench.reconnect(THIRD),
            Kind::ServoReset => bench.power_cycle(servo),
            Kind::ServoMute => bench.mute(servo, true),
            Kind::ServoDeaf => bench.deafen(servo, true),
            Kind::Frozen => bench.fail_sensor(servo, SensorFault::Frozen),
            Kind::DeadZone => bench.fail_sensor(servo, SensorFault::OffTrack { seed }),
            Kind::EncoderStep | Kind::EncoderDrift => {
                let (counts, counts_per_s) = match kind {
                    Kind::EncoderStep => (amount, 0.0),
                    _ => (0.0, amount),
                };
                let fault = SensorFault::Offset {
                    counts,
                    counts_per_s,
                };
                bench.fail_sensor(servo, fault);
            }
            Kind::EncoderNoise => {
                let fault = SensorFault::Noise {
                    counts_rms: amount,
                    seed,
                };
                bench.fail_sensor(servo, fault);
            }
            Kind::Hot => match bench.servo_mut(servo) {
                Device::Stock(stock) => stock.heat(amount * CELSIUS_PER_COUNT),
                Device::X(x_servo) => x_servo.heat(amount * CELSIUS_PER_COUNT),
                Device::Morpheus(_) => bench.fail_sensor(
                    servo,
                    SensorFault::Hot {
                        counts_per_s: amount,
                    },
                ),
            },
            Kind::TorqueGain | Kind::TorqueSign => bench.fail_motor(servo, motor(amount, 0.0)),
            Kind::TorqueOffset => bench.fail_motor(servo, motor(1.0, amount)),
            Kind::ClockAhead => board.shift_clock((amount * 1e3) as i64),
            // No clock shows a time before its start.
            Kind::ClockBack => {
                board.shift_clock(-((amount * 1e3) as i64).min(board.clock_us(now_us) as i64));
            }
            Kind::Push => bench.push(Push {
                joint: servo,
                torque_nm: amount,
                start_ns: now_us * 1_000,
                duration_ns: lasts_us * 1_000,
            }),
            Kind::Corrupt => board.inject_error(MemoryRegion::Config, seed as u32),
            Kind::CorruptState => board.inject_error(MemoryRegion::State, seed as u32),
            Kind::CorruptDrive => {
                // As often a torque as the drive and its time.
                board.inject_error(MemoryRegion::Drive, (seed % DRIVE_BITS) as u32);
            }
            Kind::CorruptReference => board.inject_error(MemoryRegion::Reference, seed as u32),
            Kind::StopPin => self.cosim.is_stop_pressed = true,
            // Part of the case from the beginning.
            _ => {}
        }
    }

    /// Ends an injection, if it does not end by itself.
    pub(super) fn end(&mut self, injection: &Injection) {
        let echoes = self.case.echoes();
        let bench = &mut self.cosim.bench;
        match injection.kind {
            Kind::EchoOn | Kind::EchoOff => bench.echo(echoes),
            Kind::ServoMute => bench.mute(injection.servo, false),
            Kind::ServoDeaf => bench.deafen(injection.servo, false),
            _ => {}
        }
    }

    /// Removes all faults.
    pub(super) fn repair(&mut self) {
        let now_us = self.now_us();
        self.reach.repair(now_us);
        self.client.port.close();
        self.second_master = None;
        self.stop_us = None;
        for servo in 0..JOINTS {
            // After a packet of 128 bytes or more a servo receives nothing until it is
            // power-cycled.
            if self.deafness(servo) == Some(Deafness::MessageStuck) {
                self.cosim.bench.power_cycle(servo);
            }
        }
        let echoes = self.case.echoes();
        let Cosim { bench, host, .. } = &mut self.cosim;
        for servo in 0..JOINTS {
            bench.repair_sensors(servo);
            bench.fail_motor(servo, MotorFault::NONE);
            match bench.servo_mut(servo) {
                Device::Morpheus(_) => {}
                Device::Stock(stock) => stock.cool(),
                Device::X(x_servo) => x_servo.cool(),
            }
            bench.mute(servo, false);
            bench.deafen(servo, false);
        }
        if self.kinds.len() > THIRD {
            bench.disconnect(THIRD);
        }
        bench.clear_byte_faults();
        bench.echo(echoes);
        if std::mem::take(&mut self.is_swapped) {
            bench.swap_servos();
        }
        host.clear_faults();
        host.host.inject(HostFault::None);
        self.cosim.is_stop_pressed = false;
    }

    /// Replaces servos that packets of others than the board may have changed, and those whose
    /// id or rate a damaged packet has changed: one in 256 passes the checksum.
    pub(super) fn replace_servos(&mut self) {
        let has = |is_of: fn(Kind) -> bool| self.case.injections.iter().any(|it| is_of(it.kind));
        let has_master = has(|kind| kind.has_client() || kind == Kind::SecondMaster);
        let has_damage = has(|kind| matches!(kind, Kind::Bytes(BusDirection::ToServos, _)));
        let model = self.case.plant().x_servo;
        for (servo, kind) in self.kinds.iter().enumerate().take(JOINTS) {
            let address = |device: &Device| (device.id(), device.bit_ns());
            let now = self.cosim.bench.servos().get(servo).map(address);
            let is_changed = now != Some(address(&kind.build(model)));
            if has_master || (has_damage && is_changed) {
                self.cosim.bench.replace(servo, *kind);
            }
        }
    }
}

/// Whether the host has this fault.
fn is_of_host(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::HostVanish
            | Kind::HostStall
            | Kind::HostFlood
            | Kind::HostGarbage
            | Kind::HostReplay
            | Kind::HostSchema
            | Kind::HostRange
            | Kind::HostHeartbeats
            | Kind::HostHello
            | Kind::Goodbye
            | Kind::StopHost
    )
}
