//! Examples of commands that have no file of their own here.

pub(super) const DEMO: &str = "\
Examples:
  armbridge demo
  armbridge demo --compensate --duration 20
  armbridge demo --no-friction --firmware stock --json

Writes the log and the plots of the run into a new folder in runs/.";

pub(super) const EMULATE: &str = "\
Examples:
  armbridge emulate
  armbridge emulate --compensate --icount
  armbridge emulate --link-listen tcp://127.0.0.1:7001
  armbridge emulate --bus tcp://127.0.0.1:7000 --slow 50

Needs QEMU and the image that `cargo build-emulator` makes.";

pub(super) const SERVOS: &str = "\
Examples:
  armbridge servos --listen tcp://127.0.0.1:7000
  armbridge servos --pty --echo
  armbridge scan --port tcp://127.0.0.1:7000";

pub(super) const PAPER: &str = "\
Examples:
  armbridge paper
  armbridge paper --out reports --json";
