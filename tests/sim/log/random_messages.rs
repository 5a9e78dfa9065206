//! A link with every message there is, with random numbers in it.

use armbridge_client::Tap;
use armbridge_client::enum_names::{MISSING, MODES};
use armbridge_client::event::{Direction, Event, LinkDecoder};
use armbridge_control::trajectory::Quantity;
use armbridge_link::frame::Encoder;
use armbridge_link::message::{TickInput, TickOutput, *};
use armbridge_link::motion::{Motion, Via};
use armbridge_link::schema;
use armbridge_servo::Firmware;

/// A cheap repeatable randomness, fond of numbers that are hard to write down.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        self.0 >> 16
    }

    fn real(&mut self) -> f32 {
        const HARD: [f32; 8] = [
            0.0,
            -0.0,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MIN_POSITIVE,
            1e-45,
            f32::MAX,
        ];
        let bits = self.bits() as u32;
        match bits % 16 {
            pick @ 0..8 => HARD[pick as usize],
            // Any bits, other NaNs among them.
            8 => f32::from_bits(self.bits() as u32),
            _ => (f64::from(self.bits() as u32) / 4.3e9 - 0.5) as f32,
        }
    }

    fn reals<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| self.real())
    }

    fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.bits() as usize % values.len()]
    }

    fn sample(&mut self) -> Sample {
        match self.bits() % 3 {
            0 => Sample::Missing(self.one_of(&MISSING)),
            _ => Sample::Counts((self.bits() % 1024) as u16),
        }
    }

    fn mode(&mut self) -> Mode {
        match self.bits() % 2 {
            0 => Mode::Fault(self.one_of(&Fault::ALL)),
            _ => self.one_of(&MODES),
        }
    }

    pub(crate) fn record(&mut self, tick: u32) -> Record {
        Record {
            tick,
            mode: self.mode(),
            timing: Timing {
                start_error_us: self.bits() as u32,
                bus_us: self.bits() as u32,
                compute_ns: 0,
                missed: self.bits() as u32,
            },
            dropped: self.bits() as u32,
            input: TickInput {
                start_us: u64::from(tick) * 1_000 + self.bits() % 50,
                samples: [self.sample(), self.sample()],
                alarms: [self.bits() as u8, self.bits() as u8],
                pwm_in_force: [self.bits() as u16, self.bits() as u16],
                ..TickInput::AT_REST
            },
            output: TickOutput {
                guards: Guards::from_bits(self.bits() as u8),
                pwm: [self.bits() as u16, 0],
                reference_rad: self.reals(),
                reference_speed_rad_s: self.reals(),
                angle_rad: self.reals(),
                speed_rad_s: self.reals(),
                torque_nm: self.reals(),
                disturbance_nm: self.reals(),
                ..TickOutput::NONE
            },
        }
    }

    pub(crate) fn settings(&mut self) -> Settings {
        let mut settings = Settings::default();
        settings.setup.controller =
            Controller::StateFeedback(Gains::Given([self.reals(), self.reals()]));
        settings.setup.friction_nm = self.reals();
        settings.setup.friction_load_percent = [self.bits() as u8, self.bits() as u8];
        settings.setup.arm.l1 = self.real();
        settings.limits.angle_rad = self.reals();
        settings
    }

    fn moment(&mut self) -> Option<Moment> {
        self.bits().is_multiple_of(2).then(|| Moment {
            tick: self.bits() as u32,
            is_decided: self.bits().is_multiple_of(2),
            at_us: self.bits() << 10,
            mode: self.mode(),
        })
    }

    fn commands(&mut self) -> Vec<Command> {
        let via = Via {
            at_s: self.real(),
            angle_rad: self.reals(),
        };
        let mut vias = [None; _];
        vias[0] = Some(via);
        let motions = [
            Motion::MinimumJerk {
                to_rad: self.reals(),
                duration_s: Some(self.real()),
            },
            Motion::Waypoints(vias),
            Motion::Sinusoid {
                centre_rad: self.reals(),
                amplitude_rad: self.reals(),
                frequency_hz: self.reals(),
                phase_rad: self.reals(),
                ramp_s: self.real(),
                duration_s: self.real(),
            },
            Motion::Chirp {
                centre_rad: self.reals(),
                amplitude_rad: self.reals(),
                from_hz: self.reals(),
                to_hz: self.reals(),
                ramp_s: self.real(),
                duration_s: self.real(),
            },
        ];
        let settings = self.settings();
        let mut all = vec![
            Command::Idle,
            Command::Arm {
                session: self.bits() as u32,
            },
            Command::Torque(self.reals()),
            Command::Regulate(self.reals()),
            Command::Stream {
                at_us: self.bits(),
                angle_rad: self.reals(),
                speed_rad_s: Some(self.reals()),
            },
            Command::Stream {
                at_us: u64::MAX,
                angle_rad: self.reals(),
                speed_rad_s: None,
            },
            Command::Float,
            Command::Park,
            Command::Prepare,
            Command::Release,
            Command::ClearFault,
            Command::Configure(settings.setup),
            Command::Limit(settings.limits),
            Command::Save,
        ];
        all.extend(motions.map(Command::Follow));
        all
    }

    /// Every message of a host.
    pub(crate) fn host_messages(&mut self) -> Vec<ToBoard> {
        let mut all = vec![
            ToBoard::Hello(schema::HELLO),
            ToBoard::Heartbeat,
            ToBoard::Stop,
            ToBoard::Goodbye,
        ];
        all.extend(self.commands().into_iter().map(ToBoard::Command));
        all
    }

    /// Every message of a board but records.
    pub(crate) fn board_messages(&mut self) -> Vec<ToHost> {
        let moment = Moment {
            tick: self.bits() as u32,
            is_decided: false,
            at_us: self.bits(),
            mode: self.mode(),
        };
        let mut all = vec![
            ToHost::Hello(schema::HELLO),
            ToHost::Departs {
                sequence: self.bits() as u16,
                moment,
            },
            ToHost::Began(moment),
            ToHost::Settings(self.settings()),
            ToHost::Absent {
                joint: 1,
                missing: self.one_of(&MISSING),
            },
            ToHost::Found {
                firmware: Firmware::Morpheus,
                baud: self.bits() as u32,
                is_ready: true,
            },
            ToHost::Mixed([Firmware::Morpheus, Firmware::Stock]),
            ToHost::Unprepared { joint: 0 },
            ToHost::Passthrough,
            ToHost::Port(PortCounters {
                passed: self.bits() as u32,
                ..PortCounters::default()
            }),
            ToHost::Board(BoardReport {
                session: self.bits() as u32,
                image: Some(self.bits() as u32),
                ..BoardReport::default()
            }),
            ToHost::Tripped(Trip {
                fault: self.one_of(&Fault::ALL),
                joint: Some(1),
                tick: self.bits() as u32,
                at_us: self.bits(),
                value: self.real(),
                limit: self.real(),
            }),
            ToHost::Off(OffReport {
                stops: self.bits() as u16,
                joints: [OffState::OutOfReach, OffState::Off],
            }),
            ToHost::Temperature {
                joint: 0,
                value: self.bits() as u16,
            },
        ];
        let beyond = Refusal::Beyond {
            joint: 1,
            quantity: Quantity::Speed,
            value: self.real(),
            limit: self.real(),
        };
        let unstable = Refusal::Unstable {
            re: self.real(),
            im: self.real(),
        };
        for result in [Ok(()), Err(Refusal::Busy), Err(beyond), Err(unstable)] {
            let (sequence, moment) = (self.bits() as u16, self.moment());
            all.push(ToHost::Ack {
                sequence,
                result,
                moment,
            });
        }
        all
    }
}

/// Between two frames.
const STEP_NS: u64 = 123_457;

/// Both ends of a link, with a tap.
pub(crate) struct Talk<'a> {
    host: Encoder,
    board: Encoder,
    now_ns: u64,
    ear: LinkDecoder,
    /// All events of the link.
    pub(crate) events: Vec<Event>,
    tap: &'a mut dyn Tap,
}

impl<'a> Talk<'a> {
    pub(crate) fn new(tap: &'a mut dyn Tap) -> Self {
        Self {
            host: Encoder::default(),
            board: Encoder::default(),
            now_ns: 1_795_000_000_000_000_000,
            ear: LinkDecoder::default(),
            events: Vec::new(),
            tap,
        }
    }

    pub(crate) fn ask(&mut self, message: &ToBoard) {
        let frame = self.host.encode(message).1.to_vec();
        self.travel(Direction::ToBoard, &frame);
    }

    pub(crate) fn tell(&mut self, message: &ToHost) {
        let frame = self.board.encode(message).1.to_vec();
        self.travel(Direction::ToHost, &frame);
    }

    /// A frame of the board goes missing.
    pub(crate) fn miss(&mut self) {
        let _ = self.board.encode(&ToHost::Passthrough);
    }

    pub(crate) fn travel(&mut self, direction: Direction, bytes: &[u8]) {
        self.now_ns += STEP_NS;
        let events = &mut self.events;
        self.ear
            .take(direction, self.now_ns, bytes, |event| events.push(event));
        self.tap.bytes(direction, self.now_ns, bytes);
    }

    pub(crate) fn part(&mut self) {
        self.now_ns += 1;
        self.ear = LinkDecoder::default();
        self.events.push(Event {
            host_ns: self.now_ns,
            kind: armbridge_client::event::EventKind::Disconnected,
        });
        self.tap.disconnected(self.now_ns);
    }
}
