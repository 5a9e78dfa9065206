//! The seeds of the fuzz targets: `../seeds/TARGET/NAME`, as they go on a wire.
//!
//! Packets are the documented and the recorded ones; messages are one of each
//! kind, as the encoder writes them. The files are written from what stands
//! here by `UPDATE_SNAPSHOT=1 cargo test -p armbridge-tests --test fuzz_streams`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use armbridge_shared::link::frame::{Encoder, Message};
use armbridge_shared::link::message::{
    Command, Hello, Missing, Mode, Record, Refusal, Sample, Setup, Timing, ToBoard, ToHost,
};
use armbridge_shared::link::motion::{Motion, Via};

use super::checks;

type Seeds = BTreeMap<String, Vec<u8>>;

/// ROBOTIS e-Manual, and status packets to go with it.
const PROTOCOL1: [(&str, &str); 13] = [
    ("ping", "FF FF 01 02 01 FB"),
    ("ping-answer", "FF FF 01 02 00 FC"),
    ("read-36-8", "FF FF 01 04 02 24 08 CC"),
    (
        "read-36-8-answer",
        "FF FF 01 0A 00 00 02 00 00 00 00 78 20 5A",
    ),
    ("write-goal-speed", "FF FF 01 07 03 1E 00 02 00 02 D2"),
    ("reg-write-goal", "FF FF 01 05 04 1E 00 02 D5"),
    ("action", "FF FF FE 02 05 FA"),
    ("factory-reset", "FF FF 00 02 06 F7"),
    ("torque-off-all", "FF FF FE 04 03 18 00 E2"),
    (
        "sync-write-speed",
        "FF FF FE 0A 83 20 02 01 00 02 02 00 06 47",
    ),
    ("bulk-read", "FF FF FE 09 92 00 02 01 1E 02 02 24 1D"),
    ("overload-and-heat-answer", "FF FF 01 02 24 D8"),
    ("read-36-2-answer", "FF FF 01 04 00 02 01 F7"),
];

/// Recorded on a bus with the firmware, but for the last two.
const MORPHEUS: [(&str, &str); 15] = [
    ("ping", "AA 03 01 FE 01 F9"),
    ("ping-answer", "AA 03 FE 01 01 F9"),
    ("read-position", "AA 05 01 FE 02 0B 02 E7"),
    ("read-position-answer", "AA 04 FE 01 F4 01 03"),
    ("read-temperature", "AA 05 01 FE 02 0C 04 E4"),
    (
        "read-eeprom-answer",
        "AA 0D FE 01 AA 01 02 02 28 01 0A 28 0A 00 01 D1",
    ),
    ("write-pwm", "AA 06 01 FE 03 10 DC 05 00"),
    ("write-answer", "AA 03 FE 01 04 F6"),
    ("stop-all", "AA 06 FF FE 03 10 E8 03 F8"),
    ("sync-wr", "AA 0B FF FE 83 10 02 01 DC 05 02 84 03 EC"),
    ("start", "AA 03 FF FE 06 F6"),
    (
        "cycle",
        "AA 03 FF FE 07 F5 AA 04 FE 01 01 F4 03 AA 04 FE 02 01 F5 01",
    ),
    ("drive", "AA 0D FF FE 83 0F 03 01 00 DC 05 02 00 84 03 E8"),
    ("refused", "AA 03 FE 01 08 F2"),
    ("position-2", "AA 04 FE 02 01 F5 01"),
];

/// Scripts: see the target. Each begins with a stop, from which the master
/// learns whether it hears itself.
const MASTER: [(&str, &str); 6] = [
    ("stop", "00 02 02 02 02 02 02 02"),
    ("stop-echo", "00 02 02 05 02 05 02 05 02 05 02 05 02"),
    (
        "ping",
        "00 02 02 02 02 02 02 02 01 00 02 00 50 03 06 AA 03 FE 01 01 F9",
    ),
    (
        "start",
        "00 02 02 02 02 02 02 02 02 02 01 50 03 0C AA 03 FE 01 01 F9 AA 03 FE 02 01 F8",
    ),
    (
        "drive",
        "00 02 02 02 02 02 02 02 03 DC 05 84 03 02 02 \
         03 0E AA 04 FE 01 01 F4 03 AA 04 FE 02 01 F5 01",
    ),
    (
        "drive-echo",
        "00 02 02 05 02 05 02 05 02 05 02 05 02 03 DC 05 84 03 02 02 05 \
         03 0E AA 04 FE 01 01 F4 03 AA 04 FE 02 01 F5 01",
    ),
];

fn bytes(hex: &str) -> Vec<u8> {
    hex.split(' ')
        .map(|byte| u8::from_str_radix(byte, 16).expect("two digits"))
        .collect()
}

fn written(table: &[(&str, &str)]) -> Seeds {
    let seed = |(name, hex): &(&str, &str)| ((*name).to_owned(), bytes(hex));
    table.iter().map(seed).collect()
}

/// One message of each kind.
fn messages() -> Seeds {
    let hello = Hello {
        schema: *b"a schema",
        version: [1, 2, 3],
    };
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
    let to_board = [
        ("hello", ToBoard::Hello(hello)),
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
        ("clear-fault", ToBoard::Command(Command::ClearFault)),
        (
            "configure",
            ToBoard::Command(Command::Configure(Setup::default())),
        ),
    ];
    let refused = ToHost::Ack {
        sequence: 7,
        result: Err(Refusal::Unstable { re: 1.5, im: 0.25 }),
    };
    let accepted = ToHost::Ack {
        sequence: 300,
        result: Ok(()),
    };
    let absent = ToHost::Absent {
        joint: 1,
        missing: Missing::Silence,
    };
    let to_host = [
        ("hello-answer", ToHost::Hello(hello)),
        ("accepted", accepted),
        ("refused", refused),
        ("absent", absent),
        ("record", ToHost::Record(record())),
    ];
    let mut seeds = Seeds::new();
    seeds.extend(to_board.map(|(name, message)| (name.to_owned(), frame(&message))));
    seeds.extend(to_host.map(|(name, message)| (name.to_owned(), frame(&message))));
    seeds
}

fn record() -> Record {
    Record {
        tick: 1_000,
        start_us: 1_000_000,
        mode: Mode::Regulate,
        samples: [Sample::Counts(500), Sample::Missing(Missing::BadChecksum)],
        pwm_in_force: [1_500, 900],
        pwm_next: [1_501, 899],
        reference_rad: [0.25, -0.25],
        reference_speed_rad_s: [0.0; 2],
        angle_rad: [0.25, -0.25],
        speed_rad_s: [0.5, -0.5],
        torque_nm: [0.125, -0.125],
        disturbance_nm: [0.0; 2],
        timing: Timing::default(),
        dropped: 3,
    }
}

fn frame<M: Message>(message: &M) -> Vec<u8> {
    Encoder::default().encode(message).1.to_vec()
}

/// What the folder of each target holds.
fn all() -> [(&'static str, Seeds); 4] {
    [
        ("link", messages()),
        ("master", written(&MASTER)),
        ("morpheus", written(&MORPHEUS)),
        ("protocol1", written(&PROTOCOL1)),
    ]
}

fn folder(target: &str) -> PathBuf {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    seeds.join(target)
}

fn files(target: &str) -> Seeds {
    let Ok(files) = std::fs::read_dir(folder(target)) else {
        return Seeds::new();
    };
    files
        .map(|file| {
            let file = file.expect("a file");
            let name = file.file_name().into_string().expect("a name");
            (name, std::fs::read(file.path()).expect("its bytes"))
        })
        .collect()
}

/// The seeds of a target.
///
/// # Panics
/// If there are none.
pub(crate) fn read(target: &str) -> Vec<Vec<u8>> {
    let seeds: Vec<_> = files(target).into_values().collect();
    assert!(!seeds.is_empty(), "no seeds of {target}");
    seeds
}

#[test]
fn the_files_are_what_stands_here() {
    for (target, seeds) in all() {
        if std::env::var_os("UPDATE_SNAPSHOT").is_some() {
            let folder = folder(target);
            let _ = std::fs::remove_dir_all(&folder);
            std::fs::create_dir_all(&folder).unwrap();
            for (name, bytes) in &seeds {
                std::fs::write(folder.join(name), bytes).unwrap();
            }
        }
        assert_eq!(
            files(target),
            seeds,
            "meant? UPDATE_SNAPSHOT=1 rewrites seeds/{target}"
        );
    }
}

/// Each seed gets to where its target is interesting.
#[test]
fn every_seed_is_understood() {
    let checks = [
        checks::link::check,
        checks::master::check,
        checks::morpheus::check,
        checks::protocol1::check,
    ];
    for ((target, seeds), check) in all().into_iter().zip(checks) {
        for (name, bytes) in seeds {
            let is_answered = !name.starts_with("stop") || target == "morpheus";
            assert_eq!(check(&bytes) > 0, is_answered, "{target}/{name}");
        }
    }
}
