//! What the program says to wrong arguments. None of them leaves anything behind.

use std::collections::BTreeSet;
use std::fs;

use super::support::{Ended, Folder, entries, fmu, library, run, run_in, write};

/// Runs `build` with a good binary, so that nothing is compiled if the arguments are accepted.
fn build(folder: &Folder, arguments: &[&str]) -> Ended {
    let (out, library) = (folder.file("x.fmu"), library());
    run(&[&["build", "--out", &out, "--binary", &library], arguments].concat())
}

#[test]
fn ten_slips_have_their_messages() {
    let folder = Folder::new("slips");
    let cases: [(&[&str], i32, &str); 10] = [
        (&["--bals", "13"], 2, "a similar argument exists: '--balls'"),
        (&["--preset", "dest"], 2, "there is no preset \"dest\"; did you mean \"desk\"?; allowed: figure3, figure4, "),
        (
            &["--set", "contact.stifness=1e9"],
            2,
            "--set contact.stifness=1e9: no variable has the name \"contact.stifness\"; did you mean \"contact.stiffness\"?",
        ),
        (&["--set", "radius=0.01"], 2, "no variable has the name \"radius\"; did you mean \"ball.radius\"?"),
        (
            &["--set", "x_start[7]=0.1"],
            2,
            "--set x_start[7]=0.1: x_start[7]: index 7 is refused; allowed: 1 to 5, in a cradle of 5 ball(s)",
        ),
        (
            &["--set", "x=0.1"],
            2,
            "--set x=0.1: x cannot be set, because its causality is output; x_start[i] is the position at the start",
        ),
        (
            &["--set", "ball.mass=1kg"],
            2,
            "--set ball.mass=1kg: ball.mass = 1kg is refused: leave the unit out, 1 is in kg",
        ),
        (&["--set", "ball.mass=0,5"], 2, "ball.mass takes one value, not 2; write decimals with a point"),
        (
            &["--set", "contact.model=herz"],
            2,
            "contact.model = herz is refused; allowed: powerLaw (1) or hertz (2) or rigid (3)",
        ),
        (&["--binary", "linux46=x.so"], 2, "--binary linux46=x.so is refused: allowed platforms: linux64, "),
    ];
    for (arguments, code, expected) in cases {
        let refused = build(&folder, arguments);
        assert!(refused.error.contains(expected), "{arguments:?}: {}", refused.error);
        assert_eq!(refused.code, code, "{arguments:?}");
        assert!(folder.list().is_empty(), "{arguments:?}");
    }
}

#[test]
fn only_fmus_of_this_version_give_their_binaries() {
    let folder = Folder::new("foreign");
    let out = folder.file("x.fmu");
    let described = |name: &str, from: &str, to: &str| {
        let mut entries = entries(&fmu());
        let description = String::from_utf8(entries["modelDescription.xml"].clone()).unwrap();
        assert!(description.contains(from));
        entries.insert("modelDescription.xml".to_owned(), description.replacen(from, to, 1).into_bytes());
        write(&folder, name, &entries)
    };
    let version = env!("CARGO_PKG_VERSION");
    let tool = format!("generationTool=\"newtons-cradle {version}\"");
    let foreign = described("foreign.fmu", "modelName=\"NewtonsCradle\"", "modelName=\"BouncingBall\"");
    let old = described("old.fmu", &tool, "generationTool=\"newtons-cradle 0.0.9\"");
    let changed = described("changed.fmu", " start=\"9.81\"", " start=\"9.8\"");
    let text = folder.file("text.fmu");
    fs::write(&text, "text").unwrap();
    let nothing = folder.file("nothing.fmu");
    let before = folder.list();
    let allowed = format!("allowed: newtons-cradle {version}");
    for (from, expected) in [
        (
            &foreign,
            format!("is refused: it is \"BouncingBall\", written by newtons-cradle {version}; allowed: NewtonsCradle"),
        ),
        (&old, format!("is refused: it was written by newtons-cradle 0.0.9; {allowed}")),
        (&changed, "is refused: modelDescription.xml: not the description that belongs to its GUID".to_owned()),
        (&text, "is refused: zip: ".to_owned()),
        (&nothing, "cannot read ".to_owned()),
    ] {
        let refused = run(&["build", "--from", from, "--out", &out]);
        assert!(refused.code == 2 && refused.error.contains(&expected), "{from}: {}", refused.error);
        assert!(refused.error.contains(from.as_str()), "{}", refused.error);
        assert_eq!(folder.list(), before, "{from}");
    }
}

#[test]
fn without_sources_and_an_fmu_it_says_what_to_do() {
    let folder = Folder::new("bare");
    let failed = run_in(&folder.file(""), &["build", "--balls", "13"]);
    assert_eq!(failed.code, 1, "{}", failed.output);
    for part in ["there is no binary to pack", "--from", "`pip install newtons-cradle`", "the folder of the sources"] {
        assert!(failed.error.contains(part), "{}", failed.error);
    }
    assert!(folder.list().is_empty());
}

#[test]
fn what_is_refused_is_named_and_leaves_nothing() {
    let folder = Folder::new("refused");
    let out = folder.file("x.fmu");
    let bad = folder.file("bad.toml");
    fs::write(&bad, "x_start = [1, true]").unwrap();
    let torn = folder.file("torn.toml");
    fs::write(&torn, "balls = ").unwrap();
    let text = format!("linux64={bad}");
    let cases: &[(&[&str], &str)] = &[
        (&["--balls", "0"], "balls = 0 is refused; allowed: 1 to 10000"),
        (&["--balls", "1000000000"], "balls = 1000000000 is refused"),
        (&["--balls", "-1"], "--balls"),
        (&["--set", "nothing=1"], "--set nothing=1: no variable has the name \"nothing\"; allowed: gravity, "),
        (&["--set", "E_total=1"], "E_total cannot be set, because its causality is output"),
        (&["--set", "gravity[1]=1"], "gravity is a single value and takes no index"),
        (
            &["--balls", "1", "--set", "contact.gap[1]=0"],
            "index 1 is refused; there are none, in a cradle of 1 ball(s)",
        ),
        (&["--set", "x_start=0,0"], "x_start takes a list of 5 value(s)"),
        (&["--set", "gravity=1,2"], "gravity takes one value"),
        (&["--set", "ball.mass=-1"], "--set ball.mass=-1: ball.mass = -1 kg is refused; allowed: finite and > 0 kg"),
        (&["--set", "ball.mass=inf"], "allowed: finite and > 0 kg"),
        (&["--set", "ball.mass=heavy"], "ball.mass is of type Real"),
        (&["--set", "contact.model=glue"], "contact.model = glue is refused; allowed: powerLaw (1)"),
        (&["--set", "contact.model=2"], "contact.model = 2 is refused; allowed: powerLaw (1)"),
        (&["--set", "gravity"], "allowed: name=value"),
        (&["--preset", "nothing"], "there is no preset \"nothing\"; allowed: figure3, "),
        (&["--parameters", &bad], "bad.toml: x_start is of type boolean"),
        (&["--parameters", &torn], "torn.toml: "),
        (&["--binary", "vax=x"], "allowed platforms: linux64, "),
        (&["--binary", "x"], "allowed: PLATFORM=FILE"),
        (&["--binary", &text], "is not a shared library for linux64"),
        (&["--binary", "win32=nowhere/x.dll"], "--binary win32: cannot read nowhere/x.dll"),
        (&["--target", "riscv64gc-unknown-linux-gnu"], "allowed: x86_64-*-linux, "),
    ];
    let library = library();
    let before: BTreeSet<_> = folder.list();
    for (arguments, expected) in cases {
        let mut all = vec!["build", "--out", &out];
        // A good binary beside it, so that nothing is compiled if the argument is accepted.
        if !arguments.contains(&"--target") && !arguments.iter().any(|argument| argument.starts_with("linux64=")) {
            all.extend(["--binary", &library]);
        }
        all.extend(*arguments);
        let refused = run(&all);
        assert!(refused.error.contains(expected), "{arguments:?}: {}", refused.error);
        assert!(matches!(refused.code, 1 | 2), "{arguments:?}: {}", refused.code);
        assert_eq!(folder.list(), before, "{arguments:?}");
    }
}
