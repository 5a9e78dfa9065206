//! Hosts on links: requests in order, settings as a group; a host that leaves, fails or
//! does not read, several on one link, and a cable that is unplugged.

mod exchange;
mod hosts;
mod session;
mod shared;
mod unplugged;
