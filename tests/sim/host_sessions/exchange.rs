//! Settings read from a board on the bench and written to it.

use armbridge_client::params::settings_exchange::{Exchange, Exchanged, commands};
use armbridge_client::params::{of_text, set};
use armbridge_link::message::{Command, Refusal, Settings};
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardUri, Options, drive};
use armbridge_sim::plant::{Plant, PlantConfig};

fn exchange(decide: impl FnOnce(&Settings) -> Vec<Command>) -> Exchanged {
    let bench = Bench::new(Plant::new(PlantConfig::default(), 1));
    let (host, result) = drive(&BoardUri::Sim, Options::new(bench), Exchange::new(decide));
    result.unwrap();
    host.exchanged
}

#[test]
fn reads_what_is_in_force_and_changes_it_as_a_group() {
    let read = exchange(|_| Vec::new());
    assert_eq!(read.before, Some(Settings::default()));
    assert_eq!((read.taken.len(), read.refused), (0, None));

    let mut after = Settings::default();
    set(&mut after, "controller.r", &of_text("5,5")).unwrap();
    set(&mut after, "limits.hold_ms", &of_text("80")).unwrap();
    let wanted = commands(&Settings::default(), &after, true);
    assert_eq!(wanted.len(), 3);
    let done = exchange(|before| commands(before, &after, true));
    assert_eq!((done.taken, done.refused), (wanted, None));
}

#[test]
fn stops_at_what_is_refused() {
    let mut after = Settings::default();
    after.setup.period_us = 1;
    let done = exchange(|before| commands(before, &after, true));
    let (command, refusal) = done.refused.unwrap();
    assert!(matches!(command, Command::Configure(_)));
    assert_eq!((refusal, done.taken.len()), (Refusal::OutOfRange, 0));
}
