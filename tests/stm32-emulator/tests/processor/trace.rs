//! QEMU's trace of registers before each instruction, compared with those of the emulator.

use std::io::{BufRead, BufReader};
use std::ops::Range;
use std::process::{Child, Command, Stdio};

use armbridge_stm32_emulator::core::{Core, Step};

use crate::mps2::{self, Bus};

/// All that QEMU prints of the processor's state.
#[derive(Clone, PartialEq, Eq)]
pub(crate) struct State {
    pub(crate) registers: [u32; 16],
    pub(crate) xpsr: u32,
    pub(crate) singles: [u32; 32],
    pub(crate) fpscr: u32,
}

/// Bits of QEMU's `xpsr`: no IT state.
const PRINTED: u32 = !0x0600_FC00;

impl State {
    pub(crate) fn of(core: &Core) -> Self {
        Self {
            registers: std::array::from_fn(|number| core.register(number)),
            xpsr: core.xpsr(),
            singles: std::array::from_fn(|number| core.float(number)),
            fpscr: core.fpscr(),
        }
    }

    /// Difference, in words.
    fn differences(&self, other: &Self, fpscr: u32) -> Vec<String> {
        let mut list = Vec::new();
        let mut compare = |name: String, a: u32, b: u32| {
            if a != b {
                list.push(format!("{name}: {a:#010x}, QEMU {b:#010x}"));
            }
        };
        for number in 0..16 {
            let (a, b) = (self.registers[number], other.registers[number]);
            compare(format!("r{number}"), a, b);
        }
        compare("xpsr".into(), self.xpsr & PRINTED, other.xpsr & PRINTED);
        for number in 0..32 {
            let (a, b) = (self.singles[number], other.singles[number]);
            compare(format!("s{number}"), a, b);
        }
        compare("fpscr".into(), self.fpscr & fpscr, other.fpscr & fpscr);
        list
    }
}

/// The states in QEMU's log.
struct States<R> {
    lines: std::io::Lines<R>,
}

impl<R: BufRead> Iterator for States<R> {
    type Item = State;

    fn next(&mut self) -> Option<State> {
        let mut state = State {
            registers: [0; 16],
            xpsr: 0,
            singles: [0; 32],
            fpscr: 0,
        };
        for line in &mut self.lines {
            let line = line.ok()?;
            let hex = |text: &str| u32::from_str_radix(text, 16).unwrap();
            let words = line.split_whitespace();
            match line.get(..3)? {
                "R00" | "R04" | "R08" | "R12" => {
                    for word in words {
                        let number: usize = word[1..3].parse().unwrap();
                        state.registers[number] = hex(&word[4..]);
                    }
                }
                "XPS" => state.xpsr = hex(&line[5..13]),
                "FPS" => {
                    state.fpscr = hex(line.split(' ').nth(1)?);
                    return Some(state);
                }
                name if name.starts_with('s') => {
                    for word in words.take(2) {
                        let number: usize = word[1..3].parse().unwrap();
                        state.singles[number] = hex(&word[4..]);
                    }
                }
                _ => {}
            }
        }
        None
    }
}

/// A process that ends with its owner.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs both, and compares up to `limit` states at addresses in `range`, and of FPSCR the bits
/// `fpscr`: how many there were.
pub(crate) fn compare(
    mut qemu: Command,
    core: &mut Core,
    bus: &mut Bus,
    (range, limit): (&Range<u32>, usize),
    fpscr: u32,
) -> usize {
    let filter = format!("{:#x}..{:#x}", range.start, range.end - 1);
    let mut child = Running(
        qemu.args([
            "-d",
            "exec,cpu,fpu,nochain",
            "-singlestep",
            "-dfilter",
            &filter,
        ])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap(),
    );
    let lines = BufReader::with_capacity(1 << 20, child.0.stderr.take().unwrap()).lines();
    let mut compared = 0;
    let mut last = None;
    for expected in (States { lines }) {
        // It prints some instructions twice when it stops for a device.
        if last.as_ref() == Some(&expected) && core.register(15) != expected.registers[15] {
            continue;
        }
        while !range.contains(&core.register(15)) {
            let pc = expected.registers[15];
            assert!(
                step(core, bus),
                "the emulator is at its end, QEMU at {pc:#x}"
            );
        }
        let mut differences = State::of(core).differences(&expected, fpscr);
        // QEMU shows the first instruction of a handler, not the entry.
        while !differences.is_empty() && matches!(core.step(bus), Step::Entered { .. }) {
            differences = State::of(core).differences(&expected, fpscr);
        }
        if !differences.is_empty() {
            let at = last.as_ref().map_or(0, |state| state.registers[15]);
            let code = bus.bytes(at, 4);
            let code = [code[1], code[0], code[3], code[2]];
            panic!("instruction {compared} in {filter}, {code:02x?} at {at:#x}: {differences:#?}");
        }
        compared += 1;
        last = Some(expected);
        if compared == limit || !step(core, bus) {
            break;
        }
    }
    compared
}

/// Executes until the program counter is that of the next instruction; whether there is one.
fn step(core: &mut Core, bus: &mut Bus) -> bool {
    match core.step(bus) {
        Step::Breakpoint(0xAB) => mps2::semihosting(core, bus).is_none(),
        Step::Executed { .. } | Step::Entered { .. } => true,
        // Its exception is entered in the next step, and QEMU shows the handler.
        Step::Unimplemented { .. } => matches!(core.step(bus), Step::Entered { .. }),
        other => panic!("{other:?} at {:#x}", core.register(15)),
    }
}
