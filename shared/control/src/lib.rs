//! Control of a two-joint arm: dynamics, estimators, controllers, trajectories, gain design.
//!
//! The crate is for control loops on microcontrollers, and for programs that design, simulate
//! or replay them: all of it is generic over [`Real`](real::Real), `f32` in the loop and `f64`
//! in the design. The arm is inverted and unstable: link 1 turns about x on the table, link 2
//! about y of link 1, and each joint has an AX-12A servo that takes a PWM and reports an angle.
//!
//! ```
//! use armbridge_control::arm::{Parameters, State};
//! use armbridge_control::controller::{Lqr, Setpoint, Weights};
//! use nalgebra::Vector2;
//!
//! let arm = Parameters::<f64>::paper();
//! let model = arm.linearise(Vector2::zeros()).zero_order_hold(1e-3);
//! let lqr = Lqr::design(&model, &Weights::paper()).unwrap();
//! let setpoint = Setpoint::new(&arm, Vector2::new(0.3, -0.25));
//!
//! let mut state = State::at_rest(Vector2::zeros());
//! for _ in 0..5_000 {
//!     let ddq = arm.acceleration(&state, lqr.torque(&state, &setpoint));
//!     state.dq += ddq * 1e-3;
//!     state.q += state.dq * 1e-3;
//! }
//! assert!((state.q - setpoint.q()).amax() < 1e-3, "{}", state.q);
//! ```
//!
//! # Modules
//!
//! | module         | content                                              |
//! |----------------|------------------------------------------------------|
//! | [`arm`]        | parameters, dynamics, linearisation, discretisation  |
//! | [`estimate`]   | the arm's state, and what pushes it, from angle samples |
//! | [`controller`] | torque from state and reference                      |
//! | [`trajectory`] | references: motions within bounds                    |
//! | [`design`]     | gains from models: Riccati, pole placement, stability |
//! | [`experiment`] | signals that drive the arm to be identified          |
//! | [`actuator`]   | counts to radians, torque to PWM, per joint          |
//! | [`real`]       | the number type the mathematics is written over      |
//! | [`check_word`] | check words of numbers in memory                     |
//!
//! `examples/pendulum.rs` closes a loop of Kalman filter, LQR and quantised servos.
//!
//! # Units and conventions
//!
//! Angles in rad, speeds in rad/s, torques in N m, times in s; a name carries its unit where it
//! is another. At q = 0 both links point straight up, and that equilibrium is unstable;
//! [`arm::Mounting`] is for an arm that hangs. Vectors and matrices are nalgebra's: a state is
//! x = [q1, q2, dq1, dq2]. Discrete poles are in z.
//!
//! Equation numbers in parentheses are those of *Detailed description of a two joint robot
//! arm*, from which the default arm ([`Parameters::paper`](arm::Parameters::paper)) is taken;
//! [`arm`] lists where the equations differ from the printed ones.
//!
//! # Contract
//!
//! The crate is `no_std`, allocates nothing and has no `unsafe`. Functions depend on their
//! arguments alone: no clock, no global state. Design (`build`, `new`, `plan`, `design`) may
//! iterate, and returns an error for numbers with which there is no stable result; what runs in
//! a tick (`correct`, `advance`, `torque`, `at`) takes a bounded time and returns no error: of a
//! NaN it makes a NaN, which the [`actuator`] refuses. Neither can panic in `f32`, as a board
//! calls it: Armbridge links this code into a firmware image in which a reachable panic is an
//! error of the linker.
//!
//! Equal inputs give equal bits on a Cortex-M4F and on a PC, see [`real`].
//!
//! # Features
//!
//! | feature    | effect                                                              |
//! |------------|---------------------------------------------------------------------|
//! | `postcard` | parameters, tunings and signals can be parts of postcard messages   |
//!
//! None is on by default.
//!
//! # Versions
//!
//! Below 1.0 a breaking change raises the minor number. Rust 1.89 or later is required.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod actuator;
pub mod arm;
pub mod check_word;
pub mod controller;
pub mod design;
pub mod encoder;
pub mod estimate;
pub mod experiment;
pub mod real;
#[cfg(feature = "snapshot")]
pub mod snapshot;
pub mod trajectory;
mod trig;

pub use armbridge_servo::JOINTS;
