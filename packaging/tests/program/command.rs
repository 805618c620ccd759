//! The program as a user runs it: what it writes, what it refuses, and what it finds in good, damaged and hostile FMUs.

use std::fs;

use super::support::{self, Folder, entries, library, run, write};

#[test]
fn one_binary_serves_every_number_of_balls() {
    let folder = Folder::new("balls");
    let library = library();
    for balls in [1, 2, 5, 13, 100] {
        let out = folder.file(&format!("{balls}.fmu"));
        let built = run(&["build", "--balls", &balls.to_string(), "--binary", &library, "--out", &out]);
        assert_eq!(built.code, 0, "{}", built.error);
        let checked = run(&["check", &out]);
        assert_eq!(checked.code, 0, "{}", checked.output);
        let info = run(&["info", &out]);
        assert!(info.code == 0 && info.output.contains(&format!("balls        {balls}\n")), "{}", info.output);
    }
}

#[test]
fn the_same_arguments_give_the_same_bytes() {
    let (one, two) = (Folder::new("one"), Folder::new("another/folder"));
    let library = library();
    for folder in [&one, &two] {
        let built = run(&["build", "--preset", "desk", "--binary", &library, "--out", &folder.file("x.fmu")]);
        assert_eq!(built.code, 0, "{}", built.error);
    }
    assert!(fs::read(one.file("x.fmu")).unwrap() == fs::read(two.file("x.fmu")).unwrap());
}

#[test]
fn start_values_go_into_description_and_resources() {
    let folder = Folder::new("start");
    let parameters = folder.file("cradle.toml");
    fs::write(
        &parameters,
        "balls = 3\nx_start = [-0.2, 0, 0]\n[contact]\nmodel = \"hertz\"\n'gap[1]' = 1e-6\n[solver]\ntolerance = 1e-9\n",
    )
    .unwrap();
    let out = folder.file("x.fmu");
    let (library, set) = (library(), "solver.tolerance=1e-8");
    let built = run(&["build", "--parameters", &parameters, "--set", set, "--binary", &library, "--out", &out]);
    assert_eq!(built.code, 0, "{}", built.error);
    let entries = entries(&fs::read(&out).unwrap());
    let text = |name: &str| String::from_utf8(entries[name].clone()).unwrap();
    let description = text("modelDescription.xml");
    for (variable, start) in [("x_start[1]", "-0.2"), ("contact.gap[1]", "1e-6"), ("solver.tolerance", "1e-8")] {
        let at = description.find(&format!("name=\"{variable}\"")).unwrap();
        let line = description[at..].lines().nth(1).unwrap();
        assert!(line.contains(&format!("start=\"{start}\"")), "{variable}: {line}");
    }
    assert!(description.contains("<Enumeration declaredType=\"ContactModel\" start=\"2\"/>"));
    let resources = text("resources/cradle.json");
    for part in ["\"balls\": 3", "\"x_start[1]\": -0.2", "\"contact.model\": \"hertz\""] {
        assert!(resources.contains(part), "{resources}");
    }
    let info = run(&["info", &out]).output;
    assert!(info.contains("contact.model = hertz") && info.contains("x_start[1] = -0.2 m"), "{info}");
    assert_eq!(run(&["check", &out]).code, 0);
}

#[test]
fn every_preset_can_be_built_and_is_told_in_the_help() {
    let folder = Folder::new("presets");
    let (out, library) = (folder.file("x.fmu"), library());
    let (help, list) = (run(&["build", "--help"]).output, run(&["presets"]).output);
    for preset in cradle_packaging::build::PRESETS {
        let line = format!("{:8} {}\n", preset.name, preset.title());
        assert!(help.contains(&line) && list.contains(&line), "{help}{list}");
        let built = run(&["build", "--preset", preset.name, "--binary", &library, "--out", &out]);
        assert_eq!(built.code, 0, "{}", built.error);
        assert_eq!(run(&["check", &out]).code, 0, "{}", preset.name);
    }
}

#[test]
fn a_binary_for_another_machine_is_refused() {
    let folder = Folder::new("machine");
    let library = library();
    let (platform, file) = library.split_once('=').unwrap();
    let other = if platform == "win64" { "linux64" } else { "win64" };
    let refused = run(&["build", "--binary", &format!("{other}={file}"), "--out", &folder.file("x.fmu")]);
    assert_eq!(refused.code, 2);
    assert!(refused.error.contains(&format!("is not a shared library for {other}, but a ")), "{}", refused.error);
    assert!(folder.list().is_empty());
}

#[test]
fn a_target_that_cannot_be_written_leaves_nothing() {
    let folder = Folder::new("target");
    fs::write(folder.file("file"), "").unwrap();
    let library = library();
    for out in ["file/x.fmu", "."] {
        let failed = run(&["build", "--binary", &library, "--out", &folder.file(out)]);
        assert_eq!(failed.code, 1);
        assert!(failed.error.contains("cannot write "), "{}", failed.error);
    }
    assert_eq!(folder.list().len(), 1);
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_fmu() {
    let folder = Folder::new("full");
    let out = folder.file("x.fmu");
    fs::write(&out, "old").unwrap();
    // A limit on the size of files fails as a full disk does, in the middle of writing.
    let script = "trap '' XFSZ; ulimit -f 16; exec \"$@\"";
    let program = env!("CARGO_BIN_EXE_cradle-fmu");
    let library = library();
    let failed = support::output("sh", &["-c", script, "sh", program, "build", "--binary", &library, "--out", &out]);
    assert_eq!(failed.code, 1, "{}", failed.output);
    assert!(failed.error.contains("cannot write "), "{}", failed.error);
    assert_eq!(fs::read_to_string(&out).unwrap(), "old");
    assert_eq!(folder.list().len(), 1);
}

#[test]
fn a_date_is_taken_from_the_environment() {
    let folder = Folder::new("date");
    let (out, library) = (folder.file("x.fmu"), library());
    let arguments = ["build", "--binary", &library, "--out", &out];
    let built = support::with_environment("SOURCE_DATE_EPOCH", "951827696", &arguments);
    assert_eq!(built.code, 0, "{}", built.error);
    assert!(run(&["info", &out]).output.contains("2000-02-29T12:34:56Z"));
    let refused = support::with_environment("SOURCE_DATE_EPOCH", "yesterday", &arguments);
    assert!(refused.code == 2 && refused.error.contains("allowed: 0 to "), "{}", refused.error);
}

#[test]
fn what_cannot_be_read_is_no_finding() {
    let folder = Folder::new("unreadable");
    for command in ["check", "info"] {
        let failed = run(&[command, &folder.file("nothing.fmu")]);
        assert!(failed.code == 2 && failed.error.contains("nothing.fmu"), "{}", failed.error);
    }
    fs::write(folder.file("text.fmu"), "text").unwrap();
    assert_eq!(run(&["check", &folder.file("text.fmu")]).code, 1);
    assert_eq!(run(&["info", &folder.file("text.fmu")]).code, 2);
}

/// A C compiler makes the binary: one that gets as far as being asked, and then aborts.
#[cfg(target_os = "linux")]
#[test]
fn a_binary_that_crashes_is_found_out() {
    let folder = Folder::new("crash");
    let source = "#include <stdlib.h>\nvoid *fmi2Instantiate(void) { abort(); }\n";
    fs::write(folder.file("x.c"), source).unwrap();
    let library = folder.file("x.so");
    let compiled = support::output("cc", &["-shared", "-fPIC", "-o", &library, &folder.file("x.c")]);
    assert_eq!(compiled.code, 0, "{}", compiled.error);
    let path = sound_with_results(&folder);
    let mut entries = entries(&fs::read(&path).unwrap());
    entries.insert("binaries/linux64/NewtonsCradle.so".to_owned(), fs::read(&library).unwrap());
    let path = write(&folder, "crash.fmu", &entries);
    let checked = run(&["check", &path]);
    assert_eq!(checked.code, 1);
    for expected in ["does not export fmi2CancelStep, ", "reference results: its binary crashed"] {
        assert!(checked.output.contains(expected), "{}", checked.output);
    }
    assert!(!run(&["check", "--no-load", &path]).output.contains("crashed"));
}

#[test]
fn a_binary_with_other_results_is_found_out() {
    let folder = Folder::new("results");
    let sound = sound_with_results(&folder);
    assert_eq!(run(&["check", &sound]).code, 0);
    let mut entries = entries(&fs::read(&sound).unwrap());
    entries.insert("extra/org.fmi-standard.fmi-ls-ref/desk.csv".to_owned(), b"\"time\"\n".to_vec());
    let checked = run(&["check", &write(&folder, "other.fmu", &entries)]);
    let expected = "desk.csv: the binary for this machine gives other results";
    assert!(checked.code == 1 && checked.output.contains(expected), "{}", checked.output);
}

/// The default FMU as the program packs it, with reference results; its path.
fn sound_with_results(folder: &Folder) -> String {
    let out = folder.file("sound.fmu");
    let built = run(&["build", "--binary", &library(), "--out", &out]);
    assert_eq!(built.code, 0, "{}", built.error);
    out
}
