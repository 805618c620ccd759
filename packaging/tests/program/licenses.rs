//! The licences that travel in every FMU, and with the program, are those of what is linked into them, packages within
//! the standard library among it. After a change of dependencies,
//! `CRADLE_RENEW=1 cargo test --package cradle-packaging licences` writes them anew.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::{env, fs};

use serde_json::Value;

use super::support::library_path;

const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");

/// Package, file, and what the file says first.
const FILES: [(&str, &str, &str); 2] = [
    ("newtons-cradle", "third-party.txt", "The binaries of this FMU hold"),
    ("cradle-packaging", "third-party-program.txt", "The program cradle-fmu holds"),
];

const HEADING: &str = " code of the packages below, and of the Rust standard library
(https://www.rust-lang.org, MIT OR Apache-2.0). The texts of their licences follow.
";

/// What lists the packages within the standard library.
const STD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/std/Cargo.toml");

#[test]
fn licences_are_those_of_what_is_linked_in() {
    for (package, name, what) in FILES {
        let wanted = format!("{what}{HEADING}{}", texts(package));
        let file = format!("{ASSETS}/{name}");
        if env::var_os("CRADLE_RENEW").is_some() {
            fs::write(&file, &wanted).unwrap();
        }
        let is = fs::read_to_string(&file).unwrap();
        assert!(is == wanted, "{name} is out of date: run this test with CRADLE_RENEW=1");
    }
}

fn texts(package: &str) -> String {
    let mut list = String::new();
    let mut licenses: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in linked(package) {
        let [name, version, license] = ["name", "version", "license"].map(|key| package[key].as_str().unwrap());
        let place = package["repository"].as_str().unwrap_or_default();
        writeln!(list, "{name} {version}, {license}, {place}").unwrap();
        let folder = Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap();
        let mut texts = license_texts(folder);
        if texts.is_empty() {
            // Some archives lack the text. Ours of the Apache License is the general one.
            assert!(license.contains("Apache-2.0"), "{name} has no text of its licence, {license}");
            texts.push(include_str!("../../../LICENSE-APACHE").to_owned());
        }
        for text in texts {
            licenses.entry(text).or_default().insert(format!("{name} {version}"));
        }
    }
    let mut all = format!("\n{list}");
    for (text, packages) in licenses {
        let packages: Vec<String> = packages.into_iter().collect();
        write!(all, "\n==== {}\n\n{}\n", packages.join(", "), text.trim_end()).unwrap();
    }
    all
}

/// The packages of others that one of ours is made of on any platform, in the order of their names: no build scripts,
/// no procedural macros.
fn linked(package: &str) -> Vec<Value> {
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let mut linked = packages(own, &["--package", package, "--edges", "normal,no-proc-macro", "--target", "all"]);
    linked.extend(packages(STD, &["--depth", "1"]));
    linked.sort_by_key(|package| [&package["name"], &package["version"]].map(Value::to_string));
    linked.dedup();
    linked
}

/// The packages of others that `cargo tree` with these options shows.
fn packages(manifest: &str, options: &[&str]) -> Vec<Value> {
    let place = ["--locked", "--manifest-path", manifest];
    let tree = output("cargo", &[&["tree", "--prefix", "none", "--format", "{p}"], &place[..], options].concat());
    let tree = String::from_utf8(tree).unwrap();
    // Lines such as "serde v1.0.0" or, once more, "serde v1.0.0 (*)".
    let names: BTreeSet<Vec<&str>> = tree.lines().map(|line| line.split_whitespace().take(2).collect()).collect();
    let metadata = output("cargo", &[&["metadata", "--format-version", "1"], &place[..]].concat());
    let mut metadata: Value = serde_json::from_slice(&metadata).unwrap();
    let mut packages = metadata["packages"].as_array_mut().unwrap().split_off(0);
    packages.retain(|package| {
        let [name, version] = ["name", "version"].map(|key| package[key].as_str().unwrap());
        !package["source"].is_null() && names.contains(&vec![name, &format!("v{version}")])
    });
    packages
}

/// The paths of panics in a library say which packages within the standard library it has; their versions if it is that
/// of releases.
#[test]
fn packages_within_the_standard_library_are_listed() {
    let rustc = String::from_utf8(output("rustc", &["--version"])).unwrap();
    let manifest = fs::read_to_string(STD).unwrap();
    let of_releases = rustc.split(' ').nth(1).is_some_and(|own| manifest.contains(&format!("\nversion = \"{own}\"")));
    let listed: Vec<String> = packages(STD, &["--depth", "1"])
        .iter()
        .map(|package| [&package["name"], &package["version"]].map(|text| text.as_str().unwrap()).join("-"))
        .collect();
    let library = fs::read(library_path()).unwrap();
    let text = String::from_utf8_lossy(&library).replace('\\', "/");
    let end = |c: char| !(c.is_ascii_alphanumeric() || "._-".contains(c));
    let found: BTreeSet<&str> = text.split("/rust/deps/").skip(1).filter_map(|rest| rest.split(end).next()).collect();
    assert!(!found.is_empty());
    for package in found {
        let name = package.rsplit_once('-').unwrap().0;
        let known =
            |entry: &String| if of_releases { entry == package } else { entry.starts_with(&format!("{name}-")) };
        assert!(listed.iter().any(known), "{package} is not in {STD}, which has {listed:?}");
    }
}

/// Releases are compiled with the Rust whose packages are listed.
#[test]
fn releases_take_the_rust_whose_packages_are_listed() {
    let workflow = include_str!("../../../.github/workflows/release.yml");
    let version = workflow.split("RUSTUP_TOOLCHAIN: \"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    assert!(fs::read_to_string(STD).unwrap().contains(&format!("\nversion = \"{version}\"")), "{version}");
}

fn license_texts(folder: &Path) -> Vec<String> {
    let is_license = |name: &str| {
        ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"]
            .iter()
            .any(|start| name.to_uppercase().starts_with(start))
    };
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let files = entries.filter(|entry| is_license(&entry.file_name().to_string_lossy()) && entry.path().is_file());
    files.map(|entry| fs::read_to_string(entry.path()).unwrap().replace("\r\n", "\n")).collect()
}

fn output(program: &str, arguments: &[&str]) -> Vec<u8> {
    let output = Command::new(program).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}
