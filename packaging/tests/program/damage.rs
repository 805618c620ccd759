//! `check` says what is wrong with a damaged FMU, and there is nothing that it and `info` do not survive.

use std::sync::LazyLock;

use super::support::{entries, fmu, fmu_of, zip};
use cradle_packaging::archive::Entries;
use cradle_packaging::build::Standard;
use cradle_packaging::check::{MAX_BYTES, bytes};
use cradle_packaging::info;
use cradle_packaging::platform::Platform;
use zip::CompressionMethod::{Deflated, Stored};

const DESCRIPTION: &str = "modelDescription.xml";

fn problems(fmu: &[u8]) -> String {
    bytes(fmu, MAX_BYTES).0.problems.join("\n")
}

static SOUND: LazyLock<Entries> = LazyLock::new(|| entries(&fmu()));

/// The problems after a change of the entries.
fn after(change: impl FnOnce(&mut Entries)) -> String {
    let mut entries = SOUND.clone();
    change(&mut entries);
    problems(&zip(&entries, Stored))
}

/// An FMU that lacks its binary, which makes it small.
fn small() -> Vec<u8> {
    let mut small = SOUND.clone();
    small.remove(&library());
    zip(&small, Deflated)
}

fn library() -> String {
    let platform = Platform::host().unwrap();
    format!("binaries/{}/NewtonsCradle.{}", platform.folder, platform.extension)
}

#[test]
fn a_sound_fmu_has_no_problem() {
    assert_eq!(problems(&fmu()), "");
    assert_eq!(problems(&fmu_of(Standard::Fmi3 { clocks: true })), "");
}

#[test]
fn damaged_entries_are_found() {
    type Change = fn(&mut Entries);
    let cases: &[(Change, &str)] = &[
        (|entries| drop(entries.remove(DESCRIPTION)), "modelDescription.xml: missing"),
        (|entries| drop(entries.remove(&library())), "binaries: none for NewtonsCradle"),
        (|entries| drop(entries.remove("documentation/index.html")), "documentation/index.html: missing"),
        (|entries| entries.get_mut(DESCRIPTION).unwrap().truncate(5000), "not well-formed XML"),
        (|entries| entries.get_mut(DESCRIPTION).unwrap().push(0xff), "not in UTF-8"),
        (|entries| entries.get_mut(&library()).unwrap().truncate(100), "not a shared library for "),
        (|entries| drop(entries.insert(library(), b"MZ".to_vec())), "not a shared library for "),
        (
            |entries| drop(entries.insert("resources/cradle.json".into(), b"{\"format\":1,\"balls\":4}".to_vec())),
            "that of the resources is {",
        ),
        (
            |entries| drop(entries.insert("resources/cradle.json".into(), b"{".to_vec())),
            "resources/cradle.json: not readable",
        ),
        (|entries| drop(entries.insert("../outside".into(), vec![1])), "../outside: not a path that stays"),
        (|entries| drop(entries.insert("/etc/x".into(), vec![1])), "/etc/x: not a path that stays"),
        (|entries| drop(entries.insert("a/./b".into(), vec![1])), "a/./b: not a path that stays"),
        (|entries| drop(entries.insert("C:/x".into(), vec![1])), "C:/x: not a path that stays"),
        (|entries| drop(entries.insert("a\\b".into(), vec![1])), "a\\b: a backslash"),
    ];
    for (change, expected) in cases {
        let found = after(change);
        assert!(found.contains(expected), "{expected}: {found}");
    }
}

#[test]
fn changed_descriptions_are_found() {
    for standard in [Standard::Fmi2, Standard::Fmi3 { clocks: true }] {
        let sound = entries(&fmu_of(standard));
        let text = String::from_utf8(sound[DESCRIPTION].clone()).unwrap();
        let changed = |text: String| {
            let mut entries = sound.clone();
            entries.insert(DESCRIPTION.to_owned(), text.into_bytes());
            problems(&zip(&entries, Stored))
        };
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
                let found = changed(text.replacen(from, to, 1));
                assert!(found.contains(expected), "{to}: {found}");
            }
        }
    }
}

/// A reader that recurses exhausts the stack at some depth.
#[test]
fn deeply_nested_descriptions_are_survived() {
    let root = "<fmiModelDescription fmiVersion=\"2.0\">";
    for (text, problem, informed) in [
        ("<a>".repeat(1_000_000), "it ends within an element", false),
        (format!("{root}{}{}</fmiModelDescription>", "<a>".repeat(1_000_000), "</a>".repeat(1_000_000)), "fmpy", true),
    ] {
        let nested = zip(&[(DESCRIPTION.to_owned(), text.into_bytes())].into(), Deflated);
        assert!(problems(&nested).contains(problem));
        assert_eq!(info::bytes(&nested, MAX_BYTES).is_ok(), informed);
    }
}

#[test]
fn what_is_allowed_and_unusual_is_a_remark() {
    let mut entries = SOUND.clone();
    entries.insert("documentation/\u{fc}.txt".to_owned(), vec![1]);
    let (report, _) = bytes(&zip(&entries, Stored), MAX_BYTES);
    assert!(report.is_clean() && report.remarks.join("\n").contains("\u{fc}.txt: not in ASCII"), "{report}");
}

#[test]
fn every_flipped_bit_is_survived_and_none_in_an_entry_overlooked() {
    let sound = small();
    let expected = problems(&sound);
    let mut found = 0;
    for at in (0..sound.len()).step_by(149) {
        let mut damaged = sound.clone();
        damaged[at] ^= 1 << (at % 8);
        found += usize::from(problems(&damaged) != expected);
    }
    // What is not found lies in dates, attributes and the like, which nobody reads.
    let tried = sound.len().div_ceil(149);
    assert!(found * 100 > tried * 90, "{found} of {tried}");
}

#[test]
fn every_cut_is_found() {
    let sound = small();
    for end in (0..sound.len()).step_by(501) {
        assert!(problems(&sound[..end]).contains("zip: "), "{end}");
    }
}

#[test]
fn a_zip_bomb_is_not_unpacked() {
    let mut bomb = SOUND.clone();
    bomb.insert("a".to_owned(), vec![0; 8 << 20]);
    let found = bytes(&zip(&bomb, Deflated), 1 << 20).0.problems.join("\n");
    assert!(found.contains("a: the unpacked files exceed 1048576 bytes"), "{found}");
}
