//! Fills what Cargo knows into `modelDescription.xml.in`. The library fills in the rest at run time, because it
//! depends on the number of balls and the start values. Keeps the time of linking out of binaries for Windows.

use std::collections::BTreeSet;
use std::path::Path;
use std::{env, fs};

const TEMPLATE: &str = "modelDescription.xml.in";

/// Placeholders filled in here, and the Cargo variable they stand for.
const FROM_CARGO: [(&str, &str); 4] = [
    ("version", "CARGO_PKG_VERSION"),
    ("authors", "CARGO_PKG_AUTHORS"),
    ("license", "CARGO_PKG_LICENSE"),
    ("description", "CARGO_PKG_DESCRIPTION"),
];

/// Placeholders left for the library, see `src/variables/description/xml.rs`.
const AT_RUN_TIME: &str =
    "model guid date start_time stop_time step_size indicators units types log_categories variables structure";

fn main() {
    println!("cargo::rerun-if-changed={TEMPLATE}");
    let target = |what: &str| env::var(format!("CARGO_CFG_TARGET_{what}")).expect("Cargo sets it");
    if target("OS") == "windows" {
        // The same sources give the same bytes.
        let flag = if target("ENV") == "gnu" { "-Wl,--no-insert-timestamp" } else { "/Brepro" };
        println!("cargo::rustc-cdylib-link-arg={flag}");
    }
    let template = fs::read_to_string(TEMPLATE).unwrap_or_else(|error| panic!("cannot read {TEMPLATE}: {error}"));
    // The GUID is a hash of this text: a checkout with other line ends must not change it.
    let filled = fill(&template.replace("\r\n", "\n"));
    let out = Path::new(&env::var("OUT_DIR").expect("Cargo sets OUT_DIR")).join("modelDescription.xml");
    fs::write(&out, filled).unwrap_or_else(|error| panic!("cannot write {}: {error}", out.display()));
}

/// Replaces every placeholder that Cargo knows; panics on one that nobody knows and on one that is missing.
fn fill(template: &str) -> String {
    let at_run_time: BTreeSet<&str> = AT_RUN_TIME.split_whitespace().collect();
    let mut missing: BTreeSet<&str> = FROM_CARGO.iter().map(|(key, _)| *key).chain(at_run_time.clone()).collect();
    let mut pieces = template.split("{{");
    let mut filled = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (key, rest) = piece.split_once("}}").unwrap_or_else(|| panic!("{TEMPLATE}: \"{{{{{piece}\" is not closed"));
        missing.remove(key);
        if let Some((_, variable)) = FROM_CARGO.iter().find(|(known, _)| *known == key) {
            let value = env::var(variable).unwrap_or_default();
            assert!(!value.is_empty(), "{TEMPLATE}: {{{{{key}}}}} needs {variable}, which Cargo.toml does not give");
            // Cargo separates authors by colons.
            let value = if key == "authors" { value.replace(':', ", ") } else { value };
            filled.push_str(&escape(&value));
        } else if at_run_time.contains(key) {
            filled.push_str(&format!("{{{{{key}}}}}"));
        } else {
            panic!("{TEMPLATE}: nobody knows {{{{{key}}}}}");
        }
        filled.push_str(rest);
    }
    assert!(missing.is_empty(), "{TEMPLATE}: missing placeholders: {missing:?}");
    filled
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
