//! The program as a user runs it: what it writes, what it leaves behind when it cannot, and what it finds out by
//! running a binary.

use cradle_packaging::build::PRESETS;

use super::support::{BINARY, Folder, PROGRAM, ended, text, zip};

#[test]
fn start_values_go_into_description_and_resources() {
    let folder = Folder::new("start");
    let parameters = "balls = 3\nx_start = [-0.2, 0, 0]\n[contact]\nmodel = \"hertz\"\n'gap[1]' = 1e-6\n\
                      [solver]\ntolerance = 1e-9\n";
    folder.write("cradle.toml", parameters);
    let entries = folder.build("x.fmu", "--parameters cradle.toml --set solver.tolerance=1e-8");
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
    folder.sound("x.fmu").with(0, &["balls        3\n", "contact.model = hertz", "x_start[1] = -0.2 m"]);
}

#[test]
fn presets_are_told_in_the_help() {
    let folder = Folder::new("preset");
    let lines: Vec<String> = PRESETS.iter().map(|preset| format!("{:8} {}\n", preset.name, preset.title())).collect();
    let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
    folder.run("build --help").with(0, &lines);
    folder.run("presets").with(0, &lines);
}

#[test]
fn files_are_named_after_what_is_in_them() {
    let folder = Folder::new("names");
    folder.write("few/three.toml", "balls = 3");
    for (words, name) in [
        ("--preset desk", "desk"),
        ("--preset figure3", "figure3"),
        ("--balls 2", "NewtonsCradle2"),
        ("--preset desk --balls 5 --fmi 3", "desk.fmi3"),
        ("--parameters few/three.toml --balls 4", "three4"),
    ] {
        folder.run(&format!("build {BINARY} {words}")).with(0, &[&format!("{name}.fmu (")]);
        assert!(!folder.read(&format!("{name}.fmu")).is_empty());
    }
}

#[test]
fn a_target_that_cannot_be_written_leaves_nothing() {
    let folder = Folder::new("target");
    folder.write("folder/file", "");
    folder.run(&format!("build {BINARY} --out folder/file/x.fmu")).with(2, &["there is no folder "]);
    folder.run(&format!("build {BINARY} --out folder")).with(1, &["cannot write "]);
    assert_eq!(folder.list().len(), 1);
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_fmu() {
    let folder = Folder::new("full");
    folder.write("x.fmu", "old");
    // A limit on the size of files fails as a full disk does, in the middle of writing.
    let limited = folder.script("limited", &format!("trap '' XFSZ\nulimit -f 16\nexec '{PROGRAM}' \"$@\""));
    ended(&mut folder.command(&limited, &format!("build {BINARY} --out x.fmu"))).with(1, &["cannot write "]);
    assert_eq!(folder.read("x.fmu"), b"old");
    assert_eq!(folder.list().len(), 2);
}

#[test]
fn a_date_is_taken_from_the_environment() {
    let folder = Folder::new("date");
    let words = format!("build {BINARY} --out x.fmu");
    let build = |date: &str| ended(folder.command(PROGRAM, &words).env("SOURCE_DATE_EPOCH", date));
    build("253402300799").with(0, &[]);
    folder.run("info x.fmu").with(0, &["9999-12-31T23:59:59Z"]);
    for date in ["yesterday", "253402300800"] {
        build(date).with(2, &["allowed: 0 to "]);
    }
}

#[test]
fn what_cannot_be_read_is_no_finding() {
    let folder = Folder::new("unreadable");
    folder.write("text.fmu", "text");
    folder.run("check nothing.fmu").with(2, &["nothing.fmu"]);
    folder.run("info nothing.fmu").with(2, &["nothing.fmu"]);
    folder.run("check text.fmu").with(1, &[]);
    folder.run("info text.fmu").with(2, &[]);
}

#[test]
fn a_binary_with_other_results_or_that_crashes_is_found_out() {
    let folder = Folder::new("results");
    let sound = folder.build("sound.fmu", "");
    let check = |name: &str, contents: &[u8], option: &str| {
        let mut entries = sound.clone();
        entries.insert(name.to_owned(), contents.to_vec());
        folder.write("other.fmu", zip(&entries));
        folder.run(&format!("check other.fmu {option}"))
    };
    let other = "desk.csv: the binary for this machine gives other results";
    check("extra/org.fmi-standard.fmi-ls-ref/desk.csv", b"\"time\"\n", "").with(1, &[other]);
    // A C compiler makes the binaries: one that gets as far as being asked, and then aborts; and one that prints.
    #[cfg(target_os = "linux")]
    {
        let name = "binaries/linux64/NewtonsCradle.so";
        let library = folder.compile("#include <stdlib.h>\nvoid *fmi2Instantiate(void) { abort(); }\n", "");
        let crashed = ["does not export fmi2CancelStep, ", "reference results: its binary crashed"];
        check(name, &library, "").with(1, &crashed);
        assert!(!check(name, &library, "--no-load").output.contains("crashed"));
        let talk = "#include <stdio.h>\n__attribute__((constructor)) static void talk(void) { puts(\"Hello\"); }\n";
        let checked = check(name, &folder.compile(talk, "-Wl,--no-as-needed LIBRARY"), "").output;
        assert!(!checked.contains("results") && !checked.contains("nothing was run"), "{checked}");
    }
}
