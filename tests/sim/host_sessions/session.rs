//! The station on the bench.

use std::sync::{Arc, Mutex};

use armbridge_client::event::{Direction, EventKind, LinkDecoder};
use armbridge_client::session::{ChannelHost, Request};
use armbridge_client::{Host, Tap};
use armbridge_link::message::{Command, Drive, Fault, Mode, StopSource, ToHost};
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardUri, Options, drive};
use armbridge_sim::plant::{Plant, PlantConfig};

/// Observes the modes one after the other, and makes the next request on each.
struct Listener<F> {
    ear: LinkDecoder,
    modes: Arc<Mutex<Vec<Mode>>>,
    on_mode: F,
}

impl<F: FnMut(Mode) + Send> Tap for Listener<F> {
    fn bytes(&mut self, direction: Direction, host_ns: u64, bytes: &[u8]) {
        let Self {
            ear,
            modes,
            on_mode,
        } = self;
        ear.take(direction, host_ns, bytes, |event| {
            let EventKind::Received(_, ToHost::Record(record)) = event.kind else {
                return;
            };
            let mut modes = modes.lock().unwrap();
            if modes.last() != Some(&record.mode) {
                modes.push(record.mode);
                on_mode(record.mode);
            }
        });
    }

    fn disconnected(&mut self, _host_ns: u64) {}
}

/// The modes that a board on the bench goes through, with a request on each.
fn modes(mut on_mode: impl FnMut(Mode) -> Vec<Request> + Send + 'static) -> Vec<Mode> {
    let (station, controls) = ChannelHost::new();
    let modes = Arc::new(Mutex::new(Vec::new()));
    let listener = Listener {
        ear: LinkDecoder::default(),
        modes: Arc::clone(&modes),
        on_mode: move |mode| {
            for request in on_mode(mode) {
                controls.request(request).unwrap();
            }
        },
    };
    let bench = Bench::new(Plant::new(PlantConfig::default(), 1));
    let mut options = Options::new(bench);
    options.link.taps.push(Box::new(listener));
    let (_, result) = drive(&BoardUri::Sim, options, station);
    result.unwrap();
    Arc::try_unwrap(modes).unwrap().into_inner().unwrap()
}

#[test]
fn requests_are_done_in_order_and_leaving_disarms() {
    let observed = modes(|mode| match mode {
        Mode::Idle => vec![
            Request::Arm,
            Request::Command(Command::Regulate([0.0, 0.0])),
        ],
        Mode::Running(_) => vec![Request::Leave],
        _ => vec![],
    });
    // The second waits until the motors have been checked.
    let expected = [
        Mode::Idle,
        Mode::MotorCheck,
        Mode::Armed,
        Mode::Running(Drive::Regulate),
    ];
    assert_eq!(observed, expected);
}

#[test]
fn a_stop_needs_no_session_and_comes_before_what_waits() {
    let fault = Mode::Fault(Fault::EmergencyStop(StopSource::Host));
    let observed = modes(move |mode| match mode {
        Mode::Idle => vec![Request::Stop, Request::Leave],
        _ => vec![],
    });
    assert_eq!(observed.first(), Some(&Mode::Idle));
    let observed = modes(move |mode| match mode {
        Mode::Idle => vec![Request::Arm, Request::Stop],
        mode if mode == fault => vec![Request::Leave],
        _ => vec![],
    });
    assert_eq!(observed, [Mode::Idle, fault]);
}

#[test]
fn without_controls_it_leaves() {
    let (station, _) = ChannelHost::new();
    let bench = Bench::new(Plant::new(PlantConfig::default(), 1));
    let (station, result) = drive(&BoardUri::Sim, Options::new(bench), station);
    result.unwrap();
    assert!(station.is_done());
}
