//! The versions of FMI.

/// The version of the standard that an FMU follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Standard {
    /// FMI 2.0.
    #[default]
    Fmi2,
    /// FMI 3.0.
    Fmi3 {
        /// Whether it has clocks; some hosts take none.
        clocks: bool,
    },
}
