#![no_std]
//! Placeholder while the house is raised.
