//! What can go wrong in this program.

use newtons_cradle::variables::Refusal;

/// What went wrong, in words for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The arguments ask for something that does not exist or is not allowed.
    Usage(String),
    /// Something did not work: a file, a program, a device.
    Failure(String),
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Usage(text) | Self::Failure(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for Error {}

/// A cradle that is refused.
impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Self {
        Self::Usage(refusal.to_string())
    }
}
