//! The program as a user runs it: what it writes, what it finds out by running a binary, and what it says to wrong
//! arguments, none of which leaves anything behind.

use cradle_packaging::build::PRESETS;
use newtons_cradle::variables::Description;

use super::support::{BINARY, Folder, PROGRAM, START, ended, fmu, text, zip};

#[test]
fn build_puts_start_values_into_description_and_resources() {
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
fn help_lists_presets() {
    let folder = Folder::new("preset");
    let lines: Vec<String> = PRESETS.iter().map(|preset| format!("{:8} {}\n", preset.name, preset.title())).collect();
    let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
    folder.run("build --help").with(0, &lines);
    folder.run("presets").with(0, &lines);
}

#[test]
fn build_names_files_after_their_contents() {
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
fn build_to_a_target_that_cannot_be_written_leaves_nothing() {
    let folder = Folder::new("target");
    folder.write("folder/file", "");
    folder.run(&format!("build {BINARY} --out folder/file/x.fmu")).with(2, &["there is no folder "]);
    folder.run(&format!("build {BINARY} --out folder")).with(2, &["cannot write folder: it is a folder; allowed: "]);
    assert_eq!(folder.list().len(), 1);
}

/// A device may have no end, and a pipe waits for its other end. Neither is replaced; the target of a link is.
#[cfg(unix)]
#[test]
fn build_reads_and_replaces_only_regular_files() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    use std::{fs, thread};

    let folder = Folder::new("devices");
    ended(&mut folder.command("mkfifo", "pipe")).with(0, &[]);
    symlink("/dev/null", folder.file("link")).unwrap();
    let kinds = || ["pipe", "link"].map(|name| fs::symlink_metadata(folder.file(name)).unwrap().file_type());
    for words in [
        "check NAME",
        "info NAME",
        "build --out x.fmu --from NAME",
        "build --out x.fmu --binary HOST=NAME",
        "build --out x.fmu --binary HOST=LIBRARY --parameters NAME",
        "build --binary HOST=LIBRARY --out NAME",
    ] {
        let refused = |name: &str| {
            let words = words.replace("NAME", name);
            let reason = format!("{name}: it is a device, a pipe or a socket; allowed: a regular file");
            folder.run(&words).with(2, &[&reason]);
        };
        refused("link");
        let pipe = folder.file("pipe");
        // Were the pipe opened, this would be what is read.
        let writer = thread::spawn(move || fs::write(pipe, "text"));
        refused("pipe");
        assert_eq!(folder.read("pipe"), b"text", "{words}");
        writer.join().unwrap().unwrap();
        assert!(kinds()[0].is_fifo() && kinds()[1].is_symlink() && folder.list().len() == 2, "{words}");
    }
    symlink("x.fmu", folder.file("to.fmu")).unwrap();
    folder.write("x.fmu", "old");
    folder.run(&format!("build {BINARY} --out to.fmu")).with(0, &["which was: 3 bytes, not an FMU"]);
    assert!(
        fs::symlink_metadata(folder.file("to.fmu")).unwrap().is_symlink() && folder.read("x.fmu").starts_with(b"PK")
    );
}

/// Its binary waits for ever, so that the program is in the midst of it.
#[cfg(target_os = "linux")]
#[test]
fn build_that_is_ended_leaves_no_temporary_files() {
    use std::os::unix::process::CommandExt;
    use std::time::{Duration, Instant};
    use std::{fs, thread};

    let folder = Folder::new("ended");
    folder.compile("#include <unistd.h>\nvoid *fmi2Instantiate(void) { for (;;) pause(); }\n", "");
    fs::create_dir(folder.file("temporary")).unwrap();
    let is_empty = || fs::read_dir(folder.file("temporary")).unwrap().next().is_none();
    let until = |what: &str, holds: &dyn Fn() -> bool| {
        let begin = Instant::now();
        while !holds() {
            assert!(begin.elapsed() < Duration::from_secs(50), "{what}"); // before the run itself is given up
            thread::sleep(Duration::from_millis(5));
        }
    };
    for signal in ["INT", "TERM", "KILL"] {
        // A shell may have started these tests with signals that they ignore, which the program would inherit.
        let mut build = folder.command("env", "--default-signal PROGRAM build --binary HOST=x.so --out x.fmu");
        let mut build = build.env("TMPDIR", folder.file("temporary")).process_group(0).spawn().unwrap();
        until("no temporary files", &|| !is_empty());
        // To all of its group, as a terminal does.
        ended(&mut folder.command("kill", &format!("-s {signal} -- -{}", build.id()))).with(0, &[]);
        assert!(!build.wait().unwrap().success());
        until(signal, &is_empty);
    }
    assert!(!fs::exists(folder.file("x.fmu")).unwrap());
}

#[cfg(unix)]
#[test]
fn build_on_a_full_disk_leaves_the_old_fmu() {
    let folder = Folder::new("full");
    folder.write("x.fmu", "old");
    // A limit on the size of files fails as a full disk does, in the middle of writing.
    let limited = folder.script("limited", &format!("trap '' XFSZ\nulimit -f 16\nexec '{PROGRAM}' \"$@\""));
    ended(&mut folder.command(&limited, &format!("build {BINARY} --out x.fmu"))).with(1, &["cannot write "]);
    assert_eq!(folder.read("x.fmu"), b"old");
    assert_eq!(folder.list().len(), 2);
}

/// Who reads only the first line closes the pipe; a full disk is one line.
#[cfg(target_os = "linux")]
#[test]
fn output_into_a_closed_pipe_ends_quietly_and_a_full_disk_with_a_line() {
    let folder = Folder::new("output");
    folder.build("x.fmu", "");
    for words in ["presets", "--help", "build --help", "info x.fmu", "check x.fmu", "build --binary HOST=LIBRARY"] {
        let run = |redirected: &str| {
            let script = folder.script("redirected", &format!("exec '{PROGRAM}' \"$@\" {redirected}"));
            ended(&mut folder.command(&script, words))
        };
        let full = run("> /dev/full");
        assert_eq!((full.code, full.output.as_str()), (1, ""), "{words}");
        let line = "error: cannot write to standard output: No space left on device (os error 28)";
        assert_eq!(full.error.lines().last(), Some(line), "{words}");
        assert_eq!(run("> /dev/full 2> /dev/full").code, 1, "{words}");
        // The other end of this pipe is closed before the program writes.
        let closed = folder.script("closed", &format!("(sleep 0.2; exec '{PROGRAM}' \"$@\") | : ; wait"));
        let closed = ended(&mut folder.command(&closed, words));
        assert!(!closed.error.contains("error") && !closed.error.contains("panicked"), "{words}: {}", closed.error);
    }
    let refused = folder.script("refused", &format!("exec '{PROGRAM}' info nothing.fmu 2> /dev/full"));
    assert_eq!(ended(&mut folder.command(&refused, "")).code, 2);
}

/// The item's name and its number give the same FMU.
#[test]
fn build_takes_enumerations_by_name_or_number() {
    let folder = Folder::new("items");
    folder.write("named.toml", "contact.model = \"hertz\"");
    folder.write("numbered.toml", "contact.model = 2");
    folder.write("wrong.toml", "contact.model = 2.5");
    let named = folder.build("a.fmu", "--parameters named.toml");
    for words in ["--parameters numbered.toml", "--set contact.model=2", "--set contact.model=hertz"] {
        assert!(named == folder.build("b.fmu", words), "{words}");
        std::fs::remove_file(folder.file("b.fmu")).unwrap();
    }
    let allowed = ["is refused; allowed: powerLaw (1) or hertz (2) or rigid (3)"];
    for words in ["--parameters wrong.toml", "--set contact.model=4", "--set contact.model=-1"] {
        folder.run(&format!("build {BINARY} {words} --out x.fmu")).with(2, &allowed);
    }
}

/// The FMU is right, but this machine cannot run it: that is no problem of the FMU.
#[cfg(target_os = "linux")]
#[test]
fn temporary_folder_of_no_use_is_named() {
    let folder = Folder::new("temporary");
    folder.build("x.fmu", "");
    std::fs::create_dir(folder.file("small")).unwrap();
    let check = |command: &mut std::process::Command, reason: &str| {
        let checked = ended(command).with(0, &["0 problem(s)", "nothing was run: this machine cannot run the FMU: "]);
        assert!(checked.output.contains(reason), "{}", checked.output);
        assert!(checked.output.contains("; TMPDIR selects another temporary folder\n"), "{}", checked.output);
    };
    let missing = "/nothing: No such file or directory".split_once(':').unwrap();
    check(folder.command(PROGRAM, "check x.fmu").env("TMPDIR", missing.0), missing.1);
    let limited = folder.script("limited", &format!("trap '' XFSZ\nulimit -f 16\nexec '{PROGRAM}' \"$@\""));
    check(folder.command(&limited, "check x.fmu").env("TMPDIR", folder.file("small")), "File too large");
    // A file system of its own, where this user may mount one.
    let mount = |options: &str| {
        let mount = format!("mount -t tmpfs -o {options} none small && TMPDIR=small exec '{PROGRAM}' check x.fmu");
        let script = folder.script("mounted", &mount);
        folder.command("unshare", &format!("-rm {script}"))
    };
    let may_mount = ended(&mut folder.command("unshare", "-rm mount -t tmpfs none small")).code == 0;
    for (options, reason) in
        [("noexec", "programs there are not run (noexec)"), ("size=100k", "No space left on device")]
    {
        if may_mount {
            check(&mut mount(options), reason);
        }
    }
}

#[test]
fn build_takes_its_date_from_the_environment() {
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
fn check_of_what_cannot_be_read_is_no_finding() {
    let folder = Folder::new("unreadable");
    folder.write("text.fmu", "text");
    folder.run("check nothing.fmu").with(2, &["nothing.fmu"]);
    folder.run("info nothing.fmu").with(2, &["nothing.fmu"]);
    folder.run("check text.fmu").with(1, &[]);
    folder.run("info text.fmu").with(2, &[]);
}

#[test]
fn check_finds_binaries_with_other_results_or_crashes() {
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
        let source = "const char *source = \"/srv/build/src/x.rs\";\n";
        let built = folder.compile(source, "-Wl,-soname,/srv/build/libx.so -Wl,-rpath,/opt/lib");
        let path = "holds a path of the machine it was built on: ";
        let paths = ["/srv/build/src/x.rs", "/srv/build/libx.so", "/opt/lib"].map(|own| format!("{path}{own}\n"));
        check(name, &built, "").with(1, &paths.each_ref().map(String::as_str));
        let talk = "#include <stdio.h>\n__attribute__((constructor)) static void talk(void) { puts(\"Hello\"); }\n";
        let checked = check(name, &folder.compile(talk, "-Wl,--no-as-needed LIBRARY"), "").output;
        assert!(!checked.contains("results") && !checked.contains("nothing was run"), "{checked}");
    }
}

#[test]
fn build_names_what_it_refuses_and_leaves_nothing() {
    let folder = Folder::new("refused");
    folder.write("bad.toml", "x_start = [1, true]");
    folder.write("torn.toml", "balls = ");
    folder.write("quoted.toml", "pendulum.length = \"0.2\"");
    folder.write("twice.toml", "\"contact.model\" = \"rigid\"\ncontact.model = \"hertz\"");
    folder.write("element.toml", "x_start = [-0.1, 0, 0, 0, 0]\n\"x_start[2]\" = 0.1");
    folder.write("real.toml", "balls = 3.0");
    folder.write("latin.toml", b"balls = 3 # \xfc");
    folder.write("text.fmu", "text");
    let sound = fmu(&Description::of(&START));
    let changed = |name: &str, from: &str, to: &str| {
        let description = text(&sound, "modelDescription.xml");
        assert!(description.contains(from));
        let mut entries = sound.clone();
        entries.insert("modelDescription.xml".to_owned(), description.replacen(from, to, 1).into_bytes());
        folder.write(name, zip(&entries));
    };
    let tool = concat!("newtons-cradle ", env!("CARGO_PKG_VERSION"));
    changed("foreign.fmu", "modelName=\"NewtonsCradle\"", "modelName=\"BouncingBall\"");
    changed("old.fmu", tool, "newtons-cradle 0.0.9");
    changed("changed.fmu", " start=\"9.81\"", " start=\"9.8\"");
    let written = |what: &str, by: &str| format!("it is \"{what}\", written by {by}; allowed: NewtonsCradle of {tool}");
    let foreign = format!("--from foreign.fmu is refused: {}", written("BouncingBall", tool));
    let old = format!("--from old.fmu is refused: {}", written("NewtonsCradle", "newtons-cradle 0.0.9"));
    let changed = "--from changed.fmu is refused: modelDescription.xml: not the description that belongs to its GUID";
    let other = if cfg!(windows) { "linux64" } else { "win64" };
    let for_other = format!("--binary {other}=LIBRARY");
    let no_library = format!("is not a shared library for {other}, but a ");
    let cases: &[(&str, &str)] = &[
        ("--bals 13", "a similar argument exists: '--balls'"),
        ("--balls 0", "balls = 0 is refused; allowed: 1 to 10000"),
        ("--balls 1000000000", "balls = 1000000000 is refused"),
        ("--balls -1", "--balls"),
        ("--set nothing=1", "--set nothing=1: no variable has the name \"nothing\"; allowed: gravity, "),
        ("--set contact.stifness=1e9", "\"contact.stifness\"; did you mean \"contact.stiffness\"?"),
        ("--set radius=0.01", "no variable has the name \"radius\"; did you mean \"ball.radius\"?"),
        ("--set xstart=0.01", "no variable has the name \"xstart\"; did you mean \"x_start\"?"),
        ("--set Gravity=1", "no variable has the name \"Gravity\"; did you mean \"gravity\"?"),
        ("--set T=1", "no variable has the name \"T\"; allowed: gravity, "),
        ("--set E_total=1", "E_total cannot be set, because its causality is output"),
        ("--set x=0.1", "--set x=0.1: x cannot be set, because its causality is output; x_start[i] is the posit"),
        ("--set gravity[1]=1", "gravity is a single value and takes no index"),
        (
            "--set x_start[7]=0.1",
            "--set x_start[7]=0.1: x_start[7]: index 7 is refused; allowed: 1 to 5, in a cradle of 5 ball(s)",
        ),
        ("--balls 1 --set contact.gap[1]=0", "index 1 is refused; there are none, in a cradle of 1 ball("),
        ("--balls 7 --preset desk --set v_start=0,0,0,0,0,0,0", "preset desk is of 5 balls, not 7; "),
        ("--set x_start=0,0", "x_start takes a list of 5 value(s)"),
        ("--set gravity=1,2", "gravity takes one value, not 2; write decimals with a point"),
        ("--set ball.mass=1kg", "--set ball.mass=1kg: ball.mass = 1kg is refused: leave the unit out, 1 is in kg"),
        ("--set ball.mass=-1", "--set ball.mass=-1: ball.mass = -1 kg is refused; allowed: finite and > 0 kg"),
        ("--set ball.mass=inf", "allowed: finite and > 0 kg"),
        ("--set ball.mass=0x10", "ball.mass = 0x10 is refused; allowed: a decimal number"),
        ("--set ball.mass=0bar", "ball.mass = 0bar is refused: leave the unit out, 0 is in kg"),
        ("--set ball.mass=5m/s2", "ball.mass = 5m/s2 is refused: leave the unit out, 5 is in kg"),
        ("--set ball.mass=heavy", "--set ball.mass=heavy: ball.mass = heavy is refused; allowed: a number"),
        ("--set x_start=[-0.1,0,0,0,0]", "x_start = [-0.1 is refused: write the list without brackets"),
        ("--set contact.model=glue", "contact.model = glue is refused; allowed: powerLaw (1) or hertz (2) or r"),
        ("--set contact.model=4", "contact.model = 4 is refused; allowed: powerLaw (1)"),
        ("--set gravity", "allowed: name=value"),
        ("--preset nothing", "there is no preset \"nothing\"; allowed: textbook, "),
        ("--preset dest", "there is no preset \"dest\"; did you mean \"desk\"?; allowed: textbook, figure3, "),
        ("--parameters bad.toml", "bad.toml: x_start = true is refused; allowed: a number, the name of an item, or a"),
        ("--parameters real.toml", "real.toml: balls = 3.0 is refused; allowed: a whole number from 1 to 10000"),
        (
            "--parameters twice.toml",
            "twice.toml: contact.model is given twice, as contact.model and as \"contact.model\"; allowed: once",
        ),
        ("--parameters element.toml", "x_start[2] is given twice, as x_start and as \"x_start[2]\"; allowed: once"),
        ("--parameters latin.toml", "cannot read latin.toml: it is not in UTF-8"),
        ("--parameters torn.toml", "torn.toml: "),
        ("--parameters quoted.toml", "pendulum.length = 0.2 is refused: write the number without quotes"),
        ("--parameters nowhere.toml", "cannot read nowhere.toml"),
        ("--from nowhere.fmu", "cannot read nowhere.fmu"),
        ("--from text.fmu", "--from text.fmu is refused: zip: "),
        ("--from foreign.fmu", &foreign),
        ("--from old.fmu", &old),
        ("--from changed.fmu", changed),
        ("--out nowhere/x.fmu", "--out: there is no folder nowhere"),
        ("--clocks none", "--clocks none is refused: FMI 2.0 has no clocks"),
        ("--binary linux46=x.so", "--binary linux46=x.so is refused: allowed platforms: linux64, "),
        ("--binary x", "allowed: PLATFORM=FILE"),
        ("--binary linux64=bad.toml", "is not a shared library for linux64"),
        (&for_other, &no_library),
        ("--binary win32=nowhere/x.dll", "--binary win32: cannot read nowhere/x.dll"),
        ("--scalars", "--scalars is refused: FMI 2.0 has no arrays; allowed: together with --fmi 3"),
    ];
    let before = folder.list();
    for (words, expected) in cases {
        let out = if words.contains("--out") { "" } else { "--out x.fmu" };
        // A good binary beside it, so that nothing is compiled if the argument is accepted.
        let binary = if words.contains("linux64=bad") { "" } else { BINARY };
        folder.run(&format!("build {out} {binary} {words}")).with(2, &[expected]);
        assert_eq!(folder.list(), before, "{words}");
    }
}

#[test]
fn build_without_sources_and_an_fmu_says_what_to_do() {
    let folder = Folder::new("bare");
    let cures = ["--from", "`pip install newtons-cradle`", "the folder of the sources"];
    folder.run("build --balls 13").with(1, &["there is no binary to pack", cures[0], cures[1], cures[2]]);
    folder.run("build --target x86_64-unknown-linux-gnu").with(1, &["to compile, run this in ", cures[2]]);
    assert!(folder.list().is_empty());
}
