//! Fixture of a case: board, bench and host, and the injection of each kind of fault.

use std::ops::Range;

use armbridge_client::refusal_text;
use armbridge_shared::JOINTS;
use armbridge_shared::bridge::{BridgeEnd, LinkEnd, MemoryRegion, SERVO_IDS, gateway::PortEnd};
use armbridge_shared::link::message::Mode;

use super::case::{Case, Injection, Scenario};
use super::driver::{Driver, HostFault};
use super::expect::STOP_US;
use super::kind::Kind;
use super::watch::MonitoredBoard;
use crate::Bench;
use crate::board::VirtualBoard;
use crate::cosim::{Cosim, CosimError};
use crate::faults::host::{FaultyHost, LinkFault};
use crate::faults::sensor::SensorFault;
use crate::half_duplex_bus::{BusDirection, ByteFault};
use crate::morpheus_servo::Deafness;
use crate::plant::{Plant, Push};
use crate::servo_kind::{KindError, ServoKind};

/// Baud rate of the servo bus.
const BAUD: u32 = 1_000_000;
/// Heating of a stock servo in °C for one count of a Morpheus servo's converter: its limit
/// of 70 °C, 45 above the air, is reached in 0.5 to 1.5 s.
const CELSIUS_PER_COUNT: f64 = 0.1;

/// Ends of a board's channels.
pub(super) type Ends<'a> = (BridgeEnd<'a>, LinkEnd<'a>, PortEnd<'a>);

/// Share of damaged bytes to the servos above which a packet may not arrive: the stop
/// sequence has 270 bytes, some of them redundant. A late byte counts like a lost one,
/// because it collides with a reply.
const BLOCKING_SHARE: f64 = 0.01;

/// Board, bench and host of a case.
pub(super) struct Fixture<'a> {
    pub(super) cosim: Cosim<MonitoredBoard<'a>, FaultyHost<Driver>>,
    echoes: bool,
    is_swapped: bool,
    is_fault_free: bool,
    /// Times at which a servo could not be reached, in µs.
    blocked: Vec<(usize, Range<u64>)>,
    /// Times at which bytes to the servos were damaged, at any rate, in µs: a checksum of
    /// eight bits accepts one damaged packet in 256, and the stop sequence has packets
    /// without a checksum.
    corruption_us: Vec<Range<u64>>,
    /// End of each servo's operation that a damaged packet has started, during which the
    /// servo receives nothing, in µs.
    busy_us: [u64; JOINTS],
}

impl<'a> Fixture<'a> {
    pub(super) fn new(case: &Case, ends: Ends<'a>) -> Result<Self, String> {
        let limits = case.limits();
        let board = VirtualBoard::new(ends).map_err(refusal_text::in_words)?;
        let arms = case.scenario != Scenario::Idle;
        let driver = Driver::new(case.setup(), limits, arms, case.command());
        let kinds: Result<Vec<ServoKind>, KindError> = SERVO_IDS
            .iter()
            .map(|id| ServoKind::new(case.servos, id.get(), BAUD))
            .collect();
        let kinds = kinds.map_err(|error| error.to_string())?;
        let mut bench = Bench::with_servos(Plant::new(case.plant(), case.seed), &kinds);
        bench.echo(case.echoes());
        let board = MonitoredBoard::new(board, limits.pwm_counts);
        Ok(Self {
            cosim: Cosim::new(board, bench, FaultyHost::new(driver)),
            echoes: case.echoes(),
            is_swapped: false,
            is_fault_free: true,
            blocked: Vec::new(),
            corruption_us: Vec::new(),
            busy_us: [0; JOINTS],
        })
    }

    pub(super) fn now_us(&self) -> u64 {
        self.cosim.now_us()
    }

    pub(super) fn mode(&self) -> Mode {
        self.cosim.board.board.mode()
    }

    pub(super) fn driver(&mut self) -> &mut Driver {
        &mut self.cosim.host.host
    }

    pub(super) fn step_until(&mut self, latest_us: u64) {
        self.cosim
            .step_until(latest_us)
            .unwrap_or_else(|error| match error {
                CosimError::Board(never) | CosimError::Host(never) => match never {},
            });
        for servo in 0..JOINTS {
            if self.deafness(servo) == Some(Deafness::Busy) {
                self.busy_us[servo] = self.now_us();
            }
        }
    }

    fn deafness(&self, servo: usize) -> Option<Deafness> {
        let device = self.cosim.bench.servos().get(servo)?;
        device.morpheus()?.deafness()
    }

    /// Whether no fault has been injected yet.
    pub(super) fn is_fault_free(&self) -> bool {
        self.is_fault_free
    }

    /// Whether servos may receive packets that the board did not send.
    pub(super) fn is_corrupting(&self) -> bool {
        let now_us = self.now_us();
        let mut corruption_us = self.corruption_us.iter();
        // A servo may execute a packet a little later.
        corruption_us
            .any(|at_us| (at_us.start..at_us.end.saturating_add(STOP_US)).contains(&now_us))
    }

    /// Duration in µs for which this servo's motor was on without a break since then, when
    /// it was last on, not counting time in which it could not be reached.
    pub(super) fn overdue_us(&self, servo: usize, since_us: u64) -> u64 {
        let (on_ns, off_ns) = self.cosim.bench.last_on_ns(servo);
        let until_us = off_ns.map_or(self.now_us(), |ns| ns / 1_000);
        let mut from_us = since_us.max(on_ns / 1_000).max(self.busy_us[servo]);
        for (blocked, during_us) in &self.blocked {
            let counts = *blocked == servo && during_us.start < until_us;
            if counts && during_us.end > from_us {
                from_us = during_us.end;
            }
        }
        until_us.saturating_sub(from_us)
    }

    /// Starts an injection.
    pub(super) fn begin(&mut self, injection: &Injection) {
        self.is_fault_free = false;
        let now_us = self.now_us();
        let Injection {
            kind,
            lasts_us,
            servo,
            amount,
            seed,
            ..
        } = *injection;
        let during_us = now_us..now_us.saturating_add(lasts_us);
        if blocks(injection) {
            let servos = if kind == Kind::ServoDeaf {
                servo..servo + 1
            } else {
                0..JOINTS
            };
            self.blocked
                .extend(servos.map(|servo| (servo, during_us.clone())));
        }
        if let Kind::Bytes(BusDirection::ToServos, _) | Kind::LineLow | Kind::LineHigh = kind {
            self.corruption_us.push(during_us.clone());
        }
        let Cosim {
            board, bench, host, ..
        } = &mut self.cosim;
        let mut inject = |fault| host.inject(fault, during_us.clone(), seed);
        match kind {
            Kind::Bytes(direction, damage) => bench.inject(ByteFault {
                direction,
                damage: damage.damage(injection.late_us * 1_000),
                share: amount,
                from_ns: during_us.start * 1_000,
                until_ns: during_us.end.saturating_mul(1_000),
                seed,
            }),
            Kind::EchoOn | Kind::EchoOff => bench.echo(kind == Kind::EchoOn),
            Kind::LineLow => bench.hold_low(lasts_us),
            Kind::LineHigh => bench.hold_high(lasts_us),
            Kind::ServoReset => bench.power_cycle(servo),
            Kind::ServoMute => bench.mute(servo, true),
            Kind::ServoDeaf => bench.deafen(servo, true),
            Kind::ServosSwapped => {
                bench.swap_servos();
                self.is_swapped = true;
            }
            Kind::Frozen => bench.fail_sensor(servo, SensorFault::Frozen),
            Kind::DeadZone => bench.fail_sensor(servo, SensorFault::OffTrack { seed }),
            Kind::Hot => match bench.servo_mut(servo).stock_mut() {
                Some(stock) => stock.heat(amount * CELSIUS_PER_COUNT),
                None => bench.fail_sensor(
                    servo,
                    SensorFault::Hot {
                        counts_per_s: amount,
                    },
                ),
            },
            Kind::HostVanish => inject(LinkFault::Vanish),
            Kind::HostFlood => inject(LinkFault::Flood),
            Kind::HostGarbage => inject(LinkFault::Garbage),
            Kind::HostReplay if amount > 0.5 => inject(LinkFault::RepeatOnly),
            Kind::HostReplay => inject(LinkFault::Repeat),
            Kind::HostSchema => host.host.inject(HostFault::OtherSchema),
            Kind::HostRange => host.host.inject(HostFault::OutOfRange),
            Kind::Goodbye => host.host.inject(HostFault::Goodbye),
            Kind::ClockAhead => board.board.shift_clock((amount * 1e3) as i64),
            Kind::ClockBack => board.board.shift_clock(-(amount * 1e3) as i64),
            Kind::Push => bench.push(Push {
                joint: servo,
                torque_nm: amount,
                start_ns: now_us * 1_000,
                duration_ns: lasts_us * 1_000,
            }),
            Kind::Corrupt => board.board.inject_error(MemoryRegion::Config, seed as u32),
            Kind::StopHost => host.host.stop(),
            Kind::StopPin => self.cosim.is_stop_pressed = true,
        }
    }

    /// Ends an injection, if it does not end by itself.
    pub(super) fn end(&mut self, injection: &Injection) {
        let bench = &mut self.cosim.bench;
        match injection.kind {
            Kind::EchoOn | Kind::EchoOff => bench.echo(self.echoes),
            Kind::ServoMute => bench.mute(injection.servo, false),
            Kind::ServoDeaf => bench.deafen(injection.servo, false),
            _ => {}
        }
    }

    /// Removes all faults.
    pub(super) fn repair(&mut self) {
        let now_us = self.now_us();
        let blocked = self.blocked.iter_mut().map(|(_, during_us)| during_us);
        for during_us in blocked.chain(&mut self.corruption_us) {
            during_us.end = during_us.end.min(now_us);
        }
        for servo in 0..JOINTS {
            // After a packet of 128 bytes or more a servo receives nothing until it is
            // power-cycled.
            if self.deafness(servo) == Some(Deafness::MessageStuck) {
                self.cosim.bench.power_cycle(servo);
            }
        }
        let Cosim { bench, host, .. } = &mut self.cosim;
        for servo in 0..JOINTS {
            bench.repair_sensors(servo);
            if let Some(stock) = bench.servo_mut(servo).stock_mut() {
                stock.cool();
            }
            bench.mute(servo, false);
            bench.deafen(servo, false);
        }
        bench.clear_byte_faults();
        bench.echo(self.echoes);
        if std::mem::take(&mut self.is_swapped) {
            bench.swap_servos();
        }
        host.clear_faults();
        host.host.inject(HostFault::None);
        self.cosim.is_stop_pressed = false;
    }
}

/// Whether packets may not reach the servo during the injection.
pub(super) fn blocks(injection: &Injection) -> bool {
    match injection.kind {
        Kind::LineLow | Kind::LineHigh | Kind::ServoDeaf => true,
        Kind::Bytes(BusDirection::ToServos, _) => injection.amount > BLOCKING_SHARE,
        _ => false,
    }
}
