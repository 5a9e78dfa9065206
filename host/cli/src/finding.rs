//! Finding of a check: present, not checkable, missing or stale, and then with its remedy.

/// Result of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Finding {
    /// It is there.
    Ok(String),
    /// It cannot be checked, or there is nothing to check.
    Open(String),
    /// It is missing.
    Missing {
        /// Its name.
        what: String,
        /// Command or action that adds it.
        remedy: String,
    },
    /// It is there, but out of date.
    Stale {
        /// Reason.
        what: String,
        /// Command that renews it.
        remedy: String,
    },
}

impl Finding {
    /// Something is missing.
    pub fn missing(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        let (what, remedy) = (what.into(), remedy.into());
        Self::Missing { what, remedy }
    }

    /// State, text and remedy.
    pub fn parts(&self) -> (&'static str, &str, Option<&str>) {
        match self {
            Self::Ok(found) => ("ok", found, None),
            Self::Open(why) => ("n/a", why, None),
            Self::Missing { what, remedy } => ("missing", what, Some(remedy)),
            Self::Stale { what, remedy } => ("stale", what, Some(remedy)),
        }
    }
}
