//! `check` and `info` on FMUs that nobody packed: random bytes, and small FMUs with changes in their entries, their
//! binary, their description and their zip file. Whatever they find, they do not crash, and every finding is one line.
#![no_main]

use std::io::{Cursor, Write};
use std::process::Command;
use std::sync::LazyLock;

use arbitrary::Arbitrary;
use cradle_packaging::archive::Entries;
use cradle_packaging::build::{self, Binary};
use cradle_packaging::check::bytes;
use cradle_packaging::info;
use cradle_packaging::platform::Platform;
use libfuzzer_sys::fuzz_target;
use newtons_cradle::variables::Recipe;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// What is unpacked at most, bytes.
const LIMIT: u64 = 1 << 20;

/// Pieces of descriptions that mean something.
const WORDS: [&str; 14] = [
    "<",
    "/>",
    "\"",
    "<!--",
    "<![CDATA[",
    "<?x?>",
    "<!DOCTYPE x>",
    "&#0;",
    "&lt;",
    "</ModelVariables>",
    "<ModelExchange modelIdentifier=\"x\"/>",
    " xmlns=\"x\"",
    " causality=\"independent\"",
    "4294967296",
];

#[derive(Debug, Arbitrary)]
enum Input {
    Random(Vec<u8>),
    Changed { method: bool, entries: Vec<Change>, flips: Vec<u32>, end: Option<u32> },
}

#[derive(Debug, Arbitrary)]
enum Change {
    Remove { entry: u8 },
    Rename { entry: u8, to: String },
    Add { name: String, contents: Vec<u8> },
    Cut { entry: u8, at: u32 },
    Replace { entry: u8, at: u32, by: Vec<u8> },
    Word { at: u32, word: u8, over: u8 },
    Nest { at: u32, depth: u16 },
}

/// The entries of a small FMU, with a small binary.
static ENTRIES: LazyLock<Entries> = LazyLock::new(|| {
    let binary = Binary { platform: Platform::host().unwrap(), contents: library() };
    let mut entries = build::entries(&Recipe::new(1), vec![binary], build::Standard::Fmi2).unwrap();
    entries.retain(|name, _| !name.starts_with("documentation/licenses/"));
    entries
});

/// A shared library with two functions.
fn library() -> Vec<u8> {
    let folder = std::env::temp_dir().join(format!("cradle-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (source, library) = (folder.join("x.c"), folder.join("x.so"));
    std::fs::write(&source, "void exit(int);\nvoid fmi2DoStep(void) {}\nvoid fmi2Reset(void) { exit(0); }\n").unwrap();
    let made = Command::new("cc").args(["-shared", "-fPIC", "-s", "-w", "-o"]).args([&library, &source]).status();
    assert!(made.unwrap().success());
    let bytes = std::fs::read(&library).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    bytes
}

fuzz_target!(|input: Input| {
    let fmu = match input {
        Input::Random(bytes) => bytes,
        Input::Changed { method, entries, flips, end } => changed(method, &entries, &flips, end),
    };
    // What it says of an FMU that it can read is free text.
    let _ = info::bytes(&fmu, LIMIT);
    let (report, _) = bytes(&fmu, LIMIT);
    let lines = report.to_string().lines().count();
    assert_eq!(
        lines,
        report.problems.len() + report.remarks.len() + if report.to_string().contains("\nand ") { 2 } else { 1 }
    );
});

fn changed(method: bool, changes: &[Change], flips: &[u32], end: Option<u32>) -> Vec<u8> {
    let mut entries = ENTRIES.clone();
    changes.iter().for_each(|change| change.make(&mut entries));
    let method = if method { CompressionMethod::Deflated } else { CompressionMethod::Stored };
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, contents) in &entries {
        // Names that a zip file cannot hold are not written.
        if zip.start_file(name, SimpleFileOptions::default().compression_method(method)).is_ok() {
            zip.write_all(contents).unwrap();
        }
    }
    let mut bytes = zip.finish().unwrap().into_inner();
    for flip in flips {
        let bit = within(*flip, bytes.len() * 8);
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    if let Some(end) = end {
        bytes.truncate(within(end, bytes.len()));
    }
    bytes
}

impl Change {
    fn make(&self, entries: &mut Entries) {
        let name =
            |entry: u8, entries: &Entries| entries.keys().nth(usize::from(entry) % entries.len().max(1)).cloned();
        match self {
            Self::Remove { entry } => {
                name(*entry, entries).and_then(|name| entries.remove(&name));
            }
            Self::Rename { entry, to } => {
                let contents = name(*entry, entries).and_then(|name| entries.remove(&name));
                contents.and_then(|contents| entries.insert(to.clone(), contents));
            }
            Self::Add { name, contents } => {
                entries.insert(name.clone(), contents.clone());
            }
            Self::Cut { entry, at } => {
                if let Some(contents) = name(*entry, entries).and_then(|name| entries.get_mut(&name)) {
                    contents.truncate(within(*at, contents.len()));
                }
            }
            Self::Replace { entry, at, by } => {
                if let Some(contents) = name(*entry, entries).and_then(|name| entries.get_mut(&name)) {
                    let at = within(*at, contents.len());
                    contents[at..].iter_mut().zip(by).for_each(|(byte, new)| *byte = *new);
                }
            }
            Self::Word { at, word, over } => describe(entries, *at, *over, WORDS[usize::from(*word) % WORDS.len()]),
            Self::Nest { at, depth } => describe(entries, *at, 0, &"<a>".repeat(usize::from(*depth))),
        }
    }
}

/// Puts `text` into the description, over so many bytes of it.
fn describe(entries: &mut Entries, at: u32, over: u8, text: &str) {
    if let Some(contents) = entries.get_mut("modelDescription.xml") {
        let at = within(at, contents.len());
        let end = (at + usize::from(over)).min(contents.len());
        contents.splice(at..end, text.bytes());
    }
}

/// A place in something of `length`.
fn within(at: u32, length: usize) -> usize {
    at as usize % length.max(1)
}
