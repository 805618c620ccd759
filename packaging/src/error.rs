//! The errors of this program.

use newtons_cradle::variables::Refusal;

/// An error, in words for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The arguments ask for something that does not exist or is not allowed.
    Usage(String),
    /// A file, a program or a device failed.
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

/// A refused cradle is an error in the arguments.
impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Self {
        Self::Usage(refusal.to_string())
    }
}
