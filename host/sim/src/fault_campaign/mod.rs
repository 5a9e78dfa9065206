//! Fault campaign: thousands of runs on the bench with injected faults, singly and in
//! pairs, and the board's reactions.
//!
//! A case depends only on its seed: a failing one can be repeated to the bit. It is drawn
//! over servo firmware, speed of the bus, period, estimator and controller ([`SetUp`]), over
//! the board's work ([`Activity`]), which may be [given](Case::with_activity) instead, and over
//! the time of the fault, from power-up to seconds later. Requirements on every case:
//!
//! * no panic, and no hang;
//! * no PWM beyond the limits on the wire, or at a motor while packets arrive intact;
//! * in a state that does not permit it, no motor is on for longer than [`Case::stop_us`]
//!   without a break, not counting time in which a servo cannot be reached: the line
//!   is stuck, the servo receives nothing, more than one byte in a hundred is damaged,
//!   or a damaged packet has started a long operation of the servo's firmware (it writes
//!   registers for a third of a second then). A client of the transparent port that has the
//!   bus is permitted to drive until it is silent. While a line keeps damaging bytes, or has
//!   a second master, a packet may switch a motor on again, until the next tick switches
//!   it off;
//! * the true arm is not driven or pressed against the table or a stop, nor thrown against it, nor
//!   driven far from its reference or, by the motor check, from where it was; one that floats
//!   stays where it is (`truth`);
//! * no motor is on that the board reports as off (`off_report`), and its output for a relay
//!   cuts the servos' supply whenever it must, and only then (`supply`);
//! * a goodbye or a hello ends the session that armed;
//! * the fault is the expected one: `expect` has the table, and [`EXPECTED_SHARE_MIN`] of all
//!   singles must match it. No fault is right only where the true arm has come to no harm;
//! * when all faults are removed and the fault is cleared, the board is idle again.
//!
//! Kinds that boards do not detect yet, or not in every set-up, are in `expect::is_guarded`; what
//! they violate fails a campaign as well, but is counted apart.
//!
//! | module     | contents                                          |
//! |------------|---------------------------------------------------|
//! | [`Kind`]   | kinds of injected faults                          |
//! | [`Injection`] | a fault with its time and magnitude            |
//! | [`SetUp`]  | bus, period, estimator, controller                |
//! | [`Activity`] | the board's work                                |
//! | [`Case`]   | the case that follows from a seed                 |
//! | `expect`, `requirement` | expected faults of each kind, and whether there must be one |
//! | `driver`, `stream_path`, `invalid_commands`, `client`, `second_master` | host, client of the transparent port, another master |
//! | `fixture`, `inject` | board, bench and host, and the injection of a fault |
//! | `lead`     | a hand that leads an arm that floats              |
//! | `reach`    | times in which servos cannot be reached           |
//! | `watch`    | monitors the bytes that the board sends           |
//! | `oracle`, `truth` | run a case, check the requirements, and those on the true arm |
//! | `off_report`, `supply`, `park` | judges of what the board reports, of its output for a relay, and of parks |
//! | `trace`    | the case as text                                  |
//! | [`Campaign`] | cases run apart, as one                         |
//! | [`Report`] | a campaign in numbers                             |

mod activity;
mod case;
mod client;
mod draw;
mod driver;
mod expect;
mod fixture;
mod inject;
mod injection;
mod invalid_commands;
mod kind;
mod lead;
mod merge;
mod off_report;
mod oracle;
mod outcome;
mod park;
mod reach;
mod report;
mod requirement;
mod run;
mod second_master;
mod set_up;
mod stream_path;
mod supply;
mod table;
mod trace;
mod truth;
mod watch;

pub use activity::{Activity, UnknownActivity};
pub use case::Case;
pub use expect::STOP_US;
pub use injection::{Injection, Origin};
pub use kind::{DamageKind, Kind, UnknownKind};
pub use merge::{Campaign, MergeError};
pub use outcome::Outcome;
pub use report::{EXPECTED_SHARE_MIN, Failure, Report, Row};
pub use run::{run, run_with_events, run_with_trace};
pub use set_up::{Bus, Control, SetUp};
pub use table::table;
