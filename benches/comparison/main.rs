//! The methods of the FMU and SUNDIALS CVODE on the same runs, as the part of docs/performance.md with the tables.
//!
//!     cargo bench --bench comparison
//!
//! CVODE is left out where its library or a C compiler is missing.

#![expect(clippy::print_stdout, reason = "the tables are for the terminal")]

mod cvode;

use std::process::Command;
use std::time::Instant;

use cradle_host::scenes::{self, Scene, ready};
use cradle_host::{Host, fmi2OK};

/// Seconds that a run may take; slower methods are followed for a shorter span.
const PATIENCE: f64 = 20.0;
/// Enough to see whether it runs, s.
const GLANCE: f64 = 0.01;
/// A span with one of the impact sequences, s: the least that a method is followed for.
const SEQUENCE: f64 = 1.0;

/// A line of the table. Time and work are those of the whole run, scaled up from the span if that was shorter.
struct Line {
    method: String,
    seconds: f64,
    steps: f64,
    /// Relative to the energy, over the span.
    energy_error: f64,
    /// Simulated time, s.
    span: f64,
}

/// What is compared.
struct Table {
    title: &'static str,
    /// What is said above it.
    text: &'static str,
    scene: Scene,
    /// Settings of all runs, in addition to those of the scene.
    more: &'static str,
    /// Length of the run, s.
    whole: f64,
    /// Titles and settings; the event-driven method first.
    solvers: &'static [(&'static str, &'static str)],
    cvode: &'static [cvode::Run],
}

const EVENT_DRIVEN: (&str, &str) = ("eventDriven", "");
const ADAMS_10: (&str, &str) = ("adams, rtol 1e-10", "solver.method=adams solver.tolerance=1e-10");
const ADAMS_12: (&str, &str) = ("adams, rtol 1e-12", "solver.method=adams solver.tolerance=1e-12");

const TABLES: [Table; 6] = [
    Table {
        title: "Ten minutes of Figure 6",
        text: "600 s, 2,562 pulses, in a single `fmi2DoStep`. The paper needed \"a couple of minutes\".",
        scene: scenes::TEN_MINUTES,
        more: "",
        whole: 600.0,
        solvers: &[
            EVENT_DRIVEN,
            ADAMS_12,
            ADAMS_10,
            ("bdf, rtol 1e-10", "solver.method=bdf solver.tolerance=1e-10"),
            // Thirteen steps to a contact.
            ("rk4, steps of 1e-8 s", "solver.method=rk4 solver.fixedStep=1e-8"),
        ],
        cvode: &[
            ("CVODE Adams, rtol 1e-12", ["linear", "adams", "1e-12", "1e-12"]),
            ("CVODE Adams, rtol 1e-10", ["linear", "adams", "1e-10", "1e-14"]),
            ("CVODE BDF, banded, rtol 1e-10", ["linear", "bdf", "1e-10", "1e-10"]),
        ],
    },
    Table {
        title: "On arcs",
        text: "The same with `pendulum.model = circular`, two balls pulled 1 m aside (30 degrees). \
               Flights have no closed form.",
        scene: scenes::TEN_MINUTES,
        more: "pendulum.model=circular",
        whole: 600.0,
        solvers: &[EVENT_DRIVEN],
        cvode: &[("CVODE Adams, rtol 1e-12", ["arcs", "adams", "1e-12", "1e-12"])],
    },
    Table {
        title: "Cubic contacts",
        text: "Two balls pulled 0.05 m aside, 600 s, 7,194 pulses.",
        scene: scenes::CUBIC,
        more: "",
        whole: 600.0,
        solvers: &[EVENT_DRIVEN, ADAMS_10],
        cvode: &[("CVODE Adams, rtol 1e-10", ["cubic", "adams", "1e-10", "1e-14"])],
    },
    Table {
        title: "Touching steel balls",
        text: "Hertz contacts without a dead band, two balls pulled 0.1 m aside, 60 s. \
               Balls in touch have no closed form.",
        scene: scenes::STEEL,
        more: "",
        whole: 60.0,
        solvers: &[EVENT_DRIVEN, ADAMS_12],
        cvode: &[("CVODE Adams, rtol 1e-12", ["hertz", "adams", "1e-12", "1e-12"])],
    },
    Table {
        title: "Hunt-Crossley losses",
        text: "The same with `contact.huntCrossley = 0.05` s/m.",
        scene: scenes::STEEL,
        more: "contact.dampingLaw=huntCrossley contact.huntCrossley=0.05",
        whole: 60.0,
        solvers: &[EVENT_DRIVEN, ADAMS_12],
        cvode: &[("CVODE Adams, rtol 1e-12", ["hunt-crossley", "adams", "1e-12", "1e-12"])],
    },
    Table {
        title: "Viscoelastic losses",
        text: "The same with `contact.relaxationTime = 4e-7` s.",
        scene: scenes::STEEL,
        more: "contact.dampingLaw=viscoelastic contact.relaxationTime=4e-7",
        whole: 60.0,
        solvers: &[EVENT_DRIVEN, ADAMS_12],
        cvode: &[("CVODE Adams, rtol 1e-12", ["viscoelastic", "adams", "1e-12", "1e-12"])],
    },
];

/// One step of `span` s of a scene that is ready for it.
fn once(method: &str, host: Host, span: f64, whole: f64) -> Line {
    let energy = host.get("E_total");
    let begin = Instant::now();
    assert_eq!(host.step(0.0, span), fmi2OK, "{method}: {:?}", host.log());
    let (seconds, share) = (begin.elapsed().as_secs_f64(), span / whole);
    Line {
        method: method.to_owned(),
        seconds: seconds / share,
        steps: host.get("solver.steps") / share,
        energy_error: (host.get("E_residual") / energy).abs(),
        span,
    }
}

/// The fastest of a few runs, over the span that patience allows.
fn measured(title: &str, scene: impl Fn() -> Host, whole: f64) -> Line {
    let least = SEQUENCE.min(whole);
    let trial = once(title, scene(), least, whole);
    let span = (whole * PATIENCE / trial.seconds).clamp(least, whole).floor().max(least);
    let mut best = if span > trial.span { once(title, scene(), span, whole) } else { trial };
    let repeats = (2.0 / (best.seconds * span / whole)).clamp(0.0, 50.0) as usize;
    for _ in 0..repeats {
        let again = once(title, scene(), span, whole);
        if again.seconds < best.seconds {
            best = again;
        }
    }
    best
}

/// `12`, `0.0025`, `13,000,000`: three digits.
fn readable(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if value < 1000.0 {
        let digits = (2 - value.abs().max(1e-12).log10().floor() as i32).max(0) as usize;
        return format!("{value:.digits$}");
    }
    let whole = format!("{value:.0}");
    let groups = whole.as_bytes().rchunks(3).rev().map(|group| String::from_utf8_lossy(group).into_owned());
    groups.collect::<Vec<_>>().join(",")
}

/// The value rounded to three digits: no more are known of what is scaled up.
fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

fn print(lines: &[Line], whole: f64) {
    let fastest = lines.first().map_or(1.0, |line| line.seconds);
    println!("| solver | time, s | ratio | steps | energy error |");
    println!("|---|---:|---:|---:|---:|");
    let mut scaled = Vec::new();
    for line in lines {
        let scaled_up = line.span < whole;
        let shown = |value| readable(if scaled_up { three_digits(value) } else { value });
        let numbers = [line.seconds, line.seconds / fastest, line.steps].map(shown).join(" | ");
        let mark = if scaled_up { " *" } else { "" };
        println!("| {}{mark} | {numbers} | {:.0e} |", line.method, line.energy_error);
        if scaled_up {
            scaled.push(format!("{}: {} s", line.method, readable(line.span)));
        }
    }
    if !scaled.is_empty() {
        println!(
            "\n\\* Scaled up to {whole} s from a shorter run ({}), which has this energy error.",
            scaled.join("; ")
        );
    }
}

/// First line of what a program prints, without the rest.
fn first_line(program: &str, argument: &str) -> String {
    let answer = Command::new(program).arg(argument).output();
    let text = answer.map(|answer| String::from_utf8_lossy(&answer.stdout).into_owned()).unwrap_or_default();
    text.lines().next().unwrap_or("unknown").to_owned()
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    model.map_or_else(|| std::env::consts::ARCH.to_owned(), |(_, name)| name.to_owned())
}

fn main() {
    // `cargo bench -- --test`: only whether it runs.
    let glance = std::env::args().any(|argument| argument == "--test");
    if glance {
        println!("Only to see whether it runs: the first {GLANCE} s.");
    }
    let [rustc, cc] = ["rustc", "cc"].map(|program| first_line(program, "--version"));
    let sundials = cvode::measure(&TABLES[0].cvode[..1], GLANCE).map(|(_, version)| format!("SUNDIALS {version}"));
    let with = sundials.clone().unwrap_or_else(|why| format!("without CVODE: {why}"));
    println!("Measured on one core of: {} ({rustc}; {cc}; {with}).", processor());
    for Table { title, text, scene, more, whole, solvers, cvode } in TABLES {
        let whole = if glance { GLANCE } else { whole };
        let mut lines: Vec<Line> = solvers
            .iter()
            .map(|(title, solver)| measured(title, || ready(scene, &format!("{more} {solver}")), whole))
            .collect();
        if sundials.is_ok() {
            lines.extend(cvode::measure(cvode, whole).unwrap_or_else(|why| panic!("{why}")).0);
        }
        println!("\n## {title}\n\n{text}\n");
        print(&lines, whole);
    }
}
