//! Native part of the Python package `armbridge`: a binding of the crates beside it, without logic
//! of its own.
//!
//! | module      | contents                                                        |
//! |-------------|-----------------------------------------------------------------|
//! | `errors`    | exceptions by kind, each with the sentence of the host tool      |
//! | `arguments` | arguments from Python, checked                                   |
//! | `connection` | a session and its log, shared by the objects that use it        |
//! | `board`     | a board: commands, states and their contexts                     |
//! | `motion`    | a motion under way                                               |
//! | `periodic`  | streams and torques at a fixed rate                              |
//! | `telemetry` | blocks of ticks as they arrive                                   |
//! | `block`     | ticks as arrays                                                  |
//! | `log`       | logs as arrays, and their replay                                 |
//! | `settings`  | parameters of the board as Python values                         |
//! | `status`    | the board's status                                               |
//! | `model`     | equations of motion of the arm                                   |
//! | `plant`      | virtual arms                                                     |
//! | `environment` | environments for learned controllers                            |
//! | `design`     | gains, poles and margins                                         |
//! | `bench`      | scenarios on the simulated board                                 |
//! | `campaign`   | fault campaigns                                                  |
//! | `identify`   | arms identified from logs or on a board                          |
//! | `interrupt`  | long computations that a signal interrupts                       |
//!
//! The interpreter's lock is released wherever a call waits or works for long.

// An error is formatted where it becomes an exception, and what Python passes is owned.
#![expect(clippy::needless_pass_by_value, reason = "signatures of Python")]

mod arguments;
mod bench;
mod block;
mod board;
mod campaign;
mod connection;
mod design;
mod environment;
mod errors;
mod identify;
mod interrupt;
mod log;
mod model;
mod motion;
mod periodic;
mod plant;
mod settings;
mod status;
mod telemetry;

use pyo3::prelude::*;

#[pymodule(gil_used = false)]
mod _native {
    #[pymodule_export]
    use crate::bench::bench;
    #[pymodule_export]
    use crate::block::Block;
    #[pymodule_export]
    use crate::board::{Armed, Board, connect};
    #[pymodule_export]
    use crate::campaign::{Campaign, campaign_part};
    #[pymodule_export]
    use crate::design::{Design, computed_torque, lqr, place};
    #[pymodule_export]
    use crate::environment::{PyEnvironment, PyEnvironments};
    #[pymodule_export]
    use crate::errors::{
        ArmbridgeError, ClosedError, DroppedError, FaultError, IdentifyError, LinkError, LogError,
        ObserverError, RefusedError,
    };
    #[pymodule_export]
    use crate::identify::{Fit, identify};
    #[pymodule_export]
    use crate::log::{Log, Replay};
    #[pymodule_export]
    use crate::model::Arm;
    #[pymodule_export]
    use crate::motion::Motion;
    #[pymodule_export]
    use crate::periodic::{Stream, Ticks, Torque};
    #[pymodule_export]
    use crate::plant::Plant;
    #[pymodule_export]
    use crate::status::Status;
    #[pymodule_export]
    use crate::telemetry::Telemetry;

    use pyo3::prelude::*;

    /// Has every connection closed when the interpreter ends.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let close_all = wrap_pyfunction!(crate::connection::close_all, module)?;
        let atexit = module.py().import("atexit")?;
        atexit.call_method1("register", (close_all,)).map(|_| ())
    }
}
