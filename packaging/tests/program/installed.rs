//! The program away from the sources: binaries from an FMU, names of files, parameter sets and reference results, and
//! the Python that it hands over to, for which scripts stand in here. tests/hosts makes a page with a real one.

use newtons_cradle::variables::Description;

use super::support::{BINARY, Folder, PROGRAM, START, ended, fmu, text, zip};

const REFERENCE: &str = "extra/org.fmi-standard.fmi-ls-ref";

#[test]
fn build_from_an_fmu_takes_its_binaries_and_licences() {
    let folder = Folder::new("from");
    let from = zip(&fmu(&Description::of(&START)));
    folder.write("NewtonsCradle.fmu", &from);
    folder.run("build --from NewtonsCradle.fmu --balls 13").quiet();
    folder.build("direct.fmu", "--balls 13");
    assert!(folder.read("NewtonsCradle13.fmu") == folder.read("direct.fmu"));
    folder.sound("NewtonsCradle13.fmu");
    folder.run("build --from NewtonsCradle.fmu --set gravity=1").with(2, &["give another file with --out"]);
    assert!(folder.read("NewtonsCradle.fmu") == from);
}

#[test]
fn build_tells_what_it_replaces() {
    let folder = Folder::new("replaced");
    folder.write("x.fmu", "a letter");
    let build = |words: &str| folder.run(&format!("build {BINARY} --out x.fmu {words}"));
    build("--preset desk").with(0, &["which was: 8 bytes, not an FMU"]);
    build("--balls 7").with(0, &["which was: preset desk, GUID {", "}; now GUID {"]);
    build("").with(0, &["which was: n = 7, GUID {"]);
    build("").quiet();
}

/// The layout of a virtual environment: `bin/cradle-fmu` and the package in `lib/python3.x/site-packages`.
#[cfg(unix)]
#[test]
fn installed_program_has_its_fmu_and_its_python() {
    let folder = Folder::new("environment");
    let package = "venv/lib/python3.11/site-packages/newtons_cradle";
    folder.write(&format!("{package}/NewtonsCradle.fmu"), zip(&fmu(&Description::of(&START))));
    folder.script("venv/bin/python3", "[ \"$1\" = -c ] && exit 0\nprintf '<%s>' \"$@\"");
    let program = folder.file("venv/bin/cradle-fmu");
    // Written by another process: while this one writes it, a child that another test starts would keep it open.
    assert!(std::process::Command::new("cp").args([PROGRAM, &program]).status().unwrap().success());
    let link = folder.file("cradle-fmu");
    std::os::unix::fs::symlink(&program, &link).unwrap();
    let run = |words: &str| ended(&mut folder.command(&link, words));

    let built = run("build --balls 3").quiet().with(0, &[" page NewtonsCradle3.fmu\n"]);
    assert!(built.output.starts_with("NewtonsCradle3.fmu ("), "{}", built.output);
    assert_eq!(run("page NewtonsCradle3.fmu").output, "<-m><newtons_cradle><page><NewtonsCradle3.fmu>");
    assert_eq!(run("live --out x.html").output, "<-m><newtons_cradle><live><--out><x.html>");
}

#[cfg(unix)]
#[test]
fn installed_program_passes_on_arguments_and_exit_codes() {
    let folder = Folder::new("passed");
    folder.script("python", "[ \"$1\" = -c ] && exit 0\nprintf '<%s>' \"$@\"\nexit 7");
    let given = ["a b.fmu", "--out", "c.html", "--help"];
    // Wherever it stands; behind `--` it is an argument like others.
    for (before, behind, rest) in [
        ("--python ./python page", &[][..], ""),
        ("page --python ./python", &[], ""),
        ("page --python=./python", &[], ""),
        ("page --python ./nothing", &["--python", "./python"], ""),
        ("page", &["--python=./python", "--", "--python", "x"], "<--python><x>"),
    ] {
        let passed = ended(folder.command(PROGRAM, before).args(given).args(behind));
        assert_eq!(passed.output, format!("<-m><newtons_cradle><page><a b.fmu><--out><c.html><--help>{rest}"));
        assert_eq!((passed.code, passed.error.as_str()), (7, ""));
    }
    let passed = ended(&mut folder.command(PROGRAM, "--python ./python judge -- --python x"));
    assert_eq!(passed.output, "<-m><newtons_cradle><judge><--python><x>");
    folder.run("page x.fmu --python").with(2, &["--python needs the name of a program"]);
    folder.run("--python ./python presets").with(2, &["allowed: for page, live, cases and judge"]);
    // That of the virtual environment in a folder above: without a PATH no other Python is found.
    folder.script(".venv/bin/python", "printf %s \"$0\"");
    folder.write("deep/down/x.fmu", "");
    let mut page = folder.command(PROGRAM, "page x.fmu");
    let taken = ended(page.current_dir(folder.file("deep/down")).env("PATH", "")).with(0, &[]);
    assert!(taken.output.ends_with("passed/.venv/bin/python"), "{}", taken.output);
    folder.script("killed", "[ \"$1\" = -c ] && exit 0\nkill -9 $$");
    folder.run("page --python ./killed x.fmu").with(1, &["./killed has ended early: signal: 9"]);
    folder.script("bare", "exit 1");
    for (python, expected) in [("./bare", "cannot import newtons_cradle; "), ("./nothing", "cannot run ")] {
        let cures = ["`pip install newtons-cradle`", "`python3 cradle.py paper`"];
        folder.run(&format!("page --python {python} x.fmu")).with(1, &[expected, python, cures[0], cures[1]]);
        // A code of 1 would be a verdict.
        folder.run(&format!("judge --python {python} x")).with(2, &[expected, python, cures[0], cures[1]]);
    }
}

#[test]
fn build_ends_with_a_hint_that_works() {
    let folder = Folder::new("a hint");
    let built = ended(folder.command(PROGRAM, &format!("build {BINARY} --out")).arg("it's mine.fmu")).quiet();
    let hint = built.output.lines().find_map(|line| line.strip_prefix("Try it: ")).unwrap();
    // From a file, as Windows' shell takes no quotation marks within an argument.
    let (name, shell, option) = if cfg!(windows) { ("hint.cmd", "cmd", "/C") } else { ("hint.sh", "sh", "") };
    folder.write(name, hint);
    ended(&mut folder.command(shell, &format!("{option} {name}"))).with(0, &[]);
}

#[cfg(target_os = "linux")]
#[test]
fn build_for_other_machines_gives_no_hint() {
    const MACHINE: usize = 18; // its place in an ELF header
    let folder = Folder::new("machines");
    let mut library = std::fs::read(super::support::library_path()).unwrap();
    for (name, machine) in [("intel.so", 62), ("arm.so", 183)] {
        library[MACHINE] = machine;
        folder.write(name, &library);
    }
    let other = if cfg!(target_arch = "x86_64") { "aarch64-linux=arm.so" } else { "linux64=intel.so" };
    let built = folder.run(&format!("build --binary {other} --out other.fmu")).with(0, &["other.fmu ("]);
    assert!(!built.output.contains("Try it"), "{}", built.output);
    // FMUs of FMI 2.0 may have Linux on ARM in two folders, those of FMI 3.0 in one.
    let twice = "build --fmi 3 --out arm.fmu --binary linux64=arm.so --binary aarch64-linux=";
    folder.run(&format!("{twice}arm.so")).with(0, &[]);
    assert!(folder.entries("arm.fmu")["binaries/aarch64-linux/NewtonsCradle.so"] == library);
    library.push(0);
    folder.write("longer.so", library);
    let refused = folder.run(&format!("{twice}longer.so"));
    refused.with(1, &["two different shared libraries are for binaries/aarch64-linux/"]);
}

#[test]
fn reference_results_are_in_the_fmu_and_beside_it() {
    let folder = Folder::new("reference");
    let entries = folder.build("five.fmu", "--preset figure5 --reference beside");
    let manifest = text(&entries, &format!("{REFERENCE}/fmi-ls-manifest.xml"));
    // Labels are new in it.
    assert!(manifest.contains("fmi-ls:fmi-ls-version=\"1.0.0-beta.1\"") && manifest.contains("<Label "), "{manifest}");
    // The FMU is made for Figure 5: what it does as it is, it, or the default one, does with that parameter set.
    let within = text(&entries, &format!("{REFERENCE}/start.csv"));
    assert_eq!(within, text(&entries, &format!("{REFERENCE}/figure5.csv")));
    assert_eq!(within, text(&folder.build("default.fmu", ""), &format!("{REFERENCE}/figure5.csv")));
    let beside = |name: &str| String::from_utf8(folder.read(&format!("beside/{name}"))).unwrap();
    let finer = beside("five_ref.csv");
    let [within, finer] = [&within, &finer].map(|csv| csv.lines().collect::<Vec<_>>());
    assert_eq!((within.len(), finer.len()), (102, 1002));
    let names = ["time", "x[1]", "x[2]", "x[3]", "x[4]", "x[5]", "impulse[1]", "impulse[4]", "p_total", "E_total"];
    assert_eq!(within[0], names.map(|name| format!("\"{name}\"")).join(","));
    // The step does not matter.
    assert_eq!((within[0], within[101]), (finer[0], finer[1001]));
    let options = beside("five_ref.opt");
    assert!(options.starts_with("StartTime, 0\nStopTime, 10\nStepSize, 0.01\nRelTol, 1e-6\n"), "{options}");
    // An FMU of FMI 3.0 has the same binary and the same results beside it.
    folder.build("three.fmu", "--fmi 3 --from five.fmu --preset figure5 --reference beside");
    assert_eq!(beside("three_ref.csv"), beside("five_ref.csv"));
}

/// In FMI 3.0 a set with arrays is one of SSP 2.0, and the others are as in FMI 2.0.
#[test]
fn reference_parameter_sets_of_fmi_3_have_arrays() {
    let folder = Folder::new("arrays");
    let related = |name: &str, words: &str| {
        let mut files = folder.build(name, words);
        files.retain(|name, _| name.starts_with(REFERENCE));
        files
    };
    let (two, three) = (related("two.fmu", ""), related("three.fmu", "--fmi 3"));
    assert!(two.len() > 10 && two.keys().eq(three.keys()));
    for (name, file) in &two {
        let with_arrays = name.ends_with(".ssv") && file.contains(&b'[');
        assert_eq!(*file != three[name], with_arrays, "{name}");
    }
    let desk = text(&three, &format!("{REFERENCE}/desk.ssv"));
    let array = "<ssv:Parameter name=\"x_start\"><ssv:Float64 value=\"-0.03 0 0 0 0\" unit=\"m\"/>\
                 <ssc:Dimension size=\"5\"/></ssv:Parameter>";
    assert!(desk.contains("version=\"2.0\"") && desk.contains(array), "{desk}");
    assert_eq!(related("scalars.fmu", "--fmi 3 --scalars"), two);
}

/// The others are still there, and the binary takes the description for its own.
#[test]
fn build_offers_real_outputs_for_hosts_that_know_no_others() {
    let folder = Folder::new("real");
    let named = |text: &str, part: &str| -> Vec<String> {
        let variables = text.split("<ModelVariables>").nth(1).unwrap().split("</ModelVariables>").next().unwrap();
        let lines = variables.split("name=\"").skip(1).filter(|variable| variable.contains(part));
        lines.map(|variable| variable.split('"').next().unwrap().to_owned()).collect()
    };
    for words in ["", "--fmi 3", "--fmi 3 --scalars"] {
        let [plain, real] = ["", "--real-outputs"].map(|option| {
            let entries = folder.build(&format!("x{option}.fmu"), &format!("{words} {option}"));
            text(&entries, "modelDescription.xml")
        });
        folder.sound("x--real-outputs.fmu");
        std::fs::remove_file(folder.file("x.fmu")).unwrap();
        std::fs::remove_file(folder.file("x--real-outputs.fmu")).unwrap();
        let (before, after) = (named(&plain, "causality=\"output\""), named(&real, "causality=\"output\""));
        let others = ["pulses", "inContact", "log.", "onset.", "release."];
        let expected: Vec<_> =
            before.iter().filter(|name| others.iter().all(|other| !name.starts_with(other))).cloned().collect();
        assert_eq!(after, expected, "{words}");
        let locals = named(&real, "causality=\"local\"");
        assert!(locals.iter().any(|name| name.starts_with("pulses")), "{words}");
    }
}

/// The start values contain a force that no string bears; the presets run without it.
#[test]
fn reference_case_that_cannot_run_is_left_out_with_the_reason() {
    let folder = Folder::new("slack");
    let said = folder.run(&format!("build {BINARY} --preset desk --set F_ext[1]=5 --out x.fmu")).with(0, &[]);
    let reason = "the FMU gets no reference results of start: fmi2DoStep: the run cannot go on: the string of ball 1 ";
    assert!(said.error.contains(reason) && said.error.matches("warning").count() == 1, "{}", said.error);
    folder.sound("x.fmu");
    let entries = folder.entries("x.fmu");
    assert!(!entries.keys().any(|name| name.starts_with(&format!("{REFERENCE}/start"))));
    assert!(!text(&entries, &format!("{REFERENCE}/fmi-ls-manifest.xml")).contains("start"));
    let with_force = folder.build("light.fmu", "--set F_ext[1]=0.1");
    let plain = folder.build("plain.fmu", "");
    for file in ["desk.csv", "textbook.csv"] {
        let [slack, light, plain] = [&entries, &with_force, &plain].map(|of| text(of, &format!("{REFERENCE}/{file}")));
        assert!(slack == plain && light == plain, "{file}");
    }
    let set = |name: &str| text(&with_force, &format!("{REFERENCE}/{name}.ssv"));
    assert!(set("start").contains("<ssv:Parameter name=\"F_ext[1]\"><ssv:Real value=\"0.1\" unit=\"N\"/>"));
    assert!(set("desk").contains("<ssv:Parameter name=\"F_ext[1]\"><ssv:Real value=\"0\" unit=\"N\"/>"));
    assert_ne!(text(&with_force, &format!("{REFERENCE}/start.csv")), text(&plain, &format!("{REFERENCE}/start.csv")));
}

/// A C compiler makes the binary: one without the functions of FMI.
#[cfg(target_os = "linux")]
#[test]
fn reference_results_that_cannot_be_recorded_are_named() {
    let folder = Folder::new("missed");
    folder.compile("int nothing(void) { return 0; }\n", "");
    let reason = "the FMU gets no reference results: fmi2Instantiate is not exported";
    folder.run("build --binary HOST=x.so --out x.fmu").with(0, &[reason]);
    let entries = folder.entries("x.fmu");
    assert!(entries.contains_key(&format!("{REFERENCE}/desk.ssv")));
    assert!(!entries.keys().any(|name| name.ends_with(".csv")));
    let manifest = text(&entries, &format!("{REFERENCE}/fmi-ls-manifest.xml"));
    assert!(!manifest.contains(".csv"), "{manifest}");
    let failed = folder.run("build --binary HOST=x.so --out x.fmu --reference .");
    failed.with(1, &["cannot make reference results: "]);
}

/// A folder as the sources are, and a script that stands in for cargo-zigbuild.
#[cfg(unix)]
#[test]
fn build_links_old_glibc_by_zigbuild() {
    let folder = Folder::new("sources");
    folder.write("Cargo.toml", "[package]\nname = \"newtons-cradle\"\n");
    folder.script("cargo-zigbuild", "echo \"$@\" > arguments\nexit 1");
    let target = "x86_64-unknown-linux-gnu.2.17";
    let path = format!("{}:{}", folder.file(""), std::env::var("PATH").unwrap());
    let advice = "needs `pip install ziglang cargo-zigbuild`";
    ended(folder.command(PROGRAM, &format!("build --target {target}")).env("PATH", path)).with(1, &[advice]);
    for triple in ["linux", "riscv64gc-unknown-linux-gnu", "wasm32-unknown-unknown"] {
        let allowed = ["allowed: x86_64-*-linux, ", "i686-*-linux, x86_64-*-windows, "];
        folder.run(&format!("build --target {triple}")).with(2, &allowed);
    }
    let arguments = String::from_utf8(folder.read("arguments")).unwrap();
    assert!(arguments.starts_with("zigbuild --package newtons-cradle ") && arguments.contains(target), "{arguments}");
}
