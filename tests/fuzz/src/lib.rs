//! Fuzz targets' checks: properties of parsers and of the settings store for any input.
//!
//! Each module has a function `check` that takes any bytes at all and panics if
//! something is wrong; more than the absence of panics is asserted. Its
//! count shows how far the input got.
//!
//! | module               | fed                                | what must hold          |
//! |----------------------|------------------------------------|-------------------------|
//! | [`transparent_port`] | the transparent port's framer, and the policy for its packets | bytes come out once, in order, cut where packets end; nothing that harms goes on the bus, and nothing that takes longer than there is time |
//! | [`protocol1`]        | the parser of stock servos' packets, in four sizes, and what its packets mean | intact packets are found, exactly, and nothing else; the longest packet's worth of zeros brings it back into step |
//! | [`protocol2`]        | the parser of the X series' packets, in three sizes, and what its packets mean | the same |
//! | [`morpheus`]         | the parser of Morpheus packets, in four sizes, to any address and to one | the same, with 0xFF |
//! | [`link`]             | the decoder of the link's frames, either direction; and its messages, in intact frames | only a zero ends a frame, and brings it back into step; what is decoded encodes to the same bytes |
//! | [`master`]           | the bus master, whose port answers by the input | a transaction ends; it sends what it should and accepts no reply that was not received |
//! | [`store`]            | settings in flash: saves, boots, power cuts and damage | what is in force was saved, and only damage loses it; a save never erases, and has the room that was made for it |
//!
//! Used twice: by the fuzz targets, which look for new paths through the code,
//! and by `tests/src/streams`, which feeds streams to each parser, ten million in the
//! campaign.

pub mod frames;
pub mod link;
pub mod master;
pub mod morpheus;
mod packets;
pub mod protocol1;
pub mod protocol2;
pub mod store;
pub mod transparent_port;
