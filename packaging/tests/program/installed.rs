//! The program away from the sources: binaries from an FMU, names of files, parameter sets and reference results.

use std::fs;
use std::path::Path;

use super::support::{Folder, entries, fmu, library, output, run, run_in};
use cradle_packaging::archive::Entries;

const REFERENCE: &str = "extra/org.fmi-standard.fmi-ls-ref";

fn read(path: &str) -> Entries {
    entries(&fs::read(path).unwrap())
}

/// The default FMU in a file.
fn packed(folder: &Folder) -> String {
    let out = folder.file("NewtonsCradle.fmu");
    fs::write(&out, fmu()).unwrap();
    out
}

#[test]
fn an_fmu_gives_its_binaries_and_licences() {
    let folder = Folder::new("from");
    let from = packed(&folder);
    let here = folder.file("");
    let built = run_in(&here, &["build", "--from", "NewtonsCradle.fmu", "--balls", "13"]);
    assert_eq!((built.code, built.error.as_str()), (0, ""));
    let direct = run(&["build", "--binary", &library(), "--balls", "13", "--out", &folder.file("direct.fmu")]);
    assert_eq!(direct.code, 0, "{}", direct.error);
    let (taken, direct) = (folder.file("NewtonsCradle13.fmu"), folder.file("direct.fmu"));
    assert!(fs::read(&taken).unwrap() == fs::read(direct).unwrap());
    assert_eq!(run(&["check", &taken]).code, 0);
    let refused = run_in(&here, &["build", "--from", "NewtonsCradle.fmu", "--set", "gravity=1"]);
    assert!(refused.code == 2 && refused.error.contains("give another file with --out"), "{}", refused.error);
    assert!(fs::read(from).unwrap() == fmu());
}

#[test]
fn files_are_named_after_what_is_in_them_and_the_default_stays() {
    let folder = Folder::new("names");
    let from = packed(&folder);
    let before = fs::read(&from).unwrap();
    fs::write(folder.file("mine.toml"), "gravity = 1.62").unwrap();
    let cases: [(&[&str], &str); 4] = [
        (&["--preset", "desk"], "desk.fmu"),
        (&["--preset", "figure3"], "figure3.fmu"),
        (&["--balls", "2"], "NewtonsCradle2.fmu"),
        (&["--parameters", "mine.toml", "--balls", "5"], "mine.fmu"),
    ];
    for (arguments, name) in cases {
        let built = run_in(&folder.file(""), &[&["build", "--from", &from], arguments].concat());
        assert_eq!((built.code, built.error.as_str()), (0, ""), "{arguments:?}");
        assert!(built.output.starts_with(&format!("{name} (")), "{}", built.output);
        assert!(Path::new(&folder.file(name)).exists(), "{name}");
    }
    assert!(fs::read(&from).unwrap() == before);
}

#[test]
fn what_is_replaced_is_told() {
    let folder = Folder::new("replaced");
    let (from, out) = (packed(&folder), folder.file("x.fmu"));
    let build = |arguments: &[&str]| {
        let built = run(&[&["build", "--from", &from, "--out", &out], arguments].concat());
        assert_eq!(built.code, 0, "{}", built.error);
        built.error
    };
    fs::write(&out, "a letter").unwrap();
    assert!(build(&["--preset", "desk"]).contains("which was: 8 bytes, not an FMU"));
    assert_eq!(build(&["--preset", "desk"]), "");
    let told = build(&["--balls", "7"]);
    assert!(told.contains("which was: preset desk, GUID {") && told.contains("}; now GUID {"), "{told}");
    assert!(build(&[]).contains("which was: n = 7, GUID {"));
}

/// The layout of a virtual environment: `bin/cradle-fmu` and the package in `lib/python3.x/site-packages`.
#[cfg(unix)]
#[test]
fn an_installed_program_has_its_fmu_and_its_python() {
    use std::fs::Permissions;
    use std::os::unix::fs::{PermissionsExt, symlink};

    let folder = Folder::new("environment");
    let package = folder.file("venv/lib/python3.11/site-packages/newtons_cradle");
    for path in [&package, &folder.file("venv/bin"), &folder.file("links"), &folder.file("work")] {
        fs::create_dir_all(path).unwrap();
    }
    fs::copy(packed(&folder), format!("{package}/NewtonsCradle.fmu")).unwrap();
    let program = folder.file("venv/bin/cradle-fmu");
    fs::copy(env!("CARGO_BIN_EXE_cradle-fmu"), &program).unwrap();
    let link = folder.file("links/cradle-fmu");
    symlink(&program, &link).unwrap();
    let python = folder.file("venv/bin/python3");
    fs::write(&python, "#!/bin/sh\n[ \"$1\" = -c ] && exit 0\nprintf '<%s>' \"$@\"\n").unwrap();
    fs::set_permissions(&python, Permissions::from_mode(0o755)).unwrap();
    let work = folder.file("work");
    let started = |arguments: &str| output("sh", &["-c", &format!("cd '{work}' && '{link}' {arguments}")]);

    let built = started("build --balls 3");
    assert_eq!((built.code, built.error.as_str()), (0, ""));
    assert!(built.output.starts_with("NewtonsCradle3.fmu ("), "{}", built.output);
    assert!(built.output.contains(" page NewtonsCradle3.fmu\n"), "{}", built.output);
    let page = started("page NewtonsCradle3.fmu");
    assert_eq!(page.output, "<-m><newtons_cradle><page><NewtonsCradle3.fmu>");
}

#[test]
fn the_hint_after_a_build_works_as_it_stands() {
    let folder = Folder::new("a hint");
    let library = library();
    let built = run_in(&folder.file(""), &["build", "--binary", &library, "--out", "it's mine.fmu"]);
    assert_eq!(built.code, 0, "{}", built.error);
    let hint = built.output.lines().find_map(|line| line.strip_prefix("Try it: ")).unwrap().to_owned();
    // From a file, as Windows' shell takes no quotation marks within an argument.
    let (name, change) = if cfg!(windows) { ("hint.cmd", "cd /D") } else { ("hint.sh", "cd") };
    let script = folder.file(name);
    fs::write(&script, format!("{change} \"{}\"\n{hint}\n", folder.file(""))).unwrap();
    let tried = if cfg!(windows) { output("cmd", &["/C", &script]) } else { output("sh", &[&script]) };
    assert_eq!(tried.code, 0, "{hint}: {}{}", tried.output, tried.error);
}

#[test]
fn parameter_sets_and_reference_results_are_in_the_fmu_and_beside_it() {
    let folder = Folder::new("reference");
    let (out, library, beside) = (folder.file("five.fmu"), library(), folder.file("beside"));
    let built = run(&["build", "--binary", &library, "--preset", "figure5", "--out", &out, "--reference", &beside]);
    assert_eq!((built.code, built.error.as_str()), (0, ""));
    let entries = read(&out);
    let text = |name: &str| String::from_utf8(entries[name].clone()).unwrap();
    let manifest = text(&format!("{REFERENCE}/fmi-ls-manifest.xml"));
    // Labels are new in it.
    assert!(manifest.contains("fmi-ls:fmi-ls-version=\"1.0.0-beta.1\"") && manifest.contains("<Label "), "{manifest}");
    let listed: Vec<&str> = manifest.split(" source=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert_eq!(listed.len(), 12, "{manifest}");
    for source in listed {
        let name = source.strip_prefix("../../").map_or_else(|| format!("{REFERENCE}/{source}"), str::to_owned);
        assert!(entries.contains_key(&name), "{name}");
    }
    // The FMU is made for Figure 5: what it does as it is, is what it does with that parameter set.
    assert_eq!(text(&format!("{REFERENCE}/start.csv")), text(&format!("{REFERENCE}/figure5.csv")));
    let rows = |csv: String| csv.lines().map(str::to_owned).collect::<Vec<_>>();
    let within = rows(text(&format!("{REFERENCE}/start.csv")));
    let finer = rows(fs::read_to_string(format!("{beside}/five_ref.csv")).unwrap());
    assert_eq!((within.len(), finer.len()), (102, 1002));
    assert_eq!(
        within[0],
        "\"time\",\"x[1]\",\"x[2]\",\"x[3]\",\"x[4]\",\"x[5]\",\"impulse[1]\",\"impulse[4]\",\"p_total\",\"E_total\""
    );
    // The step does not matter.
    assert_eq!((&within[0], &within[101]), (&finer[0], &finer[1001]));
    let options = fs::read_to_string(format!("{beside}/five_ref.opt")).unwrap();
    assert!(options.starts_with("StartTime, 0\nStopTime, 10\nStepSize, 0.01\nRelTol, 1e-6\n"), "{options}");
    // An FMU of FMI 3.0 has the same binary and the same results beside it.
    let three = folder.file("three.fmu");
    let built =
        run(&["build", "--fmi", "3", "--from", &out, "--preset", "figure5", "--out", &three, "--reference", &beside]);
    assert_eq!((built.code, built.error.as_str()), (0, ""));
    let csv = |name: &str| fs::read_to_string(format!("{beside}/{name}_ref.csv")).unwrap();
    assert_eq!(csv("three"), csv("five"));
}

/// Parameter sets of SSP 1.0 have no arrays.
#[test]
fn an_fmu_of_fmi_3_has_the_parameter_sets_that_need_no_array() {
    let folder = Folder::new("arrays");
    let library = library();
    let related = |out: &str, more: &[&str]| {
        let built = run(&[&["build", "--binary", &library, "--out", out], more].concat());
        assert_eq!((built.code, built.error.as_str()), (0, ""));
        let found = read(out);
        let files = found.keys().filter_map(|name| name.strip_prefix(REFERENCE)).map(str::to_owned);
        (files.collect::<Vec<_>>(), found)
    };
    let (_, two) = related(&folder.file("two.fmu"), &[]);
    let (files, three) = related(&folder.file("three.fmu"), &["--fmi", "3"]);
    // The presets lift other balls.
    assert_eq!(files, ["/fmi-ls-manifest.xml", "/start.csv", "/start.ssv"]);
    for name in files.iter().filter(|name| !name.ends_with(".xml")) {
        let name = format!("{REFERENCE}{name}");
        assert!(two[&name] == three[&name] && (name.ends_with(".csv") || !three[&name].contains(&b'[')), "{name}");
    }
    // What starts elsewhere needs an array: as it is, it has results.
    let (files, entries) = related(&folder.file("other.fmu"), &["--fmi", "3", "--set", "x_start[1]=-0.05"]);
    assert_eq!(files, ["/fmi-ls-manifest.xml", "/start.csv"]);
    let manifest = String::from_utf8(entries[&format!("{REFERENCE}/fmi-ls-manifest.xml")].clone()).unwrap();
    assert!(
        manifest.contains("Results with the start values of this FMU.") && !manifest.contains(".ssv"),
        "{manifest}"
    );
}

/// A C compiler makes the binary: one without the functions of FMI.
#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_recorded_are_missed_loudly() {
    let folder = Folder::new("missed");
    fs::write(folder.file("x.c"), "int nothing(void) { return 0; }\n").unwrap();
    let (out, other) = (folder.file("x.fmu"), folder.file("x.so"));
    let compiled = output("cc", &["-shared", "-fPIC", "-o", &other, &folder.file("x.c")]);
    assert_eq!(compiled.code, 0, "{}", compiled.error);
    let binary = library().split_once('=').map(|(platform, _)| format!("{platform}={other}")).unwrap();
    let built = run(&["build", "--binary", &binary, "--out", &out]);
    assert_eq!(built.code, 0, "{}", built.error);
    let reason = "the FMU gets no reference results: start: fmi2Instantiate is not exported";
    assert!(built.error.contains(reason), "{}", built.error);
    let entries = read(&out);
    assert!(entries.contains_key(&format!("{REFERENCE}/desk.ssv")));
    assert!(!entries.keys().any(|name| name.ends_with(".csv")));
    let manifest = String::from_utf8(entries[&format!("{REFERENCE}/fmi-ls-manifest.xml")].clone()).unwrap();
    assert!(!manifest.contains(".csv"), "{manifest}");
    let failed = run(&["build", "--binary", &binary, "--out", &out, "--reference", &folder.file("")]);
    assert!(failed.code == 1 && failed.error.contains("cannot make reference results: "), "{}", failed.error);
}

/// A folder as the sources are, and a script that stands in for cargo-zigbuild.
#[cfg(unix)]
#[test]
fn a_zigbuild_in_the_venv_of_the_sources_is_found() {
    use std::fs::Permissions;
    use std::os::unix::fs::PermissionsExt;

    let folder = Folder::new("sources");
    for path in ["src", ".venv/bin"] {
        fs::create_dir_all(folder.file(path)).unwrap();
    }
    fs::write(folder.file("src/lib.rs"), "").unwrap();
    fs::write(folder.file("Cargo.toml"), "[package]\nname = \"newtons-cradle\"\nversion = \"0.0.0\"\n[workspace]\n")
        .unwrap();
    let zigbuild = folder.file(".venv/bin/cargo-zigbuild");
    fs::write(&zigbuild, "#!/bin/sh\necho \"$@\" > arguments\nexit 1\n").unwrap();
    fs::set_permissions(&zigbuild, Permissions::from_mode(0o755)).unwrap();
    let target = "x86_64-unknown-linux-gnu.2.17";
    let failed = run_in(&folder.file(""), &["build", "--target", target]);
    assert!(
        failed.code == 1 && failed.error.contains("needs `pip install ziglang cargo-zigbuild`"),
        "{}",
        failed.error
    );
    let arguments = fs::read_to_string(folder.file("arguments")).unwrap();
    assert!(arguments.starts_with("zigbuild --package newtons-cradle ") && arguments.contains(target), "{arguments}");
}
