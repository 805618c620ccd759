//! The program away from the sources: binaries from an FMU, names of files, parameter sets and reference results, and
//! the Python that it hands over to, for which scripts stand in here. tests/hosts makes a page with a real one.

use std::fs;
use std::path::Path;
use std::process::Command;

use newtons_cradle::variables::Description;

use super::support::{
    Folder, PROGRAM, START, build, ended, entries_of, fmu, library, run, run_in, sound, text, warnings,
};

const REFERENCE: &str = "extra/org.fmi-standard.fmi-ls-ref";

#[test]
fn an_fmu_gives_its_binaries_and_licences() {
    let folder = Folder::new("from");
    let from = folder.write("NewtonsCradle.fmu", fmu(&Description::of(&START)));
    let built = run_in(&folder, &["build", "--from", "NewtonsCradle.fmu", "--balls", "13"]);
    assert_eq!((built.code, built.error.as_str()), (0, ""));
    let (taken, direct) = (folder.file("NewtonsCradle13.fmu"), build(&folder, "direct.fmu", &["--balls", "13"]));
    assert!(fs::read(&taken).unwrap() == fs::read(direct).unwrap());
    sound(&taken);
    let refused = run_in(&folder, &["build", "--from", "NewtonsCradle.fmu", "--set", "gravity=1"]);
    assert!(refused.code == 2 && refused.error.contains("give another file with --out"), "{}", refused.error);
    assert!(fs::read(from).unwrap() == fmu(&Description::of(&START)));
}

#[test]
fn what_is_replaced_is_told() {
    let folder = Folder::new("replaced");
    folder.write("x.fmu", "a letter");
    let told = |arguments: &[&str]| warnings(&folder, "x.fmu", arguments);
    assert!(told(&["--preset", "desk"]).contains("which was: 8 bytes, not an FMU"));
    let other = told(&["--balls", "7"]);
    assert!(other.contains("which was: preset desk, GUID {") && other.contains("}; now GUID {"), "{other}");
    assert!(told(&[]).contains("which was: n = 7, GUID {"));
    assert_eq!(told(&[]), "");
}

/// The layout of a virtual environment: `bin/cradle-fmu` and the package in `lib/python3.x/site-packages`.
#[cfg(unix)]
#[test]
fn an_installed_program_has_its_fmu_and_its_python() {
    let folder = Folder::new("environment");
    let package = "venv/lib/python3.11/site-packages/newtons_cradle";
    folder.write(&format!("{package}/NewtonsCradle.fmu"), fmu(&Description::of(&START)));
    folder.script("venv/bin/python3", "[ \"$1\" = -c ] && exit 0\nprintf '<%s>' \"$@\"");
    let program = folder.file("venv/bin/cradle-fmu");
    fs::copy(PROGRAM, &program).unwrap();
    let link = folder.file("cradle-fmu");
    std::os::unix::fs::symlink(&program, &link).unwrap();
    let started = |arguments: &[&str]| ended(Command::new(&link).args(arguments).current_dir(folder.file("")));

    let built = started(&["build", "--balls", "3"]);
    assert_eq!((built.code, built.error.as_str()), (0, ""));
    assert!(built.output.starts_with("NewtonsCradle3.fmu ("), "{}", built.output);
    assert!(built.output.contains(" page NewtonsCradle3.fmu\n"), "{}", built.output);
    assert_eq!(started(&["page", "NewtonsCradle3.fmu"]).output, "<-m><newtons_cradle><page><NewtonsCradle3.fmu>");
    assert_eq!(started(&["live", "--out", "x.html"]).output, "<-m><newtons_cradle><live><--out><x.html>");
}

#[cfg(unix)]
#[test]
fn arguments_and_exit_code_of_python_are_passed_on() {
    let folder = Folder::new("passed");
    let python = folder.script("python", "[ \"$1\" = -c ] && exit 0\nprintf '<%s>' \"$@\"\nexit 7");
    let passed = run(&["page", "--python", &python, "a b.fmu", "--out", "c.html", "--python", "x", "--help"]);
    assert_eq!(passed.output, "<-m><newtons_cradle><page><a b.fmu><--out><c.html><--python><x><--help>");
    assert_eq!((passed.code, passed.error.as_str()), (7, ""));
    // That of the virtual environment in a folder above: without a PATH no other Python is found.
    folder.script(".venv/bin/python", "printf %s \"$0\"");
    let here = Path::new(&folder.write("deep/down/x.fmu", "")).parent().unwrap().to_owned();
    let taken = ended(Command::new(PROGRAM).args(["page", "x.fmu"]).current_dir(here).env("PATH", ""));
    assert_eq!(taken.code, 0, "{}", taken.error);
    assert!(taken.output.ends_with("passed/.venv/bin/python"), "{}", taken.output);
    let bare = folder.script("bare", "exit 1");
    for (python, expected) in [(bare, "cannot import newtons_cradle; "), (folder.file("nothing"), "cannot run ")] {
        let failed = run(&["page", "--python", &python, "x.fmu"]);
        assert_eq!(failed.code, 1);
        for part in [expected, &python, "`pip install newtons-cradle`", "`python3 cradle.py paper`"] {
            assert!(failed.error.contains(part), "{}", failed.error);
        }
    }
}

#[test]
fn the_hint_after_a_build_works_as_it_stands() {
    let folder = Folder::new("a hint");
    let built = run_in(&folder, &["build", "--binary", &library(), "--out", "it's mine.fmu"]);
    assert_eq!(built.code, 0, "{}", built.error);
    let hint = built.output.lines().find_map(|line| line.strip_prefix("Try it: ")).unwrap();
    // From a file, as Windows' shell takes no quotation marks within an argument.
    let (name, shell) = if cfg!(windows) { ("hint.cmd", &["cmd", "/C"][..]) } else { ("hint.sh", &["sh"][..]) };
    let script = folder.write(name, hint);
    let tried = ended(Command::new(shell[0]).args(&shell[1..]).arg(script).current_dir(folder.file("")));
    assert_eq!(tried.code, 0, "{hint}: {}{}", tried.output, tried.error);
}

#[cfg(target_os = "linux")]
#[test]
fn an_fmu_for_other_machines_comes_without_a_hint() {
    const MACHINE: usize = 18; // its place in an ELF header
    let folder = Folder::new("foreign hint");
    let (platform, machine) = if cfg!(target_arch = "x86_64") { ("aarch64-linux", 183) } else { ("linux64", 62) };
    let mut library = fs::read(super::support::library_path()).unwrap();
    library[MACHINE] = machine;
    let binary = format!("{platform}={}", folder.write("other.so", library));
    let built = run(&["build", "--binary", &binary, "--out", &folder.file("other.fmu")]);
    assert_eq!(built.code, 0, "{}", built.error);
    assert!(built.output.contains("other.fmu (") && !built.output.contains("Try it"), "{}", built.output);
}

#[test]
fn parameter_sets_and_reference_results_are_in_the_fmu_and_beside_it() {
    let folder = Folder::new("reference");
    let beside = folder.file("beside");
    let five = build(&folder, "five.fmu", &["--preset", "figure5", "--reference", &beside]);
    let entries = entries_of(&five);
    let manifest = text(&entries, &format!("{REFERENCE}/fmi-ls-manifest.xml"));
    // Labels are new in it.
    assert!(manifest.contains("fmi-ls:fmi-ls-version=\"1.0.0-beta.1\"") && manifest.contains("<Label "), "{manifest}");
    let listed: Vec<&str> = manifest.split(" source=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert_eq!(listed.len(), 16, "{manifest}");
    for source in listed {
        let name = source.strip_prefix("../../").map_or_else(|| format!("{REFERENCE}/{source}"), str::to_owned);
        assert!(entries.contains_key(&name), "{name}");
    }
    // The FMU is made for Figure 5: what it does as it is, is what it does with that parameter set.
    let within = text(&entries, &format!("{REFERENCE}/start.csv"));
    assert_eq!(within, text(&entries, &format!("{REFERENCE}/figure5.csv")));
    let beside_it = |name: &str| fs::read_to_string(format!("{beside}/{name}")).unwrap();
    let finer = beside_it("five_ref.csv");
    let [within, finer] = [&within, &finer].map(|csv| csv.lines().collect::<Vec<_>>());
    assert_eq!((within.len(), finer.len()), (102, 1002));
    let names = ["time", "x[1]", "x[2]", "x[3]", "x[4]", "x[5]", "impulse[1]", "impulse[4]", "p_total", "E_total"];
    assert_eq!(within[0], names.map(|name| format!("\"{name}\"")).join(","));
    // The step does not matter.
    assert_eq!((within[0], within[101]), (finer[0], finer[1001]));
    let options = beside_it("five_ref.opt");
    assert!(options.starts_with("StartTime, 0\nStopTime, 10\nStepSize, 0.01\nRelTol, 1e-6\n"), "{options}");
    // An FMU of FMI 3.0 has the same binary and the same results beside it.
    build(&folder, "three.fmu", &["--fmi", "3", "--from", &five, "--preset", "figure5", "--reference", &beside]);
    assert_eq!(beside_it("three_ref.csv"), beside_it("five_ref.csv"));
}

/// In FMI 3.0 a set with arrays is one of SSP 2.0, and the others are as in FMI 2.0.
#[test]
fn an_fmu_of_fmi_3_has_parameter_sets_with_arrays() {
    let folder = Folder::new("arrays");
    let related = |name: &str, more: &[&str]| {
        let found = entries_of(build(&folder, name, more));
        let files = found.into_iter().filter_map(|(name, file)| Some((name.strip_prefix(REFERENCE)?.to_owned(), file)));
        files.collect::<std::collections::BTreeMap<_, _>>()
    };
    let (two, three) = (related("two.fmu", &[]), related("three.fmu", &["--fmi", "3"]));
    assert!(two.len() > 10 && two.keys().eq(three.keys()));
    for (name, file) in &two {
        let with_arrays = name.ends_with(".ssv") && file.contains(&b'[');
        assert_eq!(*file != three[name], with_arrays, "{name}");
    }
    let desk = String::from_utf8_lossy(&three["/desk.ssv"]);
    let array = "<ssv:Parameter name=\"x_start\"><ssv:Float64 value=\"-0.03 0 0 0 0\" unit=\"m\"/>\
                 <ssc:Dimension size=\"5\"/></ssv:Parameter>";
    assert!(desk.contains("version=\"2.0\"") && desk.contains(array), "{desk}");
    assert_eq!(related("scalars.fmu", &["--fmi", "3", "--scalars"]), two);
}

/// A C compiler makes the binary: one without the functions of FMI.
#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_recorded_are_missed_loudly() {
    let folder = Folder::new("missed");
    let other = folder.compile("int nothing(void) { return 0; }\n", &[]);
    let out = folder.file("x.fmu");
    let binary = library().split_once('=').map(|(platform, _)| format!("{platform}={other}")).unwrap();
    let told = warnings(&folder, "x.fmu", &["--binary", &binary]);
    assert!(told.contains("the FMU gets no reference results: start: fmi2Instantiate is not exported"), "{told}");
    let entries = entries_of(&out);
    assert!(entries.contains_key(&format!("{REFERENCE}/desk.ssv")));
    assert!(!entries.keys().any(|name| name.ends_with(".csv")));
    let manifest = text(&entries, &format!("{REFERENCE}/fmi-ls-manifest.xml"));
    assert!(!manifest.contains(".csv"), "{manifest}");
    let failed = run(&["build", "--binary", &binary, "--out", &out, "--reference", &folder.file("")]);
    assert!(failed.code == 1 && failed.error.contains("cannot make reference results: "), "{}", failed.error);
}

/// A folder as the sources are, and a script that stands in for cargo-zigbuild.
#[cfg(unix)]
#[test]
fn a_zigbuild_in_the_venv_of_the_sources_is_found() {
    let folder = Folder::new("sources");
    folder.write("src/lib.rs", "");
    folder.write("Cargo.toml", "[package]\nname = \"newtons-cradle\"\nversion = \"0.0.0\"\n[workspace]\n");
    folder.script(".venv/bin/cargo-zigbuild", "echo \"$@\" > arguments\nexit 1");
    let target = "x86_64-unknown-linux-gnu.2.17";
    let failed = run_in(&folder, &["build", "--target", target]);
    let advice = "needs `pip install ziglang cargo-zigbuild`";
    assert!(failed.code == 1 && failed.error.contains(advice), "{}", failed.error);
    let arguments = fs::read_to_string(folder.file("arguments")).unwrap();
    assert!(arguments.starts_with("zigbuild --package newtons-cradle ") && arguments.contains(target), "{arguments}");
}
