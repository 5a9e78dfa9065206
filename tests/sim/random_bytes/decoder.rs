//! The frame decoder, both directions.

use std::fmt::Debug;

use armbridge_link::frame::{Decoder, Encoder, FrameError, MAX, Message};
use armbridge_link::message::{
    Command, Drive, Guards, Mode, Record, Sample, TickInput, TickOutput, Timing, ToBoard, ToHost,
};
use armbridge_link::schema;
use armbridge_tests::random::Random;
use armbridge_tests::streams::checks::frames::frame;

const STREAMS: usize = 500_000;
const VERSION: u8 = 1;

fn to_board(random: &mut Random) -> ToBoard {
    let mut real = || f32::from_bits(random.below(1 << 32) as u32);
    let values = [real(), real()];
    match random.below(5) {
        0 => ToBoard::Hello(schema::HELLO),
        1 => ToBoard::Heartbeat,
        2 => ToBoard::Command(Command::Torque(values)),
        3 => ToBoard::Command(Command::Regulate(values)),
        _ => ToBoard::Command(Command::ClearFault),
    }
}

fn to_host(random: &mut Random) -> ToHost {
    match random.below(3) {
        0 => ToHost::Hello(schema::HELLO),
        1 => ToHost::Ack {
            sequence: random.below(0x1_0000) as u16,
            result: Ok(()),
            moment: None,
        },
        _ => ToHost::Record(record(random)),
    }
}

fn pair(random: &mut Random) -> [f32; 2] {
    [0; 2].map(|_| f32::from_bits(random.below(1 << 32) as u32))
}

fn record(random: &mut Random) -> Record {
    Record {
        tick: random.below(1 << 32) as u32,
        mode: Mode::Running(Drive::Regulate),
        timing: Timing::default(),
        dropped: 0,
        input: TickInput {
            start_us: random.below(u64::MAX),
            samples: [0; 2].map(|_| Sample::Counts(random.below(1024) as u16)),
            alarms: [0; 2].map(|_| random.below(128) as u8),
            pwm_in_force: [1000; 2],
            ..TickInput::AT_REST
        },
        output: TickOutput {
            reference_rad: pair(random),
            angle_rad: pair(random),
            reference_speed_rad_s: pair(random),
            speed_rad_s: pair(random),
            torque_nm: pair(random),
            disturbance_nm: pair(random),
            guards: Guards::NONE,
            pwm: [0; 2].map(|_| random.below(2001) as u16),
            ..TickOutput::NONE
        },
    }
}

struct Test<M> {
    random: Random,
    encoder: Encoder,
    decoder: Decoder,
    message: fn(&mut Random) -> M,
    direction: u8,
    understood: usize,
    strange: usize,
}

impl<M: Message + Debug> Test<M> {
    fn new(seed: u64, message: fn(&mut Random) -> M, direction: u8) -> Self {
        Self {
            random: Random::new(seed),
            encoder: Encoder::default(),
            decoder: Decoder::default(),
            message,
            direction,
            understood: 0,
            strange: 0,
        }
    }

    /// A message's frame and its number.
    fn real(&mut self) -> (u16, Vec<u8>) {
        let message = (self.message)(&mut self.random);
        let (sequence, frame) = self.encoder.encode(&message);
        (sequence, frame.to_vec())
    }

    /// An intact frame with something inside that need not be a message.
    fn hostile(&mut self) -> (u16, Vec<u8>) {
        let random = &mut self.random;
        let version = random.one_of(&[VERSION, VERSION, VERSION, 0, 2]);
        let direction = random.one_of(&[self.direction, self.direction, b'B', b'H', 0]);
        let sequence = random.below(0x1_0000) as u16;
        let choice: &[u8] = random.one_of(&[&[], &[0, 1, 2, 3, 4, 5, 0xFF]]);
        let body = random.bytes(60, choice);
        (sequence, frame(version, direction, sequence, &body))
    }

    /// Pushes a stream. Whatever is understood is one of these frames, whole.
    fn push(&mut self, stream: &[u8], intact: &[(u16, Vec<u8>)]) {
        let mut begin = 0;
        for (at, byte) in stream.iter().enumerate() {
            let result = self.decoder.push::<M>(*byte);
            let segment = &stream[begin..=at];
            if *byte == 0 {
                begin = at + 1;
            } else {
                assert!(result.is_none(), "{result:?} before the end of a frame");
            }
            let is_intact =
                |sequence: u16| intact.iter().any(|i| i.0 == sequence && i.1 == segment);
            match result {
                Some(Ok(received)) => {
                    assert!(is_intact(received.sequence), "{received:?}");
                    self.understood += 1;
                }
                Some(Err(FrameError::Damaged)) => {
                    let was_intact = intact.iter().any(|(_, frame)| frame == segment);
                    assert!(!was_intact, "{segment:02x?}");
                }
                Some(Err(_)) => self.strange += 1,
                None => {}
            }
        }
    }

    fn stream(&mut self) {
        let mut intact = Vec::new();
        let mut stream = match self.random.below(6) {
            0 => self.random.bytes(2 * MAX as u64, &[]),
            1 => self
                .random
                .bytes(40, &[0, 0, 0, 1, 2, 0xFF, VERSION, b'B', b'H']),
            2 => {
                intact.push(self.hostile());
                intact[0].1.clone()
            }
            kind => {
                let count = 1 + self.random.below(2);
                intact.extend((0..count).map(|_| self.real()));
                let mut bytes: Vec<u8> = intact.iter().flat_map(|i| i.1.clone()).collect();
                for _ in 0..kind - 3 {
                    self.random.damage(&mut bytes);
                }
                bytes
            }
        };
        // Back in step at the next zero: after it, what is intact arrives.
        stream.push(0);
        let last = self.real();
        stream.extend(&last.1);
        intact.push(last);
        let before = self.understood;
        self.push(&stream, &intact);
        assert!(self.understood > before, "lost after {stream:02x?}");
    }

    fn run(&mut self) {
        for _ in 0..STREAMS / 2 {
            self.stream();
        }
        // Every stream's last frame, and of damaged pairs often one.
        assert!(self.understood > STREAMS / 2 + STREAMS / 8);
        assert!(self.strange > STREAMS / 40, "{} strange", self.strange);
    }
}

#[test]
fn the_decoder_understands_what_is_intact_and_nothing_else() {
    Test::new(0x5EED_0003, to_board, ToBoard::DIRECTION).run();
    Test::new(0x5EED_0004, to_host, ToHost::DIRECTION).run();
}
