//! Integrity of the configuration: comparison of its sections with their check words, in turn.

use crate::tick::{CHECK_US, LoopConfig};

/// The comparison that is due next.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct IntegrityCheck {
    section: u32,
    /// Ticks until then.
    wait: u32,
}

impl IntegrityCheck {
    /// Compares the sections that are due in this tick, so that all are compared within
    /// [`CHECK_US`]. Whether they are as they were built.
    pub(super) fn tick(&mut self, config: &LoopConfig) -> bool {
        const { assert!(CHECK_US < 10_000) };
        if let Some(wait) = self.wait.checked_sub(1) {
            self.wait = wait;
            return true;
        }
        let (sections, ticks) = config.check_pace();
        self.wait = ticks - 1;
        (0..sections).all(|_| {
            self.section = self.section.wrapping_add(1);
            config.check_section(self.section)
        })
    }
}
