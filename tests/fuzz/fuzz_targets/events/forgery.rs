//! Saved states that nobody wrote: bytes of a state with changes, and the digest that belongs to them.

use arbitrary::Arbitrary;
use uuid::Uuid;

/// What the bytes begin and end with.
const HEADER: usize = 12;
const DIGEST: usize = 16;

/// A change of the bytes from the place `at` on.
#[derive(Debug, Arbitrary)]
pub enum Change {
    Replace { at: u16, by: Vec<u8> },
    Number { at: u16, by: Special },
    Insert { at: u16, bytes: Vec<u8> },
    Remove { at: u16, count: u8 },
    Copy { at: u16, from: u16, count: u8 },
}

/// Numbers at which comparisons go wrong.
#[derive(Debug, Arbitrary)]
pub enum Special {
    Nan,
    Infinite,
    MinusInfinite,
    MinusZero,
    Negative(u8),
    Large,
    Small,
    Any(f64),
}

/// The bytes of `state` with these changes, closed by their digest.
pub fn forged(state: &[u8], changes: &[Change]) -> Vec<u8> {
    let mut content = state[HEADER..state.len() - DIGEST].to_vec();
    changes.iter().for_each(|change| change.make(&mut content));
    let mut bytes = [&state[..HEADER], &content].concat();
    let digest = Uuid::new_v5(&Uuid::NAMESPACE_OID, &bytes);
    bytes.extend(digest.as_bytes());
    bytes
}

impl Change {
    fn make(&self, bytes: &mut Vec<u8>) {
        let length = bytes.len();
        let within = |at: u16| usize::from(at) % (length + 1);
        match self {
            Self::Replace { at, by } => overwrite(bytes, within(*at), by),
            Self::Number { at, by } => overwrite(bytes, within(*at), &by.number().to_le_bytes()),
            Self::Insert { at, bytes: inserted } => {
                let at = within(*at);
                bytes.splice(at..at, inserted.iter().copied());
            }
            Self::Remove { at, count } => {
                let at = within(*at);
                bytes.drain(at..(at + usize::from(*count)).min(length));
            }
            Self::Copy { at, from, count } => {
                let from = within(*from);
                let copied = bytes[from..(from + usize::from(*count)).min(length)].to_vec();
                overwrite(bytes, within(*at), &copied);
            }
        }
    }
}

fn overwrite(bytes: &mut [u8], at: usize, by: &[u8]) {
    bytes[at..].iter_mut().zip(by).for_each(|(byte, new)| *byte = *new);
}

impl Special {
    fn number(&self) -> f64 {
        match self {
            Self::Nan => f64::NAN,
            Self::Infinite => f64::INFINITY,
            Self::MinusInfinite => f64::NEG_INFINITY,
            Self::MinusZero => -0.0,
            Self::Negative(size) => -f64::from(*size),
            Self::Large => f64::MAX,
            Self::Small => f64::MIN_POSITIVE,
            Self::Any(number) => *number,
        }
    }
}
