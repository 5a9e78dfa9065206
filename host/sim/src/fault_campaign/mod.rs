//! Fault campaign: thousands of runs on the bench with injected faults, singly and in
//! pairs, and the board's reactions.
//!
//! A case depends only on its seed: a failing one can be repeated to the bit.
//! Requirements on every case:
//!
//! * no panic, and no hang;
//! * no PWM beyond the limits on the wire, or at a motor while packets arrive intact;
//! * in a mode that does not drive the motors, none is on for longer than [`STOP_US`]
//!   without a break, not counting time in which a servo cannot be reached: the line
//!   is stuck, the servo receives nothing, more than one byte in a hundred is damaged,
//!   or a damaged packet has started a long operation of the servo's firmware (it writes
//!   registers for a third of a second then). While a line keeps damaging bytes, a damaged
//!   packet may switch a motor on again, until the next tick switches it off;
//! * the fault is the expected one: `expect` has the table, and [`EXPECTED_SHARE_MIN`] of all
//!   singles must match it;
//! * when all faults are removed and the fault is cleared, the board is idle again.
//!
//! | module     | contents                                          |
//! |------------|---------------------------------------------------|
//! | [`Kind`]   | kinds of injected faults                          |
//! | [`Case`]   | the case that follows from a seed                 |
//! | `expect`   | expected faults of each kind                      |
//! | `driver`   | the host of a case                                |
//! | `fixture`  | injects a fault into board, bench and host        |
//! | `watch`    | monitors the bytes that the board sends           |
//! | `oracle`   | runs a case and checks the requirements           |
//! | `trace`    | the case as text                                  |
//! | [`Report`] | a campaign in numbers                             |

mod case;
mod draw;
mod driver;
mod expect;
mod fixture;
mod kind;
mod oracle;
mod outcome;
mod report;
mod run;
mod table;
mod trace;
mod watch;

pub use case::{Case, Injection, Scenario};
pub use expect::STOP_US;
pub use kind::{DamageKind, Kind, UnknownKind};
pub use outcome::Outcome;
pub use report::{EXPECTED_SHARE_MIN, Failure, Report, Row};
pub use run::{run, run_with_events, run_with_trace};
pub use table::table;
