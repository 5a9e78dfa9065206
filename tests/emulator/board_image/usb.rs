//! USB: what a host finds, and that the link survives what hosts do.

use armbridge_client::host::NoHost;
use armbridge_link::message::ToBoard;
use armbridge_stm32_emulator::usb_host::State;
use armbridge_stm32_emulator::usb_host::enumeration::Request;
use armbridge_tests::board_image::BoardRun;
use armbridge_tests::tapped_bench::{Action, ScriptedHost};

use super::{ON_USB_MS, TestBoard, until_configured, us};

/// Text as descriptors hold it.
fn utf16(text: &str) -> Vec<u8> {
    text.encode_utf16().flat_map(u16::to_le_bytes).collect()
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

fn a_host_finds_driver_interface_and_serial_number(board: TestBoard) {
    let mut run = board.with(NoHost).powered_up();
    until_configured(&mut run, ON_USB_MS);
    let usb = &run.machine.system.usb;
    let found = usb.descriptors();
    assert_eq!(found.ids(), Some((0x1209, 0x0001)));
    let [manufacturer, product, serial] = &found.strings;
    assert_eq!(manufacturer.as_deref(), Some("Armbridge"));
    assert_eq!(product.as_deref(), Some("Armbridge"));
    // The chip's identifier.
    assert_eq!(serial.as_ref().map(String::len), Some(24));
    let endpoints = found.endpoints();
    assert!(endpoints.link_in.is_some() && endpoints.link_out.is_some());
    assert!(endpoints.serial_in.is_some() && endpoints.serial_out.is_some());
    // Windows: the driver, and the name of the interface by which programs find it.
    assert!(contains(&found.microsoft, b"WINUSB"));
    assert!(contains(&found.microsoft, &utf16("DeviceInterfaceGUIDs")));
    assert!(contains(&found.microsoft, &utf16("{9BD2DF71-")));
    // As long as it says.
    let [.., low, high] = found.microsoft[..10] else {
        panic!("{:?}", found.microsoft)
    };
    assert_eq!(
        usize::from(u16::from_le_bytes([low, high])),
        found.microsoft.len()
    );
}

/// D+ is low for more than 3 ms before the board attaches, also after a reset of the chip
/// alone, and then it rises once.
fn a_host_sees_the_board_go_at_a_reset(board: TestBoard) {
    use armbridge_stm32_emulator::peripherals::rcc::Reset;
    let mut run = board.with(NoHost).powered_up();
    until_configured(&mut run, ON_USB_MS);
    run.machine.reset(Reset::Pin).unwrap();
    let reset_at = run.machine.now();
    run.run_for(1);
    until_configured(&mut run, ON_USB_MS);
    run.run_for(20);
    let edges = run.machine.system.usb.pull_up_edges();
    let after: Vec<_> = edges.iter().filter(|(at, _)| *at >= reset_at).collect();
    let [(gone, false), (back, true)] = after[..] else {
        panic!("{after:?}")
    };
    assert!(*back - *gone > us(3_000));
}

/// A host that configures the board a second time, as one does that takes it over from another
/// program, begins at DATA0. So does the board: no packet is lost.
fn no_packet_is_lost_after_a_second_configuration_or_bus_reset(board: TestBoard) {
    let host = ScriptedHost::new([(0, Action::Message(ToBoard::Heartbeat))], u64::MAX);
    let mut run = board.with(host).powered_up();
    until_configured(&mut run, ON_USB_MS);
    run.run_for(20);
    assert!(run.report().is_some());
    // Both directions would go on with DATA1. A zero ends a frame, here one of no bytes.
    if run.machine.system.usb.link.output.packets.is_multiple_of(2) {
        run.machine.system.usb.link.output.bytes.push_back(0);
        run.machine.system.touch();
    }
    let is_odd = |run: &BoardRun<ScriptedHost>| {
        let link = &run.machine.system.usb.link;
        link.input.packets % 2 == 1 && link.output.packets % 2 == 1
    };
    let latest = run.machine.now() + us(20_000);
    while !is_odd(&run) {
        assert!(run.machine.now() < latest);
        run.machine.step(latest).unwrap();
    }
    run.machine.system.usb.configure_again();
    run.machine.system.touch();
    run.run_for(10);
    let before = run.records().count();
    run.run_for(50);
    assert!(run.records().count() >= before + 45, "records go on");
    let now = run.machine.now();
    run.machine.system.usb.reset(now);
    until_configured(&mut run, ON_USB_MS);
    run.run_for(20);
    let link = &run.machine.system.usb.link;
    assert_eq!((link.input.repeated, link.output.bytes.len()), (0, 0));
    assert!(link.input.packets > 1);
}

/// A host that suspends the bus, and one whose program stalls: the board goes on, and drops
/// records instead of anything else.
fn a_host_that_sleeps_or_stalls_finds_the_board_again(board: TestBoard) {
    let host = ScriptedHost::new([(0, Action::Message(ToBoard::Heartbeat))], u64::MAX);
    let mut run = board.with(host).powered_up();
    until_configured(&mut run, ON_USB_MS);
    run.run_for(20);
    let now = run.machine.now();
    let system = &mut run.machine.system;
    system.usb.suspend(now, &mut system.otg);
    system.touch();
    run.run_for(100);
    let now = run.machine.now();
    let system = &mut run.machine.system;
    system.usb.resume(now, &mut system.otg);
    system.touch();
    run.run_for(50);
    assert_eq!(run.machine.system.usb.state(), State::Configured);
    let resumed = run.records().next_back().unwrap();
    run.machine.system.usb.is_stalled = true;
    run.run_for(200);
    run.machine.system.usb.is_stalled = false;
    run.machine.system.touch();
    run.run_for(50);
    let last = run.records().next_back().unwrap();
    assert!(last.tick > resumed.tick + 200 && last.dropped > resumed.dropped + 50);
    assert_eq!(run.machine.resets().len(), 1);
}

/// A program opens the serial port: its rate and its lines reach the board, and its bytes
/// the bus.
fn the_serial_port_lends_the_bus(board: TestBoard) {
    let mut run = board.with(NoHost).powered_up();
    until_configured(&mut run, ON_USB_MS);
    let mut coding = 1_000_000_u32.to_le_bytes().to_vec();
    coding.extend([0, 0, 8]);
    let usb = &mut run.machine.system.usb;
    usb.request(Request::line_coding(), coding);
    usb.request(Request::control_lines(true), Vec::new());
    run.machine.system.touch();
    run.run_for(50);
    // A ping of Morpheus servo 1.
    let ping = [0xAA, 3, 1, 0xFE, 1, 0xF9];
    run.machine.system.usb.serial.output.bytes.extend(ping);
    run.machine.system.touch();
    run.run_for(20);
    let sent: Vec<u8> = run
        .machine
        .system
        .line
        .sent
        .iter()
        .map(|byte| byte.byte)
        .collect();
    assert!(contains(&sent, &ping));
    let answer: Vec<u8> = run
        .machine
        .system
        .usb
        .serial
        .input
        .bytes
        .iter()
        .copied()
        .collect();
    assert_eq!(answer.first(), Some(&0xAA), "{answer:02x?}");
}

on_each_board! {
    a_host_finds_driver_interface_and_serial_number,
    a_host_sees_the_board_go_at_a_reset,
    no_packet_is_lost_after_a_second_configuration_or_bus_reset,
    a_host_that_sleeps_or_stalls_finds_the_board_again,
    the_serial_port_lends_the_bus,
}
