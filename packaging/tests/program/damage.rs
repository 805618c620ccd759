//! `check` says what is wrong with a damaged FMU, and there is nothing that it and `info` do not survive.

use std::io::{Cursor, Write};
use std::sync::LazyLock;

use ::zip::CompressionMethod::Stored;
use ::zip::ZipWriter;
use ::zip::write::SimpleFileOptions;

use super::support::{BINARY, Folder, START, fmu, text, zip};
use cradle_packaging::archive::Entries;
use cradle_packaging::build;
use cradle_packaging::check::{MAX_BYTES, bytes};
use cradle_packaging::platform::Platform;
use newtons_cradle::variables::{Description, Recipe};

const DESCRIPTION: &str = "modelDescription.xml";

fn problems(fmu: &[u8]) -> String {
    bytes(fmu, MAX_BYTES).0.problems.join("\n")
}

/// An FMU without a binary.
static SMALL: LazyLock<Entries> =
    LazyLock::new(|| build::entries(&Recipe::default(), &Description::of(&START), vec![]).unwrap());

/// A small FMU with other `contents` of the entry `name`, or without the entry.
fn with(name: &str, contents: Option<&[u8]>) -> Vec<u8> {
    let mut entries = SMALL.clone();
    match contents {
        Some(contents) => entries.insert(name.to_owned(), contents.to_vec()),
        None => entries.remove(name),
    };
    zip(&entries)
}

#[test]
fn check_finds_no_problem_in_a_sound_fmu() {
    for description in Description::all(&START, false).iter().chain(&Description::all(&START, true)) {
        assert_eq!(problems(&zip(&fmu(description))), "");
    }
    let licences = ["LICENSE-APACHE", "LICENSE-MIT", "third-party"];
    assert!(licences.iter().all(|name| !SMALL[&format!("documentation/licenses/{name}.txt")].is_empty()));
    assert!(SMALL["model.png"].starts_with(b"\x89PNG"));
    // Entries need not be compressed.
    let mut stored = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, contents) in &*SMALL {
        stored.start_file(name.as_str(), SimpleFileOptions::default().compression_method(Stored)).unwrap();
        stored.write_all(contents).unwrap();
    }
    assert_eq!(problems(&stored.finish().unwrap().into_inner()), problems(&zip(&SMALL)));
}

#[test]
fn check_finds_damaged_entries() {
    let (platform, resources) = (Platform::host().unwrap(), "resources/cradle.json");
    let library = platform.path(platform.folder, "NewtonsCradle");
    let (description, sound) = (&SMALL[DESCRIPTION], fmu(&Description::of(&START)));
    let not_utf8 = [description, &[0xff][..]].concat();
    let cases: &[(&str, Option<&[u8]>, &str)] = &[
        (DESCRIPTION, None, "modelDescription.xml: missing"),
        (&library, None, "binaries: none for NewtonsCradle"),
        ("documentation/index.html", None, "documentation/index.html: missing"),
        (DESCRIPTION, Some(&description[..5000]), "not well-formed XML"),
        (DESCRIPTION, Some(&not_utf8), "not in UTF-8"),
        (DESCRIPTION, Some(b"<other fmiVersion=\"2.0\"/>"), "its root is other, not fmiModelDescription"),
        (&library, Some(&sound[&library][..100]), "not a shared library for "),
        (&library, Some(b"MZ"), "not a shared library for "),
        (resources, Some(b"{\"format\":1,\"balls\":4}"), "that of the resources is {"),
        (resources, Some(b"{"), "resources/cradle.json: not readable"),
        ("../outside", Some(b"1"), "../outside: not a path that stays"),
        ("/etc/x", Some(b"1"), "/etc/x: not a path that stays"),
        ("a/./b", Some(b"1"), "a/./b: not a path that stays"),
        ("C:/x", Some(b"1"), "C:/x: not a path that stays"),
        ("a\\b", Some(b"1"), "a\\b: a backslash"),
        ("a\x1b[2Jb\n\u{9b}\u{202e}", Some(b"1"), "a?[2Jb???: a name with control characters"),
        ("MODEL.PNG", Some(b"1"), "model.png: on some systems, another entry has the same name"),
    ];
    for (name, contents, expected) in cases {
        let found = problems(&with(name, *contents));
        assert!(found.contains(expected), "{expected}: {found}");
    }
}

/// Unpacked as such, a link leads out of the FMU, and who reads a pipe waits for ever.
#[test]
fn check_finds_links_pipes_and_duplicate_names() {
    let made = |name: &str, kind: u32, system: u8| {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, contents) in &*SMALL {
            zip.start_file(name.as_str(), SimpleFileOptions::default()).unwrap();
            zip.write_all(contents).unwrap();
        }
        zip.start_file(name, SimpleFileOptions::default().external_attributes(kind << 16)).unwrap();
        zip.write_all(b"/etc/passwd").unwrap();
        let mut bytes = zip.finish().unwrap().into_inner();
        let last = bytes.windows(4).rposition(|four| four == b"PK\x01\x02").unwrap();
        bytes[last + 5] = system;
        bytes
    };
    let sound = problems(&zip(&SMALL));
    // As if made on DOS, Unix and macOS.
    for system in [0, 3, 19] {
        for kind in [0o120_777, 0o010_644, 0o020_666, 0o060_666, 0o140_777] {
            let found = problems(&made("resources/x", kind, system));
            assert!(found.contains("resources/x: a link, a pipe or a device; allowed: a file"), "{kind:o}: {found}");
        }
        for kind in [0, 0o644, 0o100_755] {
            assert_eq!(problems(&made("resources/x", kind, system)), sound);
        }
    }
    let mut twice = made("resources/cradle.jsom", 0, 3);
    let places: Vec<usize> =
        twice.windows(4).enumerate().filter(|(_, four)| four == b"jsom").map(|(at, _)| at).collect();
    places.into_iter().for_each(|at| twice[at + 3] = b'n');
    assert!(problems(&twice).contains("zip: several entries have the same name"));
}

/// Names, and texts of the description.
#[test]
fn check_shows_foreign_text_without_control_characters() {
    let mut entries = SMALL.clone();
    let name = "resources/\x1b]0;title\x07\u{9b}31m\u{202e}\nfile";
    entries.insert(name.to_owned(), b"1".to_vec());
    let description = text(&entries, DESCRIPTION).replacen("modelName=\"", "modelName=\"&#x9b;2J&#10;", 1);
    entries.insert(DESCRIPTION.to_owned(), description.into_bytes());
    let folder = Folder::new("control");
    folder.write("x.fmu", zip(&entries));
    let of_name = "1 resources/?]0;title??31m??file\n";
    let shown = folder.run("info x.fmu").with(0, &["model        ?2J?NewtonsCradle ", of_name]);
    let replaced =
        folder.run(&format!("build {BINARY} --balls 3 --out x.fmu")).with(0, &["which was: \"?2J?NewtonsCradle\""]);
    for said in [shown.output, replaced.error] {
        assert!(!said.contains(|c: char| (c.is_control() && c != '\n') || c == '\u{202e}'), "{said:?}");
    }
}

#[test]
fn check_finds_changed_descriptions() {
    for description in [Description::of(&START), Description::fmi3(&START)] {
        let mut entries = build::entries(&Recipe::default(), &description, vec![]).unwrap();
        let text = text(&entries, DESCRIPTION);
        for (from, to, expected) in [
            ("oken=\"{", "oken=\"{0", "that of the resources is {"),
            ("guid=\"{", "guid=\"{0", "that of the resources is {"),
            (" start=\"9.81\"", " start=\"9.8\"", "not the description that belongs to its GUID"),
            ("<ModelStructure>", "<ModelStructure><Nothing/>", "not the description that belongs to its GUID"),
            ("fmiVersion=\"", "fmiVersion=\"1", "only 2.0 and 3.0 can be read"),
            ("</ModelStructure>", "</ModelVariables>", "not well-formed XML"),
            ("modelName=\"", "modelName=\"Other", "`fmpy validate FILE` checks those of others"),
        ] {
            if text.contains(from) {
                entries.insert(DESCRIPTION.to_owned(), text.replacen(from, to, 1).into_bytes());
                let found = problems(&zip(&entries));
                assert!(found.contains(expected), "{to}: {found}");
            }
        }
    }
}

/// A reader that recurses exhausts the stack at some depth.
#[test]
fn check_survives_deeply_nested_descriptions() {
    let (begin, end) = ("<a>".repeat(100_000), "</a>".repeat(100_000));
    let whole = format!("<fmiModelDescription fmiVersion=\"2.0\">{begin}{end}</fmiModelDescription>");
    let folder = Folder::new("nested");
    for (text, problem, code) in [(begin, "never closed", 2), (whole, "fmpy", 0)] {
        let nested = zip(&[(DESCRIPTION.to_owned(), text.into_bytes())].into());
        assert!(problems(&nested).contains(problem));
        folder.write("nested.fmu", nested);
        folder.run("info nested.fmu").with(code, &[]);
    }
}

#[test]
fn check_remarks_on_what_is_allowed_and_unusual() {
    let (report, _) = bytes(&with("documentation/\u{fc}.txt", Some(b"1")), MAX_BYTES);
    assert_eq!(report.problems.join("\n"), problems(&zip(&SMALL)));
    assert!(report.remarks.join("\n").contains("\u{fc}.txt: not in ASCII"), "{report}");
}

#[test]
fn check_survives_flipped_bits_and_cuts_and_overlooks_hardly_one() {
    let sound = zip(&SMALL);
    let expected = problems(&sound);
    let tried: Vec<usize> = (0..sound.len()).step_by(401).collect();
    let changed = |at: &&usize| {
        let mut damaged = sound.clone();
        damaged[**at] ^= 1 << (**at % 8);
        problems(&damaged) != expected
    };
    // What is not found lies in dates, attributes and the like, which nobody reads.
    let found = tried.iter().filter(changed).count();
    assert!(found * 100 > tried.len() * 90, "{found} of {}", tried.len());
    for end in (0..sound.len()).step_by(1501) {
        assert!(problems(&sound[..end]).contains("zip: "), "{end}");
    }
}

#[test]
fn check_does_not_unpack_a_zip_bomb() {
    let found = bytes(&with("a", Some(&vec![0; 8 << 20])), 1 << 20).0.problems.join("\n");
    assert!(found.contains("a: the unpacked files exceed 1048576 bytes"), "{found}");
}
