//! Hosts on a link to the bench: requests in order, settings as a group.

mod exchange;
mod station;
