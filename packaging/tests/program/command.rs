//! The program as a user runs it: what it writes, what it leaves behind when it cannot, and what it finds out by
//! running a binary.

use std::fs;
use std::process::Command;

use cradle_packaging::build::PRESETS;
use zip::CompressionMethod::Stored;

use super::support::{Folder, PROGRAM, build, ended, entries_of, library, run, sound, text, zip};

#[test]
fn start_values_go_into_description_and_resources() {
    let folder = Folder::new("start");
    let parameters = "balls = 3\nx_start = [-0.2, 0, 0]\n[contact]\nmodel = \"hertz\"\n'gap[1]' = 1e-6\n\
                      [solver]\ntolerance = 1e-9\n";
    let parameters = folder.write("cradle.toml", parameters);
    let out = build(&folder, "x.fmu", &["--parameters", &parameters, "--set", "solver.tolerance=1e-8"]);
    let entries = entries_of(&out);
    let description = text(&entries, "modelDescription.xml");
    for (variable, start) in [("x_start[1]", "-0.2"), ("contact.gap[1]", "1e-6"), ("solver.tolerance", "1e-8")] {
        let at = description.find(&format!("name=\"{variable}\"")).unwrap();
        let line = description[at..].lines().nth(1).unwrap();
        assert!(line.contains(&format!("start=\"{start}\"")), "{variable}: {line}");
    }
    assert!(description.contains("<Enumeration declaredType=\"ContactModel\" start=\"2\"/>"));
    let resources = text(&entries, "resources/cradle.json");
    for part in ["\"balls\": 3", "\"x_start[1]\": -0.2", "\"contact.model\": \"hertz\""] {
        assert!(resources.contains(part), "{resources}");
    }
    let info = sound(&out);
    for part in ["balls        3\n", "contact.model = hertz", "x_start[1] = -0.2 m"] {
        assert!(info.contains(part), "{info}");
    }
}

#[test]
fn presets_are_told_in_the_help_and_can_be_built() {
    let (help, list) = (run(&["build", "--help"]).output, run(&["presets"]).output);
    for preset in PRESETS {
        let line = format!("{:8} {}\n", preset.name, preset.title());
        assert!(help.contains(&line) && list.contains(&line), "{help}{list}");
    }
    sound(&build(&Folder::new("preset"), "desk.fmu", &["--preset", "desk"]));
}

#[test]
fn a_target_that_cannot_be_written_leaves_nothing() {
    let folder = Folder::new("target");
    folder.write("file", "");
    let library = library();
    for (out, code, reason) in [("file/x.fmu", 2, "there is no folder "), (".", 1, "cannot write ")] {
        let failed = run(&["build", "--binary", &library, "--out", &folder.file(out)]);
        assert!(failed.code == code && failed.error.contains(reason), "{failed:?}");
    }
    assert_eq!(folder.list().len(), 1);
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_fmu() {
    let folder = Folder::new("full");
    let (out, library) = (folder.write("x.fmu", "old"), library());
    // A limit on the size of files fails as a full disk does, in the middle of writing.
    let script = "trap '' XFSZ; ulimit -f 16; exec \"$@\"";
    let build = ["-c", script, "sh", PROGRAM, "build", "--binary", &library, "--out", &out];
    let failed = ended(Command::new("sh").args(build));
    assert!(failed.code == 1 && failed.error.contains("cannot write "), "{failed:?}");
    assert_eq!(fs::read_to_string(&out).unwrap(), "old");
    assert_eq!(folder.list().len(), 1);
}

#[test]
fn a_date_is_taken_from_the_environment() {
    let folder = Folder::new("date");
    let (out, library) = (folder.file("x.fmu"), library());
    let build = |date: &str| {
        let arguments = ["build", "--binary", &library, "--out", &out];
        ended(Command::new(PROGRAM).args(arguments).env("SOURCE_DATE_EPOCH", date))
    };
    assert_eq!(build("253402300799").code, 0);
    assert!(run(&["info", &out]).output.contains("9999-12-31T23:59:59Z"));
    for date in ["yesterday", "253402300800"] {
        let refused = build(date);
        assert!(refused.code == 2 && refused.error.contains("allowed: 0 to "), "{refused:?}");
    }
}

#[test]
fn what_cannot_be_read_is_no_finding() {
    let folder = Folder::new("unreadable");
    for command in ["check", "info"] {
        let failed = run(&[command, &folder.file("nothing.fmu")]);
        assert!(failed.code == 2 && failed.error.contains("nothing.fmu"), "{}", failed.error);
    }
    let text = folder.write("text.fmu", "text");
    assert_eq!((run(&["check", &text]).code, run(&["info", &text]).code), (1, 2));
}

#[test]
fn a_binary_with_other_results_or_that_crashes_is_found_out() {
    let folder = Folder::new("results");
    let sound = build(&folder, "sound.fmu", &[]);
    let entries = entries_of(&sound);
    let check = |name: &str, contents: Vec<u8>, options: &[&str]| {
        let mut entries = entries.clone();
        entries.insert(name.to_owned(), contents);
        let path = folder.write("other.fmu", zip(&entries, Stored));
        let checked = run(&[&["check", &path], options].concat());
        (checked.code, checked.output)
    };
    let (code, output) = check("extra/org.fmi-standard.fmi-ls-ref/desk.csv", b"\"time\"\n".to_vec(), &[]);
    assert!(code == 1 && output.contains("desk.csv: the binary for this machine gives other results"), "{output}");
    // A C compiler makes the binaries: one that gets as far as being asked, and then aborts; and one that prints.
    #[cfg(target_os = "linux")]
    {
        let library = folder.compile("#include <stdlib.h>\nvoid *fmi2Instantiate(void) { abort(); }\n", &[]);
        let (name, library) = ("binaries/linux64/NewtonsCradle.so", fs::read(library).unwrap());
        let (code, output) = check(name, library.clone(), &[]);
        assert_eq!(code, 1);
        for expected in ["does not export fmi2CancelStep, ", "reference results: its binary crashed"] {
            assert!(output.contains(expected), "{output}");
        }
        assert!(!check(name, library, &["--no-load"]).1.contains("crashed"));
        let talk = "#include <stdio.h>\n__attribute__((constructor)) static void talk(void) { puts(\"Hello\"); }\n";
        let whole = super::support::library_path();
        let library = folder.compile(talk, &["-Wl,--no-as-needed", whole.to_str().unwrap()]);
        let (_, output) = check(name, fs::read(library).unwrap(), &[]);
        assert!(!output.contains("results") && !output.contains("nothing was run"), "{output}");
    }
}
