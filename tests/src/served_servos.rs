//! Virtual servos on a socket, in wall-clock time. A busy machine may be late, so the
//! client here is more patient than it is by itself.

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

use armbridge_client::servo_bus::line::TcpLine;
use armbridge_client::servo_bus::reading::Value;
use armbridge_client::servo_bus::{BusMaster, Servo};
use armbridge_client::servo_table::MORPHEUS;
use armbridge_servo::Firmware as Kind;
use armbridge_sim::Bench;
use armbridge_sim::plant::{Plant, PlantConfig};
use armbridge_sim::raw_bus_server::WallClockBench;
use armbridge_sim::servo_kind::ServoKind;

const PATIENCE: Duration = Duration::from_millis(200);

/// The arm with either firmware.
pub const MORPHEUS_ARM: [(Kind, u8); 2] = [(Kind::Morpheus, 1), (Kind::Morpheus, 2)];
/// The arm with stock servos.
pub const STOCK_ARM: [(Kind, u8); 2] = [(Kind::Stock, 1), (Kind::Stock, 2)];

/// Virtual servos with these ids.
pub fn bench(servos: &[(Kind, u8, u32)]) -> WallClockBench {
    let plant = Plant::new(PlantConfig::default(), 1);
    let kinds: Vec<_> = servos
        .iter()
        .map(|(kind, id, baud)| ServoKind::new(*kind, *id, *baud).unwrap())
        .collect();
    WallClockBench::new(Bench::with_servos(plant, &kinds), 1)
}

/// Virtual servos on a socket, to one program after the other.
pub struct Served(SocketAddr);

impl Served {
    /// As `armbridge` takes it.
    pub fn port(&self) -> String {
        format!("tcp://{}", self.0)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // A connection without a byte ends it, after all earlier connections.
        let _ = TcpStream::connect(self.0);
    }
}

/// Serves an arm at 1 Mbaud on a free port of this machine.
pub fn serve(servos: &[(Kind, u8)], echo: bool) -> Served {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let at = listener.local_addr().unwrap();
    let servos: Vec<_> = servos
        .iter()
        .map(|(kind, id)| (*kind, *id, 1_000_000))
        .collect();
    std::thread::spawn(move || {
        let mut bench = bench(&servos);
        let mut next = None;
        loop {
            let (stream, _) = match next.take() {
                Some(next) => next,
                None => bench.accept(&listener).unwrap().unwrap(),
            };
            if matches!(stream.peek(&mut [0]), Ok(0)) {
                return;
            }
            // A connection that is closed early is skipped.
            next = bench.serve_socket(&stream, &listener, echo).unwrap_or(None);
        }
    });
    Served(at)
}

/// A client of the servos.
pub fn connect(at: &Served) -> BusMaster<TcpLine> {
    let stream = TcpStream::connect(at.0).unwrap();
    stream.set_nodelay(true).unwrap();
    BusMaster::new(TcpLine::new(stream), PATIENCE).unwrap()
}

/// The first temperature is measured half a second after power-up; until then
/// the register holds 0.
pub fn await_temperature(at: &Served) {
    let mut client = connect(at);
    let mut servo = Servo::find(&mut client, 2).unwrap();
    let begun = Instant::now();
    while servo
        .read(MORPHEUS.by_name("temperature").unwrap())
        .unwrap()
        .value
        == Value::Known(0)
    {
        assert!(begun.elapsed() < Duration::from_secs(20));
    }
}
