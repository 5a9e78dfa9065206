//! A board's image in step with the wall clock, its control link and its serial port on
//! sockets: what programs find at the USB of a board.

use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use armbridge_client::endpoint::Exposure;
use armbridge_client::servo_bus::Port;
use armbridge_client::transport::LinkUri;
use armbridge_sim::Bench;
use armbridge_sim::cosim::{Interaction, PortClient};
use armbridge_sim::link_server::LinkServer;
use armbridge_sim::usb2dynamixel_server::PortServer;
use armbridge_stm32_emulator::usb_host::enumeration::Request;
use armbridge_tests::board_image::BoardRun;

use super::{FEATHER, ON_USB_MS, until_configured};

/// Interval of what is seen of arm and motors.
const LOOK_MS: u64 = 1;

/// Time for which the board goes on after its last program.
const AFTERWARDS: Duration = Duration::from_millis(400);

/// Arm and motors at one time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Truth {
    /// True angles in rad.
    pub(super) angle_rad: [f64; 2],
    /// PWM in force in the servos.
    pub(super) pwm: [u16; 2],
}

/// A served board.
pub(super) struct Served {
    /// Its control link.
    pub(super) link: LinkUri,
    /// Its transparent port.
    pub(super) port: Port,
    is_over: Arc<AtomicBool>,
    thread: JoinHandle<(BoardRun<LinkServer>, Vec<Truth>)>,
}

impl Served {
    /// With this bench, which is made on the board's thread.
    pub(super) fn with(bench: impl FnOnce() -> Bench + Send + 'static) -> Self {
        let at = "tcp://127.0.0.1:0".parse().unwrap();
        let (host, link) = LinkServer::offer(&at, Exposure::Loopback).unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = format!("tcp://{}", listener.local_addr().unwrap());
        let is_over = Arc::new(AtomicBool::new(false));
        let until = Arc::clone(&is_over);
        let thread = std::thread::spawn(move || serve(host, listener, bench(), &until));
        Self {
            link,
            port: port.parse().unwrap(),
            is_over,
            thread,
        }
    }

    /// The board some time after its last program, and what became of the arm.
    pub(super) fn end(self) -> (BoardRun<LinkServer>, Vec<Truth>) {
        std::thread::sleep(AFTERWARDS);
        self.is_over.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

fn serve(
    mut host: LinkServer,
    listener: TcpListener,
    bench: Bench,
    is_over: &AtomicBool,
) -> (BoardRun<LinkServer>, Vec<Truth>) {
    let hands = host.interactions().unwrap();
    let mut port = PortServer::on_socket(listener).unwrap();
    let mut run = FEATHER.on(bench, host).powered_up();
    until_configured(&mut run, ON_USB_MS);
    let mut was_open = false;
    let mut truths = Vec::new();
    while !is_over.load(Ordering::Relaxed) {
        run.run_for(LOOK_MS);
        assert!(run.host_error.is_none(), "{:?}", run.host_error);
        let now_us = run.machine.now().as_us();
        let system = &mut run.machine.system;
        for hand in hands.try_iter() {
            match hand {
                Interaction::Move {
                    to_rad,
                    duration_us,
                } => system.line.bench.move_by_hand(to_rad, duration_us),
                other => panic!("{other:?}"),
            }
        }
        // A program opens the port, which a USB host tells the board.
        let is_open = port.line().is_open;
        if is_open != was_open {
            was_open = is_open;
            let mut coding = 1_000_000_u32.to_le_bytes().to_vec();
            coding.extend([0, 0, 8]);
            system.usb.request(Request::line_coding(), coding);
            system
                .usb
                .request(Request::control_lines(is_open), Vec::new());
        }
        let serial = &mut system.usb.serial;
        let from_board: Vec<u8> = serial.input.bytes.drain(..).collect();
        port.receive(now_us, &from_board);
        port.set_waiting(serial.output.bytes.len());
        serial.output.bytes.extend(port.transmit(now_us));
        system.touch();
        let bench = &system.line.bench;
        truths.push(Truth {
            angle_rad: bench.plant().state().q.into(),
            pwm: [0, 1].map(|servo| bench.applied_pwm(servo)),
        });
    }
    (run, truths)
}
