//! Keeps the time of linking out of binaries for Windows, and the place out of those for macOS: the same sources give
//! the same bytes.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let target = |what: &str| env::var(format!("CARGO_CFG_TARGET_{what}")).expect("Cargo sets it");
    if target("OS") == "windows" {
        let flag = if target("ENV") == "gnu" { "-Wl,--no-insert-timestamp" } else { "/Brepro" };
        println!("cargo::rustc-cdylib-link-arg={flag}");
    }
    if target("VENDOR") == "apple" {
        // By default the name by which others would link with it is the path that it is written to.
        println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/NewtonsCradle.dylib");
    }
}
