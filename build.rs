//! Fills what Cargo knows into `modelDescription.xml.in` and `modelDescription.fmi3.xml.in`. The library fills in the
//! rest at run time, because it depends on the number of balls and the start values. Keeps the time of linking out of
//! binaries for Windows.

use std::collections::BTreeSet;
use std::path::Path;
use std::{env, fs};

/// The templates, without their `.in`, and their placeholders: those that Cargo does not know are left for the library,
/// see `src/variables/description/xml.rs`.
const TEMPLATES: [(&str, &str); 2] = [
    (
        "modelDescription.xml",
        "version authors license description model guid date start_time stop_time step_size indicators units types log_categories \
         variables structure",
    ),
    (
        "modelDescription.fmi3.xml",
        "version authors license model guid date start_time stop_time step_size units types log_categories variables structure",
    ),
];

/// Placeholders filled in here, and the Cargo variable they stand for.
const FROM_CARGO: [(&str, &str); 4] = [
    ("version", "CARGO_PKG_VERSION"),
    ("authors", "CARGO_PKG_AUTHORS"),
    ("license", "CARGO_PKG_LICENSE"),
    ("description", "CARGO_PKG_DESCRIPTION"),
];

fn main() {
    let target = |what: &str| env::var(format!("CARGO_CFG_TARGET_{what}")).expect("Cargo sets it");
    if target("OS") == "windows" {
        // The same sources give the same bytes.
        let flag = if target("ENV") == "gnu" { "-Wl,--no-insert-timestamp" } else { "/Brepro" };
        println!("cargo::rustc-cdylib-link-arg={flag}");
    }
    for (name, keys) in TEMPLATES {
        let path = format!("{name}.in");
        println!("cargo::rerun-if-changed={path}");
        let template = fs::read_to_string(&path).unwrap_or_else(|error| panic!("cannot read {path}: {error}"));
        // The GUID is a hash of this text: a checkout with other line ends must not change it.
        let filled = fill(&path, keys, &template.replace("\r\n", "\n"));
        let out = Path::new(&env::var("OUT_DIR").expect("Cargo sets OUT_DIR")).join(name);
        fs::write(&out, filled).unwrap_or_else(|error| panic!("cannot write {}: {error}", out.display()));
    }
}

/// Replaces every placeholder that Cargo knows; panics on one that nobody knows and on one that is missing.
fn fill(path: &str, keys: &str, template: &str) -> String {
    let keys: BTreeSet<&str> = keys.split_whitespace().collect();
    let mut missing = keys.clone();
    let mut pieces = template.split("{{");
    let mut filled = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (key, rest) = piece.split_once("}}").unwrap_or_else(|| panic!("{path}: \"{{{{{piece}\" is not closed"));
        missing.remove(key);
        if let Some((_, variable)) = FROM_CARGO.iter().find(|(known, _)| *known == key) {
            let value = env::var(variable).unwrap_or_default();
            assert!(!value.is_empty(), "{path}: {{{{{key}}}}} needs {variable}, which Cargo.toml does not give");
            // Cargo separates authors by colons.
            let value = if key == "authors" { value.replace(':', ", ") } else { value };
            filled.push_str(&escape(&value));
        } else if keys.contains(key) {
            filled.push_str(&format!("{{{{{key}}}}}"));
        } else {
            panic!("{path}: nobody knows {{{{{key}}}}}");
        }
        filled.push_str(rest);
    }
    assert!(missing.is_empty(), "{path}: missing placeholders: {missing:?}");
    filled
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
