//! Control of a two-joint arm: dynamics, estimators, controllers, trajectories, gain design.
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
//! Angles in rad, speeds in rad/s, torques in N m.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod actuator;
pub mod arm;
pub mod check_word;
pub mod controller;
pub mod design;
pub mod estimate;
pub mod experiment;
pub mod real;
pub mod trajectory;
mod trig;

pub use armbridge_servo::JOINTS;
