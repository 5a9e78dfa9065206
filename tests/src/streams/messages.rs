//! Seeds that are messages of the link, as the encoder writes them.

use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Conclusion, Experiment, ExperimentEnd, Role};
use armbridge_link::frame::{Encoder, Message};
use armbridge_link::message::{
    Command, Drive, Guards, Hello, Missing, Mode, Moment, PortCounters, Record, Refusal, Sample,
    Settings, Setup, TickInput, TickOutput, Timing, ToBoard, ToHost,
};
use armbridge_link::motion::{Motion, Via};
use armbridge_servo::Firmware;

use super::seeds::Seeds;

const MOMENT: Moment = Moment {
    tick: 1_000,
    is_decided: true,
    at_us: 1_000_700,
    mode: Mode::Armed,
};

const HELLO: Hello = Hello {
    schema: *b"a schema",
    version: [1, 2, 3],
};

/// One message of each kind.
pub(crate) fn seeds() -> Seeds {
    let mut seeds = Seeds::new();
    seeds.extend(to_board().map(|(name, message)| (name.to_owned(), frame(&message))));
    seeds.extend(to_host().map(|(name, message)| (name.to_owned(), frame(&message))));
    seeds
}

fn to_board() -> [(&'static str, ToBoard); 13] {
    let mut vias = [None; _];
    vias[0] = Some(Via {
        at_s: 0.5,
        angle_rad: [0.25, -0.25],
    });
    let wave = Motion::Sinusoid {
        centre_rad: [0.0; 2],
        amplitude_rad: [0.25, 0.125],
        frequency_hz: [1.0, 0.5],
        phase_rad: [0.0; 2],
        ramp_s: 0.75,
        duration_s: 2.0,
    };
    let there = Motion::MinimumJerk {
        to_rad: [0.25, -0.25],
        duration_s: Some(1.5),
    };
    let stream = Command::Stream {
        at_us: 1_234_567,
        angle_rad: [0.25, -0.25],
        speed_rad_s: Some([0.5, -0.5]),
    };
    [
        ("hello", ToBoard::Hello(HELLO)),
        ("heartbeat", ToBoard::Heartbeat),
        ("idle", ToBoard::Command(Command::Idle)),
        ("torque", ToBoard::Command(Command::Torque([0.125, -0.25]))),
        (
            "regulate",
            ToBoard::Command(Command::Regulate([0.25, -0.5])),
        ),
        ("minimum-jerk", ToBoard::Command(Command::Follow(there))),
        (
            "waypoints",
            ToBoard::Command(Command::Follow(Motion::Waypoints(vias))),
        ),
        ("wave", ToBoard::Command(Command::Follow(wave))),
        ("stream", ToBoard::Command(stream)),
        ("experiment", ToBoard::Command(experiment())),
        ("release", ToBoard::Command(Command::Release)),
        ("clear-fault", ToBoard::Command(Command::ClearFault)),
        (
            "configure",
            ToBoard::Command(Command::Configure(Setup::default())),
        ),
    ]
}

fn to_host() -> [(&'static str, ToHost); 14] {
    let refused = ToHost::Ack {
        sequence: 7,
        result: Err(Refusal::Unstable { re: 1.5, im: 0.25 }),
        moment: None,
    };
    let accepted = ToHost::Ack {
        sequence: 300,
        result: Ok(()),
        moment: Some(MOMENT),
    };
    let departs = ToHost::Departs {
        sequence: 301,
        moment: MOMENT,
    };
    let absent = ToHost::Absent {
        joint: 1,
        missing: Missing::Silence,
    };
    let found = ToHost::Found {
        firmware: Firmware::Stock,
        baud: 1_000_000,
        is_ready: true,
    };
    let counters = PortCounters {
        passed: 300,
        delayed: 20,
        refused: 1,
        halves: 0,
        lost: 0,
        ended: 0,
    };
    [
        ("hello-answer", ToHost::Hello(HELLO)),
        ("accepted", accepted),
        ("refused", refused),
        ("departs", departs),
        ("began", ToHost::Began(MOMENT)),
        ("settings", ToHost::Settings(Settings::default())),
        ("absent", absent),
        ("found", found),
        (
            "mixed",
            ToHost::Mixed([Firmware::Morpheus, Firmware::Stock]),
        ),
        ("unprepared", ToHost::Unprepared { joint: 0 }),
        ("concluded", concluded()),
        ("passthrough", ToHost::Passthrough),
        ("port", ToHost::Port(counters)),
        ("record", ToHost::Record(record())),
    ]
}

fn concluded() -> ToHost {
    ToHost::Concluded(Conclusion {
        tick: 4_000,
        end: ExperimentEnd::Angle {
            joint: 1,
            value_rad: 0.75,
        },
    })
}

fn experiment() -> Command {
    Command::Experiment(Experiment {
        roles: [
            Role::Hold,
            Role::Pwm(Signal::Steps {
                first: 50.0,
                increment: 25.0,
                steps: 6,
                on_s: 0.5,
                off_s: 0.25,
                alternating: true,
            }),
        ],
        duration_s: 10.0,
        angle_rad: [[-0.5, 0.5], [-0.75, 0.75]],
        speed_rad_s: [1.0, 2.0],
    })
}

fn record() -> Record {
    Record {
        tick: 1_000,
        mode: Mode::Degraded(Drive::Regulate),
        timing: Timing::default(),
        dropped: 3,
        input: TickInput {
            start_us: 1_000_000,
            samples: [Sample::Counts(500), Sample::Missing(Missing::BadChecksum)],
            alarms: [0, 36],
            pwm_in_force: [1_500, 900],
            ..TickInput::AT_REST
        },
        output: TickOutput {
            guards: Guards::RATE,
            pwm: [1_501, 899],
            reference_rad: [0.25, -0.25],
            reference_speed_rad_s: [0.0; 2],
            angle_rad: [0.25, -0.25],
            speed_rad_s: [0.5, -0.5],
            torque_nm: [0.125, -0.125],
            disturbance_nm: [0.0; 2],
            ..TickOutput::NONE
        },
    }
}

fn frame<M: Message>(message: &M) -> Vec<u8> {
    Encoder::default().encode(message).1.to_vec()
}
