//! The raw bytes of the link, kept beside what was made of them.

use armbridge_client::event::{Direction, Event};
use armbridge_link::message::ToHost;
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::{Reader, Recording};

use super::random_messages::{Random, Talk};
use super::{facts, folder};

#[test]
fn the_raw_bytes_say_the_same_again() {
    let path = folder("raw").join("run.mcap");
    let recorder = Recorder::create_waiting(&path, &facts()).unwrap();
    let mut tap = recorder.tap();
    let mut talk = Talk::new(&mut *tap);
    let mut random = Random(1);
    for tick in 0..12_000 {
        talk.tell(&ToHost::Record(random.record(tick)));
        match tick % 1_000 {
            300 => random
                .host_messages()
                .iter()
                .for_each(|message| talk.ask(message)),
            600 => random
                .board_messages()
                .iter()
                .for_each(|message| talk.tell(message)),
            // A byte that came alone: its frame begins in another piece.
            700 => talk.travel(Direction::ToHost, &[9]),
            800 => talk.miss(),
            900 => talk.part(),
            _ => {}
        }
    }
    recorder.finish().unwrap();
    let written = Recording::load(&path).unwrap().events;
    let again: Vec<Event> = Reader::open(&path)
        .unwrap()
        .raw()
        .unwrap()
        .map(Result::unwrap)
        .collect();
    assert_eq!(again.len(), written.len());
    // NaN is not equal to itself, but is written the same.
    assert_eq!(format!("{again:?}"), format!("{written:?}"));
}
