//! The plan runner at a link without a board of this version.

use armbridge_analysis::plan_runner::{PlanError, PlanRunner, Script};
use armbridge_client::Host;
use armbridge_client::error::SessionError;
use armbridge_link::frame::Encoder;
use armbridge_link::message::{Hello, Setup, ToHost};
use armbridge_link::schema;

/// Runs against a peer that sends the same every 100 ms, until it gives up.
fn verdict(bytes: &[u8]) -> SessionError {
    let mut runner = PlanRunner::new(Script::demo(Setup::default(), 1_000_000));
    for now_us in (0..10_000_000).step_by(100_000) {
        let spoken = runner.transmit(now_us).map(<[u8]>::len);
        let result = spoken.and_then(|_| runner.receive(now_us, bytes));
        if let Err(error) = result {
            let PlanError::Session(error) = error else {
                panic!("{error}");
            };
            return error;
        }
    }
    panic!("the runner never gave up");
}

#[test]
fn another_schema_is_told_with_both_versions() {
    let mut hello = Hello {
        version: [7, 8, 9],
        ..schema::HELLO
    };
    hello.schema[0] ^= 1;
    let frame = Encoder::default().encode(&ToHost::Hello(hello)).1.to_vec();
    let error = verdict(&frame);
    assert_eq!(error, SessionError::OtherSchema(hello));
    let line = error.to_string();
    let [major, minor, patch] = schema::VERSION;
    for word in [
        format!("{:016x}, version 7.8.9", u64::from_be_bytes(hello.schema)),
        format!(
            "{:016x}, version {major}.{minor}.{patch}",
            u64::from_be_bytes(schema::HASH)
        ),
        "build and flash both from the same source".into(),
    ] {
        assert!(line.contains(&word) && !line.contains('\n'), "{line}");
    }
}

#[test]
fn garbage_is_told_from_silence() {
    assert_eq!(verdict(&[]), SessionError::NoBoard { damaged: 0 });
    let error = verdict(b"garbage\0");
    let SessionError::NoBoard { damaged } = error else {
        panic!("{error}");
    };
    assert!(damaged >= 30, "{damaged}");
    let line = error.to_string();
    assert!(line.contains(&damaged.to_string()) && line.contains("is this the board's link?"));
}
