//! Fixture of a case: board, bench, host and client.

use armbridge_board::bridge::transparent_port::PortEnd;
use armbridge_board::bridge::{BridgeEnd, LinkEnd, SERVO_IDS};
use armbridge_board::store::Store;
use armbridge_client::refusal_text;
use armbridge_control::arm::State;
use armbridge_link::message::{Mode, Settings};
use armbridge_servo::JOINTS;

use super::activity::Activity;
use super::case::Case;
use super::client::Client;
use super::driver::Driver;
use super::expect::STOP_US;
use super::kind::Kind;
use super::lead::{LED_US, lead};
use super::reach::Reach;
use super::second_master::SecondMaster;
use super::watch::MonitoredBoard;
use crate::Bench;
use crate::board::{Flash, VirtualBoard, blank_flash};
use crate::cosim::{Cosim, CosimError};
use crate::faults::host::FaultyHost;
use crate::faults::port_client::ClientHandle;
use crate::morpheus_servo::Deafness;
use crate::plant::{Impact, Plant};
use crate::servo_kind::{KindError, ServoKind};

/// Time in µs at which the client of an activity opens its port: bring-up is over.
const CLIENT_US: u64 = 40_000;
/// Index of a servo beside the arm's.
pub(super) const THIRD: usize = JOINTS;

/// Ends of a board's channels.
pub(super) type Ends<'a> = (BridgeEnd<'a>, LinkEnd<'a>, PortEnd<'a>);

/// Board, bench, host and client of a case.
pub(super) struct Fixture<'a> {
    pub(super) cosim: Cosim<MonitoredBoard<'a>, FaultyHost<Driver>, ClientHandle>,
    pub(super) client: Client,
    pub(super) second_master: Option<SecondMaster>,
    pub(super) reach: Reach,
    /// The arm's servos.
    pub(super) kinds: Vec<ServoKind>,
    pub(super) case: Case,
    pub(super) is_swapped: bool,
    pub(super) is_fault_free: bool,
    /// Time in µs from which on a hand leads the arm.
    pub(super) led_us: Option<u64>,
    /// Time of a stop that waits for the client, in µs.
    pub(super) stop_us: Option<u64>,
}

impl<'a> Fixture<'a> {
    /// The fixture, with the channels of the board and of that after a restart.
    pub(super) fn new(case: &Case, [ends, spare]: [Ends<'a>; 2]) -> Result<Self, String> {
        let limits = case.limits();
        let board = VirtualBoard::with_flash(ends, flash(case)?).map_err(refusal_text::in_words)?;
        let bus = case.bus;
        let third = case.find(Kind::DuplicateId).map(|it| SERVO_IDS[it.servo]);
        let kinds: Result<Vec<ServoKind>, KindError> = SERVO_IDS
            .into_iter()
            .chain(third)
            .map(|id| ServoKind::new(bus.servos, id.get(), bus.baud))
            .collect();
        let kinds = kinds.map_err(|error| error.to_string())?;
        let mut bench = Bench::with_servos(Plant::new(case.plant(), case.seed), &kinds);
        bench.echo(case.echoes());
        if third.is_some() {
            bench.disconnect(THIRD);
        }
        let mut client = Client::new(bus.servos, bus.baud);
        if case.activity == Activity::Port {
            client.drive(CLIENT_US);
        }
        let board = MonitoredBoard::new(board, spare, limits.pwm_counts);
        let cosim = Cosim::new(board, bench, FaultyHost::new(Driver::new(case)));
        Ok(Self {
            cosim: cosim.with_client(client.port.clone()),
            client,
            second_master: None,
            reach: Reach::default(),
            kinds,
            case: case.clone(),
            is_swapped: false,
            is_fault_free: true,
            led_us: None,
            stop_us: None,
        })
    }

    pub(super) fn now_us(&self) -> u64 {
        self.cosim.now_us()
    }

    pub(super) fn mode(&self) -> Mode {
        self.cosim.board.mode()
    }

    pub(super) fn driver(&mut self) -> &mut Driver {
        &mut self.cosim.host.host
    }

    /// Whether the activity runs.
    pub(super) fn is_working(&mut self) -> bool {
        let is_driven_by_client = self.mode() == Mode::Passthrough && self.is_on(0);
        match self.case.activity {
            Activity::Port => is_driven_by_client,
            _ => self.driver().is_working(),
        }
    }

    /// Advances to the next event, at most to `latest_us`.
    pub(super) fn step_until(&mut self, latest_us: u64) {
        let second_us = self
            .second_master
            .as_ref()
            .map_or(u64::MAX, SecondMaster::next_us);
        let own_us = second_us.min(self.stop_us.unwrap_or(u64::MAX));
        self.cosim
            .step_until(latest_us.min(own_us))
            .unwrap_or_else(|error| match error {
                CosimError::Board(never) | CosimError::Host(never) => match never {},
            });
        let now_us = self.now_us();
        if self.stop_us.is_some_and(|at_us| at_us <= now_us) {
            self.stop_us = None;
            self.stop_client();
        }
        if let Some(packet) = self.second_master.as_mut().and_then(|it| it.take(now_us)) {
            self.cosim
                .bench
                .send_foreign(now_us, &packet, self.case.bus.baud);
        }
        for servo in 0..JOINTS {
            if self.deafness(servo) == Some(Deafness::Busy) {
                self.reach.busy(servo, now_us);
            }
        }
    }

    /// Has a hand lead the arm, from a time on.
    pub(super) fn lead(&mut self) {
        let now_us = self.now_us();
        self.led_us = Some(now_us + LED_US);
        self.cosim.bench.lead(&lead(&self.case, now_us));
    }

    /// Whether nothing has touched the arm yet, and nothing is wrong.
    pub(super) fn is_undisturbed(&self) -> bool {
        self.is_fault_free && self.led_us.is_none_or(|led_us| self.now_us() < led_us)
    }

    /// Stops the client, by the switch or by the host.
    fn stop_client(&mut self) {
        let is_by_host = self
            .case
            .find(Kind::ClientStop)
            .is_some_and(|it| it.amount > 0.5);
        if is_by_host {
            self.driver().stop();
        } else {
            self.cosim.is_stop_pressed = true;
        }
    }

    pub(super) fn deafness(&self, servo: usize) -> Option<Deafness> {
        let device = self.cosim.bench.servos().get(servo)?;
        device.morpheus()?.deafness()
    }

    /// Whether the motor of a servo is on.
    pub(super) fn is_on(&self, servo: usize) -> bool {
        self.on_since_us(servo).is_some()
    }

    /// Time in µs since when the motor of a servo is on, if it is.
    pub(super) fn on_since_us(&self, servo: usize) -> Option<u64> {
        let (on_ns, off_ns) = self.cosim.bench.last_on_ns(servo);
        off_ns.is_none().then_some(on_ns / 1_000)
    }

    /// Whether a motor may be on: the board drives it, or a client that has the bus and is
    /// not silent.
    pub(super) fn is_permitted(&self) -> bool {
        let silence_ms = self.case.limits().client_silence_ms;
        match self.mode() {
            // Nothing can be said to a servo while there is no board.
            _ if self.cosim.board.is_down() => true,
            Mode::Passthrough => {
                let silent_us = self.now_us().saturating_sub(self.client.port.written_us());
                silence_ms == 0 || silent_us <= u64::from(silence_ms) * 1_000
            }
            mode => mode.is_on(),
        }
    }

    /// Whether servos may receive packets that the board did not send.
    pub(super) fn is_foreign(&self) -> bool {
        // A servo may execute a packet a little later.
        self.reach.is_foreign(self.now_us(), STOP_US)
    }

    /// Duration in µs for which this servo's motor was on without a break since then, when
    /// it was last on, not counting time in which it could not be reached.
    pub(super) fn overdue_us(&self, servo: usize, since_us: u64) -> u64 {
        let (on_ns, off_ns) = self.cosim.bench.last_on_ns(servo);
        let until_us = off_ns.map_or(self.now_us(), |ns| ns / 1_000);
        let from_us = since_us.max(on_ns / 1_000);
        until_us.saturating_sub(self.reach.reachable_from(servo, from_us, until_us))
    }

    /// Whether the board restarts.
    pub(super) fn is_down(&self) -> bool {
        self.cosim.board.is_down()
    }

    /// The true state of the arm.
    pub(super) fn state(&mut self) -> State<f64> {
        let now_us = self.now_us();
        self.cosim.bench.state_at(now_us)
    }

    /// The arm's fastest impact on a stop since the last call.
    pub(super) fn take_impact(&mut self) -> Option<Impact> {
        self.cosim.bench.take_impact()
    }
}

/// Flash with the settings of a case that relies on them, one bit of which has flipped.
fn flash(case: &Case) -> Result<Flash, String> {
    let Some(rot) = case.find(Kind::FlashRot) else {
        return Ok(blank_flash());
    };
    let settings = Settings {
        setup: case.right_setup(),
        limits: case.limits(),
    };
    let mut store = Store::new(blank_flash());
    store
        .save(&settings)
        .map_err(|error| format!("settings cannot be saved: {error:?}"))?;
    let mut flash = store.flash().clone();
    let written: Vec<&mut u8> = flash.0.iter_mut().filter(|byte| **byte != 0xFF).collect();
    let (bit, index) = (rot.seed % 8, rot.seed / 8 % written.len().max(1) as u64);
    if let Some(byte) = written.into_iter().nth(index as usize) {
        *byte ^= 1 << bit;
    }
    Ok(flash)
}
