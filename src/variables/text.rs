//! Text for hosts and readers: numbers that read back as the same double, and XML escapes.

use std::fmt::{self, Display, Formatter};

/// A number in the shortest form that reads back as the same double: `0.1`, `2.6e-6`, `1e10`.
pub struct Number(pub f64);

impl Display for Number {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.abs();
        if magnitude != 0.0 && magnitude.is_finite() && !(1e-3..1e5).contains(&magnitude) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}

/// The standard's name of an item: ours with its first letter in lower case.
pub(crate) fn camel(item: &impl fmt::Debug) -> String {
    let name = format!("{item:?}");
    name[..1].to_lowercase() + &name[1..]
}

/// Text that may stand in an XML attribute between double quotes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_read_back() {
        let samples =
            [0.0, -0.1, 9.81, 1.0, 1e10, 2.6e-6, 1e30, -1e30, 0.0313, 2.1e11, 1e-14, f64::MAX, 5e-324, 0.1 + 0.2];
        for value in samples {
            assert_eq!(Number(value).to_string().parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
        assert_eq!(Number(1e10).to_string(), "1e10");
        assert_eq!(Number(-0.1).to_string(), "-0.1");
        assert_eq!(Number(f64::NAN).to_string(), "NaN");
    }

    #[test]
    fn markup_is_escaped() {
        assert_eq!(escaped(r#"a<b & "c">d"#), "a&lt;b &amp; &quot;c&quot;&gt;d");
    }
}
