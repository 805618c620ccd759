//! What the program says to wrong arguments. None of them leaves anything behind.

use newtons_cradle::variables::Description;
use zip::CompressionMethod::Stored;

use super::support::{Folder, START, entries, fmu, library, library_path, run, run_in, text, warnings, zip};

#[test]
fn what_is_refused_is_named_and_leaves_nothing() {
    let folder = Folder::new("refused");
    let [bad, torn, quoted] =
        [("bad.toml", "x_start = [1, true]"), ("torn.toml", "balls = "), ("quoted.toml", "pendulum.length = \"0.2\"")]
            .map(|(name, text)| folder.write(name, text));
    let text = format!("linux64={bad}");
    let other = if cfg!(windows) { "linux64" } else { "win64" };
    let foreign = format!("{other}={}", library_path().display());
    let no_library = format!("is not a shared library for {other}, but a ");
    let cases: &[(&[&str], &str)] = &[
        (&["--bals", "13"], "a similar argument exists: '--balls'"),
        (&["--balls", "0"], "balls = 0 is refused; allowed: 1 to 10000"),
        (&["--balls", "1000000000"], "balls = 1000000000 is refused"),
        (&["--balls", "-1"], "--balls"),
        (&["--set", "nothing=1"], "--set nothing=1: no variable has the name \"nothing\"; allowed: gravity, "),
        (&["--set", "contact.stifness=1e9"], "\"contact.stifness\"; did you mean \"contact.stiffness\"?"),
        (&["--set", "radius=0.01"], "no variable has the name \"radius\"; did you mean \"ball.radius\"?"),
        (&["--set", "xstart=0.01"], "no variable has the name \"xstart\"; did you mean \"x_start\"?"),
        (&["--set", "Gravity=1"], "no variable has the name \"Gravity\"; did you mean \"gravity\"?"),
        (&["--set", "T=1"], "no variable has the name \"T\"; allowed: gravity, "),
        (&["--set", "E_total=1"], "E_total cannot be set, because its causality is output"),
        (&["--set", "x=0.1"], "--set x=0.1: x cannot be set, because its causality is output; x_start[i] is the posit"),
        (&["--set", "gravity[1]=1"], "gravity is a single value and takes no index"),
        (
            &["--set", "x_start[7]=0.1"],
            "--set x_start[7]=0.1: x_start[7]: index 7 is refused; allowed: 1 to 5, in a cradle of 5 ball(s)",
        ),
        (&["--balls", "1", "--set", "contact.gap[1]=0"], "index 1 is refused; there are none, in a cradle of 1 ball("),
        (&["--balls", "7", "--preset", "desk", "--set", "v_start=0,0,0,0,0,0,0"], "preset desk is of 5 balls, not 7; "),
        (&["--set", "x_start=0,0"], "x_start takes a list of 5 value(s)"),
        (&["--set", "gravity=1,2"], "gravity takes one value, not 2; write decimals with a point"),
        (
            &["--set", "ball.mass=1kg"],
            "--set ball.mass=1kg: ball.mass = 1kg is refused: leave the unit out, 1 is in kg",
        ),
        (&["--set", "ball.mass=-1"], "--set ball.mass=-1: ball.mass = -1 kg is refused; allowed: finite and > 0 kg"),
        (&["--set", "ball.mass=inf"], "allowed: finite and > 0 kg"),
        (&["--set", "ball.mass=heavy"], "--set ball.mass=heavy: ball.mass = heavy is refused; allowed: a number"),
        (&["--set", "x_start=[-0.1,0,0,0,0]"], "x_start = [-0.1 is refused: write the list without brackets"),
        (&["--set", "contact.model=glue"], "contact.model = glue is refused; allowed: powerLaw (1) or hertz (2) or r"),
        (&["--set", "contact.model=2"], "contact.model = 2 is refused; allowed: powerLaw (1)"),
        (&["--set", "gravity"], "allowed: name=value"),
        (&["--preset", "nothing"], "there is no preset \"nothing\"; allowed: textbook, "),
        (&["--preset", "dest"], "there is no preset \"dest\"; did you mean \"desk\"?; allowed: textbook, figure3, "),
        (&["--parameters", &bad], "bad.toml: x_start is of type boolean"),
        (&["--parameters", &torn], "torn.toml: "),
        (&["--parameters", &quoted], "pendulum.length = 0.2 is refused: write the number without quotes"),
        (&["--parameters", "nowhere.toml"], "cannot read nowhere.toml"),
        (&["--from", "nowhere.fmu"], "cannot read nowhere.fmu"),
        (&["--out", "nowhere/x.fmu"], "--out: there is no folder nowhere"),
        (&["--clocks", "none"], "--clocks none is refused: FMI 2.0 has no clocks"),
        (&["--binary", "linux46=x.so"], "--binary linux46=x.so is refused: allowed platforms: linux64, "),
        (&["--binary", "x"], "allowed: PLATFORM=FILE"),
        (&["--binary", &text], "is not a shared library for linux64"),
        (&["--binary", &foreign], &no_library),
        (&["--binary", "win32=nowhere/x.dll"], "--binary win32: cannot read nowhere/x.dll"),
        (&["--scalars"], "--scalars is refused: FMI 2.0 has no arrays; allowed: together with --fmi 3"),
        (&["--target", "riscv64gc-unknown-linux-gnu"], "allowed: x86_64-*-linux, "),
    ];
    let (out, library, before) = (folder.file("x.fmu"), library(), folder.list());
    for (arguments, expected) in cases {
        let mut all = vec!["build"];
        if !arguments.contains(&"--out") {
            all.extend(["--out", &out]);
        }
        // A good binary beside it, so that nothing is compiled if the argument is accepted.
        if !arguments.contains(&"--target") && !arguments.contains(&text.as_str()) {
            all.extend(["--binary", &library]);
        }
        all.extend(*arguments);
        let refused = run(&all);
        assert!(refused.error.contains(expected), "{arguments:?}: {}", refused.error);
        assert_eq!(refused.code, 2, "{arguments:?}");
        assert_eq!(folder.list(), before, "{arguments:?}");
    }
}

#[test]
fn a_wrong_sign_is_told() {
    let folder = Folder::new("doubts");
    let wrong = warnings(&folder, "x.fmu", &["--set", "x_start=0.1,0,0,0,0"]);
    assert!(wrong.contains("warning: x_start[1] = 0.1 m and x_start[2] = 0 m press balls 1 and 2 into each other"));
}

#[test]
fn only_fmus_of_this_version_give_their_binaries() {
    let folder = Folder::new("foreign");
    let sound = entries(&fmu(&Description::of(&START)));
    let changed = |name: &str, from: &str, to: &str| {
        let description = text(&sound, "modelDescription.xml");
        assert!(description.contains(from));
        let mut entries = sound.clone();
        entries.insert("modelDescription.xml".to_owned(), description.replacen(from, to, 1).into_bytes());
        folder.write(name, zip(&entries, Stored))
    };
    let version = env!("CARGO_PKG_VERSION");
    let tool = format!("newtons-cradle {version}");
    let foreign = changed("foreign.fmu", "modelName=\"NewtonsCradle\"", "modelName=\"BouncingBall\"");
    let old = changed("old.fmu", &tool, "newtons-cradle 0.0.9");
    let other = changed("changed.fmu", " start=\"9.81\"", " start=\"9.8\"");
    let (text, nothing) = (folder.write("text.fmu", "text"), folder.file("nothing.fmu"));
    let before = folder.list();
    for (from, expected) in [
        (&foreign, format!("is refused: it is \"BouncingBall\", written by {tool}; allowed: NewtonsCradle of {tool}")),
        (&old, format!("is refused: it was written by newtons-cradle 0.0.9; allowed: {tool}")),
        (&other, "is refused: modelDescription.xml: not the description that belongs to its GUID".to_owned()),
        (&text, "is refused: zip: ".to_owned()),
        (&nothing, "cannot read ".to_owned()),
    ] {
        let refused = run(&["build", "--from", from, "--out", &folder.file("x.fmu")]);
        assert!(refused.code == 2 && refused.error.contains(&expected), "{from}: {}", refused.error);
        assert!(refused.error.contains(from.as_str()), "{}", refused.error);
        assert_eq!(folder.list(), before, "{from}");
    }
}

#[test]
fn without_sources_and_an_fmu_it_says_what_to_do() {
    let folder = Folder::new("bare");
    let failed = run_in(&folder, &["build", "--balls", "13"]);
    assert_eq!(failed.code, 1, "{}", failed.output);
    for part in ["there is no binary to pack", "--from", "`pip install newtons-cradle`", "the folder of the sources"] {
        assert!(failed.error.contains(part), "{}", failed.error);
    }
    assert!(folder.list().is_empty());
}
