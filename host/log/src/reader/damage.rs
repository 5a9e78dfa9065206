//! Damage of a log, in sentences.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::Reader;

impl Reader {
    pub(super) fn end_with(&mut self, how: &str) {
        self.is_over = true;
        let after = self.after_tick();
        self.damage
            .push(format!("the log {how}; what came {after} is missing"));
    }

    pub(super) fn after_tick(&self) -> String {
        self.last_tick.map_or_else(
            || "after its beginning".into(),
            |tick| format!("after tick {tick}"),
        )
    }

    pub(super) fn report_unlisted(&mut self) {
        if self.unlisted > 0 {
            let more = std::mem::take(&mut self.unlisted);
            self.damage
                .push(format!("{more} more chunks were left out"));
        }
        if self.unreadable > 0 {
            self.damage.push(format!(
                "{} messages are damaged or of another version and were left out",
                self.unreadable
            ));
            self.unreadable = 0;
        }
    }
}

/// Whether a file ends with the magic of MCAP: its index is complete.
pub(super) fn is_closed(path: &Path) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let mut end = [0; mcap::MAGIC.len()];
    file.seek(SeekFrom::End(-(end.len() as i64)))?;
    file.read_exact(&mut end)?;
    Ok(end == mcap::MAGIC)
}
