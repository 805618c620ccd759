//! `check` says what is wrong with a damaged FMU, and there is nothing it does not survive.

use std::sync::LazyLock;

use super::support::{entries, fmu, fmu_of, zip};
use cradle_packaging::archive::Entries;
use cradle_packaging::build::Standard;
use cradle_packaging::check::{MAX_BYTES, bytes};
use cradle_packaging::platform::Platform;
use zip::CompressionMethod::{Deflated, Stored};

const DESCRIPTION: &str = "modelDescription.xml";

fn problems(fmu: &[u8]) -> String {
    bytes(fmu, MAX_BYTES).problems.join("\n")
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

/// The problems after the first `from` in the description became `to`.
fn described(from: &str, to: &str) -> String {
    after(|entries| {
        let text = String::from_utf8(entries[DESCRIPTION].clone()).unwrap();
        assert!(text.contains(from), "{from}");
        entries.insert(DESCRIPTION.to_owned(), text.replacen(from, to, 1).into_bytes());
    })
}

fn library() -> String {
    let platform = Platform::host().unwrap();
    format!("binaries/{}/NewtonsCradle.{}", platform.folder, platform.extension)
}

#[test]
fn a_sound_fmu_has_no_problem() {
    assert_eq!(problems(&fmu()), "");
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
fn wrong_descriptions_are_found() {
    for (from, to, expected) in [
        ("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\"", "only 2.0 and 3.0 can be checked"),
        ("guid=\"{", "guid=\"{0", "that of the resources is {"),
        ("modelIdentifier=\"NewtonsCradle\"", "modelIdentifier=\"1-x\"", "is not a C identifier"),
        ("stopTime=\"10\"", "stopTime=\"-1\"", "stopTime is not after startTime"),
        ("stepSize=\"0.01\"", "stepSize=\"0\"", "stepSize is not positive"),
        ("name=\"gravity\"", "name=\"ball.mass\"", "there are two variables of this name"),
        ("name=\"gravity\"", "name=\"a b\"", "not a valid name for variableNamingConvention"),
        ("valueReference=\"16384\"", "valueReference=\"0\"", "can both be set and share a value reference"),
        ("valueReference=\"0\"", "valueReference=\"x\"", "valueReference = \"x\" cannot be read"),
        (
            "causality=\"parameter\" variability=\"fixed\"",
            "causality=\"parameter\" variability=\"continuous\"",
            "exclude each other",
        ),
        (
            "variability=\"fixed\" initial=\"exact\"",
            "variability=\"fixed\" initial=\"calculated\"",
            "initial calculated is not allowed",
        ),
        (" start=\"9.81\"", "", "gravity: the start value is missing"),
        (" start=\"9.81\"", " start=\"-1\"", "gravity: start = \"-1\"; allowed: 0 to inf"),
        (" start=\"9.81\"", " start=\"x\"", "gravity: start = \"x\"; allowed: a number"),
        ("\"ContactModel\" start=\"1\"", "\"ContactModel\" start=\"99\"", "allowed: an item of its type"),
        ("declaredType=\"Acceleration\"", "declaredType=\"Nothing\"", "declaredType Nothing is not a type of Real"),
        ("unit=\"m/s2\" min", "unit=\"furlong\" min", "unit furlong is not defined"),
        ("<Outputs>", "<Outputs><Unknown index=\"1\"/>", "Outputs: gravity does not belong there"),
        ("<ModelStructure>", "<ModelStructure><Derivatives><Unknown index=\"99999\"/></Derivatives>", "index 99999"),
        ("<Category name=\"logSolver\"", "<Category name=\"logEvents\"", "log category logEvents is defined twice"),
        ("<DefaultExperiment", "<Nothing/><DefaultExperiment foo=\"1\"", "modelDescription.xml: not the description"),
        ("needsExecutionTool=\"false\"", "needsExecutionTool=\"perhaps\"", "does not follow the schema"),
    ] {
        let found = described(from, to);
        assert!(found.contains(expected), "{to}: {found}");
    }
}

#[test]
fn what_is_allowed_and_unusual_is_a_remark() {
    let mut entries = SOUND.clone();
    let text = String::from_utf8(entries[DESCRIPTION].clone()).unwrap();
    entries.insert(DESCRIPTION.to_owned(), text.replace("00:00:00Z", "00:00:00+00:00").into_bytes());
    entries.insert("documentation/\u{fc}.txt".to_owned(), vec![1]);
    let report = bytes(&zip(&entries, Stored), MAX_BYTES);
    assert!(report.is_clean(), "{report}");
    let remarks = report.remarks.join("\n");
    for expected in ["should be YYYY-MM-DDThh:mm:ssZ", "documentation/\u{fc}.txt: not in ASCII"] {
        assert!(remarks.contains(expected), "{remarks}");
    }
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
    let found = bytes(&zip(&bomb, Deflated), 1 << 20).problems.join("\n");
    assert!(found.contains("a: the unpacked files exceed 1048576 bytes"), "{found}");
}

#[test]
fn wrong_descriptions_of_fmi_3_are_found() {
    let sound = fmu_of(Standard::Fmi3 { clocks: true });
    assert_eq!(problems(&sound), "");
    let sound = entries(&sound);
    let text = String::from_utf8(sound[DESCRIPTION].clone()).unwrap();
    for (from, to, expected) in [
        ("instantiationToken=\"{", "instantiationToken=\"{0", "that of the resources is {"),
        ("name=\"gravity\"", "name=\"ball.mass\"", "there are two variables of this name"),
        ("name=\"gravity\"", "name=\"a b\"", "not a valid name for variableNamingConvention"),
        ("name=\"gravity\" valueReference=\"32\"", "name=\"gravity\" valueReference=\"1\"", "share a value reference"),
        (" start=\"9.81\"", "", "gravity: the start value is missing"),
        (" start=\"9.81\"", " start=\"x\"", "gravity: start = \"x\"; allowed: numbers"),
        (" start=\"1 1 1 1 1\"", " start=\"1 1\"", "2 start value(s); allowed: 5"),
        ("declaredType=\"Acceleration\"", "declaredType=\"Nothing\"", "its declaredType is not defined"),
        ("causality=\"independent\"", "causality=\"local\"", "there are 0 independent variables"),
        (
            "<Dimension valueReference=\"1\"/>",
            "<Dimension valueReference=\"0\"/>",
            "is not sized by a structural parameter",
        ),
        (" clocks=\"8\"", " clocks=\"0\"", "belongs to a clock that is none"),
        ("<Output valueReference", "<Nothing valueReference", "Output: x is missing"),
        ("<InitialUnknown valueReference", "<Nothing valueReference", "InitialUnknown: pendulum.period is missing"),
        ("dependencies=\"", "dependencies=\"999 ", "Output: x is, or depends on, a variable that does not exist"),
    ] {
        assert!(text.contains(from), "{from}");
        let mut entries = sound.clone();
        entries.insert(DESCRIPTION.to_owned(), text.replacen(from, to, 1).into_bytes());
        let found = problems(&zip(&entries, Stored));
        assert!(found.contains(expected), "{to}: {found}");
    }
}
