//! Any message on a link is read back from the log, bit by bit.

use armbridge_client::event::{Direction, Event, EventKind};
use armbridge_link::message::ToHost;
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::Recording;

use super::random_messages::{Random, Talk};
use super::{facts, folder};

/// An event as bytes: NaN is equal to itself in them.
fn bits(event: &Event) -> (u64, String, Vec<u8>) {
    let (kind, bytes) = match &event.kind {
        EventKind::Sent(sequence, message) => (
            format!("sent {sequence}"),
            postcard::to_stdvec(message).unwrap(),
        ),
        EventKind::Received(sequence, message) => (
            format!("received {sequence}"),
            postcard::to_stdvec(message).unwrap(),
        ),
        other @ (EventKind::Lost(..) | EventKind::Damaged(..) | EventKind::Disconnected) => {
            (format!("{other:?}"), Vec::new())
        }
    };
    (event.host_ns, kind, bytes)
}

#[test]
fn every_event_comes_back_bit_by_bit() {
    let path = folder("every_event").join("run.mcap");
    let recorder = Recorder::create_waiting(&path, &facts()).unwrap();
    let mut tap = recorder.tap();
    let mut talk = Talk::new(&mut *tap);
    let mut tick = 0;
    for seed in 0..40 {
        let mut random = Random(seed);
        for message in random.host_messages() {
            talk.ask(&message);
        }
        for message in random.board_messages() {
            talk.tell(&message);
            tick += 1;
            talk.tell(&ToHost::Record(random.record(tick)));
        }
        talk.miss();
        talk.travel(Direction::ToHost, &[7, 0]);
        talk.travel(Direction::ToBoard, &[1, 2, 3, 0]);
        if seed % 8 == 7 {
            talk.part();
        }
    }
    let written = std::mem::take(&mut talk.events);
    let report = recorder.finish().unwrap();
    assert_eq!((report.records, report.unwritten), (tick.into(), 0));
    assert_eq!(report.size, path.metadata().unwrap().len());
    assert_eq!(report.trouble, None);

    let recording = Recording::load(&path).unwrap();
    assert_eq!(recording.damage, [""; 0]);
    assert_eq!(recording.events.len(), written.len());
    for (read, written) in recording.events.iter().zip(&written) {
        assert_eq!(bits(read), bits(written), "{read:?}, {written:?}");
    }
    assert_eq!(recording.records().len(), tick as usize);
}
