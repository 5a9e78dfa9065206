//! Torque off, on the whole bench: for each party that drives the motors and each
//! failure, they are off in time and stay off.
//!
//! | module        | motors that must be off                                     |
//! |---------------|-------------------------------------------------------------|
//! | `passthrough` | those of a client of the transparent port, after a stop     |
//! | `silence`     | those of a client that hangs                                |
//! | `outages`     | stock servos whose wire was cut                             |
//! | `sessions`    | those that another session drove, after a hello or goodbye  |
//! | `arming`      | those of an arm that the samples do not show well enough    |
//! | `age`         | those whose command is old, though the host is alive        |
//! | `clearing`    | those of a host that stops and clears in one write          |
//! | `resets`      | those of an arm of which a stock servo was reset            |
//! | `foreign_master` | those that another master on the bus sets on             |
//! | `limits`      | those of an arm beyond its angles or temperatures           |
//! | `memory`      | all, when a bit of state or drive command has turned        |
//!
//! The rig, its two users and the scenarios that the emulated board shares are in
//! `armbridge_tests::torque_off`. A motor is judged by the duty that the virtual servo
//! gives it.

mod age;
mod arming;
mod clearing;
mod encoders;
mod foreign_master;
mod limits;
mod memory;
mod outages;
mod passthrough;
mod resets;
mod sessions;
mod silence;
