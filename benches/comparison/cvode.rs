//! Compiles and runs `cvode.c`, where the machine has SUNDIALS.

use std::path::PathBuf;
use std::process::Command;

use super::Line;

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/comparison/cvode.c");

/// Title, and the arguments of the program: contacts, method, relative and absolute tolerance. Of the absolute ones
/// tried, from 1 to 1e-5 of the relative one, those that were fastest.
pub type Run = (&'static str, [&'static str; 4]);

/// From version 7 on there is a core library.
const LIBRARIES: [&[&str]; 2] = [&["-lsundials_core"], &[]];

/// The lines of the table and the version of SUNDIALS, or why there are none, for runs of `span` (s).
pub fn measure(runs: &[Run], span: f64) -> Result<(Vec<Line>, String), String> {
    let program = compile()?;
    let mut version = String::new();
    let lines = runs.iter().map(|(title, arguments)| {
        let runs = (0..3).map(|_| {
            let run = Command::new(&program).args(arguments).arg(span.to_string()).output();
            let text = String::from_utf8_lossy(&run.map_err(|error| error.to_string())?.stdout).into_owned();
            // Warnings of SUNDIALS 7 come before.
            let fields: Vec<&str> = text.lines().last().unwrap_or_default().split_whitespace().collect();
            let [seconds, steps, _, error, sundials] = fields[..] else {
                return Err(format!("{title} ended with {text:?}"));
            };
            sundials.clone_into(&mut version);
            let number = |text: &str| text.parse::<f64>().map_err(|error| format!("{title}: {error} in {text}"));
            Ok(Line {
                method: (*title).to_owned(),
                seconds: number(seconds)?,
                steps: number(steps)?,
                energy_error: number(error)?,
                span,
            })
        });
        let runs = runs.collect::<Result<Vec<_>, String>>()?;
        runs.into_iter().min_by(|a, b| a.seconds.total_cmp(&b.seconds)).ok_or_else(|| "no runs".to_owned())
    });
    let lines = lines.collect::<Result<Vec<_>, String>>()?;
    Ok((lines, version))
}

fn compile() -> Result<PathBuf, String> {
    let program = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("cvode");
    let mut why = String::new();
    for core in LIBRARIES {
        let mut compiler = Command::new("cc");
        compiler.args(["-O3", "-o"]).arg(&program).arg(SOURCE);
        compiler.args(
            ["cvode", "nvecserial", "sunmatrixband", "sunlinsolband", "sunnonlinsolfixedpoint"]
                .map(|name| format!("-lsundials_{name}")),
        );
        let answer = compiler.args(core).arg("-lm").output().map_err(|error| format!("cc: {error}"))?;
        if answer.status.success() {
            return Ok(program);
        }
        why = String::from_utf8_lossy(&answer.stderr).into_owned();
    }
    let reason = why.lines().find(|line| line.contains("error") || line.contains("cannot find")).unwrap_or("cc failed");
    Err(format!("{reason} (on Debian, `apt install libsundials-dev`)"))
}
