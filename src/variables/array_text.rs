//! Names and descriptions of the variables of FMI 3.0.

use super::arrays::{Array, Edge, Exchanged, Told};
use super::table::TABLE;

impl Array {
    /// Text of one that is no row of the table.
    pub fn description(self) -> String {
        let text = match self {
            Self::Time => "Time",
            Self::Balls => "Number of balls; a new one sets all arrays to their defaults",
            Self::DerivativesOf => "What directional and adjoint derivatives are those of, after initialization",
            Self::Slope(position) => {
                return format!("Slope of {} over the next steps, from the value it is set to", TABLE[position].name);
            }
            Self::Clock(Edge::Onset) => "Ticks when contacts close",
            Self::Clock(Edge::Release) => "Ticks when contacts open",
            Self::Told(Told::Time(_)) => "Time of the last tick",
            Self::Told(Told::Which(Edge::Onset)) => "Which contacts closed at the last tick",
            Self::Told(Told::Which(Edge::Release)) => "Which contacts opened at the last tick",
            Self::Told(Told::Impulse) => "Impulse of the pulses that ended at the last tick",
            Self::Told(Told::Peak) => "Largest force of the pulses that ended at the last tick",
            Self::Told(Told::Duration) => "Duration of the pulses that ended at the last tick",
            Self::Exchanged(Exchanged::Position) => "Position of the first ball, then the overlaps",
            Self::Exchanged(Exchanged::Rate) => "Velocity of the first ball, then the rates of the overlaps",
            Self::Exchanged(Exchanged::Contact) => "Event indicators of the contacts: negative while open",
            Self::Pulses => "The last pulses as CSV: contact, onset, release, largest force, impulse",
            Self::Exchanged(Exchanged::Clip) => "Event indicators of the laws: negative while clipped",
            Self::Row(position) => TABLE[position].description,
        };
        text.replace("{i}", "i").replace("{j}", "i+1")
    }
}

/// The name: `x`, `der(F_ext)`, `onset.clock`.
impl std::fmt::Display for Array {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let prefix = |edge: &Edge| if *edge == Edge::Onset { "onset" } else { "release" };
        match self {
            Self::Time => f.write_str("time"),
            Self::Balls => f.write_str("n"),
            Self::DerivativesOf => f.write_str("derivatives.of"),
            Self::Row(position) => f.write_str(TABLE[*position].name),
            Self::Slope(position) => write!(f, "der({})", TABLE[*position].name),
            Self::Clock(edge) => write!(f, "{}.clock", prefix(edge)),
            Self::Told(Told::Time(edge)) => write!(f, "{}.time", prefix(edge)),
            Self::Told(Told::Which(Edge::Onset)) => f.write_str("onset.closed"),
            Self::Told(Told::Which(Edge::Release)) => f.write_str("release.opened"),
            Self::Told(Told::Impulse) => f.write_str("release.impulse"),
            Self::Told(Told::Peak) => f.write_str("release.peak"),
            Self::Told(Told::Duration) => f.write_str("release.duration"),
            Self::Exchanged(Exchanged::Position) => f.write_str("q"),
            Self::Exchanged(Exchanged::Rate) => f.write_str("der(q)"),
            Self::Exchanged(Exchanged::Contact) => f.write_str("z.contact"),
            Self::Exchanged(Exchanged::Clip) => f.write_str("z.clip"),
            Self::Pulses => f.write_str("log.pulses"),
        }
    }
}
