//! The `armbridge` program.
fn main() {}
