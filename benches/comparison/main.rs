//! The four methods of the FMU and SUNDIALS CVODE on the ten-minute run, as one table.
//!
//!     cargo bench --bench comparison
//!
//! CVODE is left out where its library or a C compiler is missing.

#[path = "../scenes/mod.rs"]
mod scenes;

mod cvode;

use std::process::Command;
use std::time::Instant;

use scenes::{fmi2OK, ten_minutes_by};

/// Length of the run, s.
const WHOLE: f64 = 600.0;
/// Seconds that a run may take; slower methods are followed for a shorter span.
const PATIENCE: f64 = 20.0;
/// Enough to see whether it runs, s.
const GLANCE: f64 = 0.01;
/// A span with one of the 427 impact sequences, s: the least that a method is followed for.
const SEQUENCE: f64 = 1.0;

/// A line of the table. Time and work are those of the whole run, scaled up from the span if that was shorter.
struct Line {
    method: String,
    seconds: f64,
    steps: f64,
    evaluations: f64,
    /// Relative to the energy, over the span.
    energy_error: f64,
    /// Simulated time, s.
    span: f64,
}

/// One step of `span` s.
fn once(method: &str, settings: &[(&str, f64)], span: f64) -> Line {
    let host = ten_minutes_by(method, settings);
    let energy = host.get("E_total");
    let begin = Instant::now();
    assert_eq!(host.step(0.0, span), fmi2OK, "{method}: {:?}", host.log());
    let (seconds, share) = (begin.elapsed().as_secs_f64(), span / WHOLE);
    Line {
        method: method.to_owned(),
        seconds: seconds / share,
        steps: f64::from(host.get_integer("solver.steps")) / share,
        evaluations: f64::from(host.get_integer("solver.evaluations")) / share,
        energy_error: (host.get("E_residual") / energy).abs(),
        span,
    }
}

/// The fastest of a few runs, over the span that patience allows.
fn measured(title: &str, method: &str, settings: &[(&str, f64)], whole: f64) -> Line {
    let least = SEQUENCE.min(whole);
    let trial = once(method, settings, least);
    let span = (whole * PATIENCE / trial.seconds).clamp(least, whole).floor().max(least);
    let mut best = if span > trial.span { once(method, settings, span) } else { trial };
    let repeats = (2.0 / (best.seconds * span / WHOLE)).clamp(0.0, 50.0) as usize;
    for _ in 0..repeats {
        let again = once(method, settings, span);
        if again.seconds < best.seconds {
            best = again;
        }
    }
    Line { method: title.to_owned(), ..best }
}

/// What is compared: title, method, settings.
type Entry = (&'static str, &'static str, &'static [(&'static str, f64)]);
const METHODS: [Entry; 5] = [
    ("eventDriven", "eventDriven", &[]),
    ("adams, rtol 1e-12", "adams", &[("solver.tolerance", 1e-12)]),
    ("adams, rtol 1e-10", "adams", &[("solver.tolerance", 1e-10)]),
    ("bdf, rtol 1e-10", "bdf", &[("solver.tolerance", 1e-10)]),
    // Thirteen steps to a contact.
    ("rk4, steps of 1e-8 s", "rk4", &[("solver.fixedStep", 1e-8)]),
];

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

fn print(lines: &[Line], whole: f64) {
    let fastest = lines.first().map_or(1.0, |line| line.seconds);
    println!("| solver | time, s | over eventDriven | steps | evaluations | energy error |");
    println!("|---|---:|---:|---:|---:|---:|");
    let mut scaled = Vec::new();
    for line in lines {
        let mark = if line.span < whole { " *" } else { "" };
        println!(
            "| {}{mark} | {} | {} | {} | {} | {:.0e} |",
            line.method,
            readable(line.seconds),
            readable(line.seconds / fastest),
            readable(line.steps),
            readable(line.evaluations),
            line.energy_error,
        );
        if line.span < whole {
            scaled.push(format!("{}: {} s", line.method, readable(line.span)));
        }
    }
    if !scaled.is_empty() {
        println!("\n\\* Followed for a shorter time ({}); time and work are scaled", scaled.join("; "));
        println!("up to {WHOLE} s, the energy error is that of the shorter time.");
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
    let whole = if std::env::args().any(|argument| argument == "--test") { GLANCE } else { WHOLE };
    let methods = METHODS.iter().map(|(title, method, settings)| measured(title, method, settings, whole));
    let mut lines: Vec<Line> = methods.collect();
    let cvode = cvode::measure(whole, WHOLE);
    let remark = match cvode {
        Ok((more, version)) => {
            lines.extend(more);
            format!("SUNDIALS {version} ({})", first_line("cc", "--version"))
        }
        Err(why) => format!("without CVODE: {why}"),
    };
    if whole < WHOLE {
        println!("Only to see whether it runs: followed for {whole} s, time and work scaled up.");
    }
    println!("Ten minutes of Figure 6's set-up (600 s, 2,562 pulses), one core of: {}", processor());
    println!("newtons-cradle {} ({}), {remark}\n", env!("CARGO_PKG_VERSION"), first_line("rustc", "--version"));
    print(&lines, whole);
}
