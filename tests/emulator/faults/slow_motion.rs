//! An emulated board in slow motion, virtual servos on its bus, and a host.
//!
//! QEMU's clock counts instructions at 8 ns each: while the board computes, its
//! time passes with what it does and not with what else the machine does. While
//! it waits, its time is the wall clock's, as is that of servos and host; the
//! slower the motion, the less it matters when one of them is late.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use armbridge_client::Host;
use armbridge_client::session::BoardMessage;
use armbridge_client::tcp_pump::is_timeout;
use armbridge_link::message::Command;
use armbridge_servo::JOINTS;
use armbridge_sim::Bench;
use armbridge_sim::emulator::{Image, Provocation, Qemu, QemuOptions, Time, log};
use armbridge_sim::plant::Plant;
use armbridge_tests::plant;

use super::driving_host::DrivingHost;
use super::tap::OFF;

/// Longest wait for anything, of the wall clock: the machine may be busy.
const PATIENCE: Duration = Duration::from_secs(60);
/// Finest step of the servos, of the wall clock.
const STEP: Duration = Duration::from_micros(200);
/// When the servos can be asked first, in µs of theirs.
const STARTED_US: u64 = 5_000;

/// Bytes on the bus.
#[derive(Debug, Default)]
pub(crate) struct Bus {
    /// Bytes of the board.
    pub(crate) sent: Vec<u8>,
    /// PWM of the motors whenever it changed.
    pub(crate) pwm: Vec<[u16; JOINTS]>,
}

/// The board with all around it.
pub(crate) struct Rig {
    qemu: Qemu,
    slow: u32,
    begun: Instant,
    pub(crate) host: DrivingHost,
    pub(crate) bus: Arc<Mutex<Bus>>,
    log: Arc<Mutex<Vec<String>>>,
    servos: Option<JoinHandle<()>>,
}

impl Rig {
    /// Everything switched on.
    pub(crate) fn start(slow: u32, provoke: Option<Provocation>) -> Self {
        let options = QemuOptions {
            image: Image::current().unwrap(),
            time: Time::Slow(slow),
            icount: true,
            provoke,
        };
        let qemu = Qemu::start(&options).unwrap();
        let log = Arc::<Mutex<Vec<String>>>::default();
        let lines = Arc::clone(&log);
        let stream = qemu.log.try_clone().unwrap();
        log::spawn(&options.image, stream, move |line| {
            lines.lock().unwrap().push(line);
        })
        .unwrap();
        let bus = Arc::<Mutex<Bus>>::default();
        let (stream, seen) = (qemu.bus.try_clone().unwrap(), Arc::clone(&bus));
        Self {
            servos: Some(std::thread::spawn(move || serve(stream, slow, &seen))),
            qemu,
            slow,
            begun: Instant::now(),
            host: DrivingHost::new(Command::Regulate([0.0; 2])),
            bus,
            log,
        }
    }

    /// Lets the host talk to the board until `is_it`.
    pub(crate) fn until(&mut self, condition: &str, mut is_it: impl FnMut(&DrivingHost) -> bool) {
        let begun = Instant::now();
        let mut bytes = [0; 4_096];
        self.qemu.link.set_read_timeout(Some(STEP)).unwrap();
        while !is_it(&self.host) {
            assert!(
                begun.elapsed() < PATIENCE,
                "waited for {condition} in vain; log {:#?}, last message {:?}",
                self.log.lock().unwrap(),
                self.host.messages.last()
            );
            let now_us = self.begun.elapsed().as_micros() as u64 / u64::from(self.slow);
            let Ok(say) = self.host.transmit(now_us);
            self.qemu.link.write_all(say).unwrap();
            match self.qemu.link.read(&mut bytes) {
                Ok(0) => panic!("QEMU is gone"),
                Ok(count) => {
                    let Ok(()) = self.host.receive(now_us, &bytes[..count]);
                }
                Err(error) => assert!(is_timeout(&error), "{error}"),
            }
        }
    }

    /// The same, until the board sends such a message.
    pub(crate) fn until_message(
        &mut self,
        condition: &str,
        mut is_it: impl FnMut(&BoardMessage) -> bool,
    ) -> BoardMessage {
        let before = self.host.messages.len();
        self.until(condition, |host| {
            host.messages[before..].iter().any(&mut is_it)
        });
        let mut messages = self.host.messages[before..].iter();
        *messages.find(|message| is_it(message)).unwrap()
    }

    /// Until the arm is driven. Returns how much had been on the bus before.
    pub(crate) fn until_driven(&mut self) -> usize {
        self.until("the arm to be driven", |host| {
            let last = host.last();
            last.is_some_and(|record| {
                record.mode.drive().is_some() && record.input.pwm_in_force != OFF
            })
        });
        self.bus.lock().unwrap().sent.len()
    }

    /// Writes these bytes to the host's link, as fast as the board takes them.
    pub(crate) fn flood(&self, bytes: Vec<u8>) -> JoinHandle<()> {
        let mut link = self.qemu.link.try_clone().unwrap();
        std::thread::spawn(move || {
            // The board may be gone before the end.
            let _ = link.write_all(&bytes);
        })
    }

    /// The first line of the log that contains this, and when it was written, in µs of the
    /// board's time.
    pub(crate) fn logged(&self, text: &str) -> Option<(f64, String)> {
        let log = self.log.lock().unwrap();
        let line = log.iter().find(|line| line.contains(text))?;
        Some((at_us(line)?, line.clone()))
    }

    /// When the servos' supply was switched on and off, as of [`supply_changes`].
    pub(crate) fn supply(&self) -> Vec<(f64, bool)> {
        supply_changes(&self.log.lock().unwrap())
    }
}

/// When a line of the log was written, in µs of the board's time.
fn at_us(line: &str) -> Option<f64> {
    let at_s: f64 = line.split(' ').next()?.parse().ok()?;
    Some(at_s * 1e6)
}

/// When the servos' supply was switched, in µs of the board's time, and whether on.
pub(crate) fn supply_changes(log: &[String]) -> Vec<(f64, bool)> {
    let changes = log.iter().filter_map(|line| {
        let is_on = line.contains("supply on");
        (is_on || line.contains("supply off")).then_some((at_us(line)?, is_on))
    });
    changes.collect()
}

impl Drop for Rig {
    fn drop(&mut self) {
        // QEMU may have closed it already.
        let _ = self.qemu.bus.shutdown(Shutdown::Both);
        if let Some(servos) = self.servos.take() {
            // If it has panicked, the test has failed for want of servos.
            let _ = servos.join();
        }
    }
}

/// The servos, in wall-clock time, until the board is gone.
fn serve(mut stream: TcpStream, slow: u32, seen: &Mutex<Bus>) {
    let mut bench = Bench::new(Plant::new(plant([0.2, -0.2], true), 1));
    let begun = Instant::now();
    let (mut bytes, mut from_bench) = ([0; 1_024], Vec::new());
    stream.set_read_timeout(Some(STEP)).unwrap();
    loop {
        let count = match stream.read(&mut bytes) {
            Ok(0) => return,
            Ok(count) => count,
            Err(error) if is_timeout(&error) => 0,
            Err(_) => return,
        };
        let now_us = STARTED_US + begun.elapsed().as_micros() as u64 / u64::from(slow);
        bench.advance(now_us, None, &mut from_bench);
        bench.send(now_us, &bytes[..count]);
        if stream.write_all(&from_bench).is_err() {
            return;
        }
        from_bench.clear();
        let pwm = [0, 1].map(|joint| bench.applied_pwm(joint));
        let mut seen = seen.lock().unwrap();
        seen.sent.extend_from_slice(&bytes[..count]);
        if seen.pwm.last() != Some(&pwm) {
            seen.pwm.push(pwm);
        }
    }
}
