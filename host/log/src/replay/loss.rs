//! Reasons for which inputs of the board are not known.

/// Reason for which inputs of the board are not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Loss {
    NoHello,
    Frames,
    Disconnection,
    Restart,
    NoSession,
    BeforeHello,
    OtherHost,
    Dropped,
    Records,
}

impl Loss {
    /// As text.
    pub(super) const fn text(self) -> &'static str {
        match self {
            Self::NoHello => "the log begins without a hello",
            Self::Frames => "frames of the board were lost on the link",
            Self::Disconnection => "the connection broke",
            Self::Restart => "the board restarted",
            Self::NoSession => "the board had no session",
            Self::BeforeHello => "the time before the hello is not in the log",
            Self::OtherHost => "a command of another host is not in the log",
            Self::Dropped => "the board dropped records that the host did not fetch",
            Self::Records => "records are missing in the log",
        }
    }
}
