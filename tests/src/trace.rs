//! Recorded exchanges with servos, as `data/morpheus/README.md` describes
//! them: one JSON object per line, one exchange each.

use std::io::Read;
use std::path::Path;

use flate2::read::GzDecoder;
use serde::Deserialize;

/// One exchange.
#[derive(Debug, Clone, Deserialize)]
#[allow(missing_docs)] // The fields are described beside the data.
pub struct Exchange {
    pub scenario: String,
    pub step: u32,
    pub power_up: Option<Vec<Hex>>,
    pub bus: Vec<OnBus>,
    pub events: Vec<Event>,
    pub baud: u32,
    #[serde(default)]
    pub byte_gap_us: f64,
    pub t_us: f64,
    pub tx: Hex,
    pub replies: Vec<Reply>,
    pub replies_total: usize,
    pub collision: bool,
    pub wire: Option<Hex>,
    pub window_us: f64,
    pub rx_overruns: Vec<u32>,
    pub pwm_changes: Vec<PwmChange>,
    pub pwm_changes_total: usize,
    pub after: Vec<After>,
    pub phase_dependent: Vec<String>,
}

impl Exchange {
    /// The first part of the scenario's name.
    pub fn family(&self) -> &str {
        self.scenario.split('/').next().unwrap_or_default()
    }

    /// Did this result differ with the phase of the servo's main loop?
    pub fn varies(&self, field: &str) -> bool {
        self.phase_dependent.iter().any(|name| name == field)
    }

    /// The same for a result that each servo has.
    pub fn varies_for(&self, field: &str, servo: usize) -> bool {
        self.varies(&format!("{field}[{servo}]"))
    }
}

/// A servo just before an exchange.
#[derive(Debug, Clone, Deserialize)]
#[allow(missing_docs)]
pub struct OnBus {
    pub position: u16,
    pub temperature: u16,
}

/// A change of a servo between two exchanges.
#[derive(Debug, Clone, Deserialize)]
#[allow(missing_docs)]
pub struct Event {
    #[serde(rename = "type")]
    pub kind: EventKind,
    pub servo: usize,
    pub t_us: f64,
    pub counts: Option<u16>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)]
pub enum EventKind {
    Position,
    Temperature,
    PowerCycle,
    Disconnect,
    Connect,
}

/// A packet from a servo.
#[derive(Debug, Clone, Deserialize)]
#[allow(missing_docs)]
pub struct Reply {
    pub servo: usize,
    pub hex: Hex,
    pub latency_us: f64,
    pub max_gap_us: f64,
    pub release_us: Option<f64>,
    pub complete: bool,
}

/// A change of the PWM on a motor.
#[derive(Debug, Clone, Copy, Deserialize)]
#[allow(missing_docs)]
pub struct PwmChange {
    pub servo: usize,
    pub t_us: f64,
    pub pwm: u16,
}

/// A servo at the end of an exchange.
#[derive(Debug, Clone, Deserialize)]
#[allow(missing_docs)]
pub struct After {
    pub id: u8,
    pub pwm: u16,
    pub mode: String,
    pub deaf: Option<bool>,
    pub deaf_cause: Option<String>,
    pub rx_state: String,
    pub rx_failsafe: u8,
    pub baud_reg: u8,
    pub position: u16,
    pub speed: u8,
    pub temperature: u16,
    pub pwm_reg: u16,
    pub pwm_sync: u16,
    pub pwm_last: u16,
    pub goal_reg: u16,
    pub goal_last: u16,
    pub goal_active: u16,
    pub speed_reg: u16,
    pub speed_active: u16,
    pub eeprom: Hex,
}

/// Bytes, written as hexadecimal digits.
#[derive(Clone, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct Hex(pub Vec<u8>);

impl TryFrom<String> for Hex {
    type Error = std::num::ParseIntError;

    fn try_from(digits: String) -> Result<Self, Self::Error> {
        (0..digits.len())
            .step_by(2)
            .map(|i| u8::from_str_radix(digits.get(i..i + 2).unwrap_or("?"), 16))
            .collect::<Result<_, _>>()
            .map(Hex)
    }
}

impl std::fmt::Debug for Hex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Reads a file of exchanges, compressed if its name ends in `gz`.
///
/// # Panics
/// With the file and line, if it cannot be read as such.
pub fn load(path: &Path) -> Vec<Exchange> {
    let shown = path.display();
    let file = std::fs::File::open(path).unwrap_or_else(|e| panic!("{shown}: {e}"));
    let mut text = String::new();
    let compressed = path.extension().is_some_and(|end| end == "gz");
    if compressed {
        GzDecoder::new(file).read_to_string(&mut text)
    } else {
        std::io::BufReader::new(file).read_to_string(&mut text)
    }
    .unwrap_or_else(|e| panic!("{shown}: {e}"));
    text.lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(i, line)| {
            serde_json::from_str(line).unwrap_or_else(|e| panic!("{shown}:{}: {e}", i + 1))
        })
        .collect()
}
