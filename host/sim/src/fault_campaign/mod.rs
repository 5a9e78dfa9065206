//! The fault campaign: thousands of runs on the bench in which something goes
//! wrong, singly and in pairs, and what the board makes of it.
//!
//! A case follows from its seed alone, so one that fails can be told again to the
//! bit. What is required of every case:
//!
//! * nothing panics and nothing hangs;
//! * no PWM beyond the limits on the wire, or at a motor while packets arrive as
//!   they were sent;
//! * in a mode that does not drive the motors none is on for longer than [`STOP_US`]
//!   without a break, not counting time in which a servo cannot be reached: the line
//!   is stuck, the servo hears nothing, more than one byte in a hundred comes to harm
//!   on the way, or a damaged order has sent the servo's firmware into a long
//!   operation (it writes registers for a third of a second then). On a line that
//!   goes on doing harm a damaged packet may switch a motor on again, until the next
//!   tick says off;
//! * a fault is called what it is: [`expect`] says what that may be, and
//!   [`NAMED_RIGHT`] of all singles must be;
//! * when everything is mended and the fault cleared, the board comes back.
//!
//! | module     | what                                              |
//! |------------|---------------------------------------------------|
//! | [`Kind`]   | what can be injected                              |
//! | [`Case`]   | what follows from a seed                          |
//! | [`expect`] | what each fault may rightly be called             |
//! | `driver`   | the host of a case                                |
//! | `fixture`    | how a fault is done to board, bench and host      |
//! | `watch`    | reads along what the board sends                  |
//! | `oracle`    | runs a case and judges it                         |
//! | `trace`    | tells it                                          |
//! | [`Report`] | sums a campaign up                                |

mod case;
mod draw;
mod driver;
pub mod expect;
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
pub use kind::{Harm, Kind, NoKind};
pub use oracle::STOP_US;
pub use outcome::Outcome;
pub use report::{Failure, NAMED_RIGHT, Report, Row};
pub use run::{overhear, run, run_with_story};
pub use table::table;
