//! `cradle-fmu`: builds, checks and shows FMUs on the command line. `cargo pack` runs it from the sources.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program speaks to its user")]

mod arguments;
mod build_command;

use std::process::ExitCode;

use arguments::{Program, Python, Request};
use clap::Parser;
use cradle_packaging::build::PRESETS;
use cradle_packaging::check::MAX_BYTES;
use cradle_packaging::{Error, check, environment, info, reference};

fn main() -> ExitCode {
    answer(Program::parse().request).unwrap_or_else(|error| {
        eprintln!("error: {error}");
        match error {
            Error::Usage(_) => ExitCode::from(2),
            Error::Failure(_) => ExitCode::FAILURE,
        }
    })
}

/// Lets the Python package answer.
fn python(command: &str, Python { python, arguments }: Python) -> Result<ExitCode, Error> {
    environment::hand_over(command, python, &arguments).map(ExitCode::from)
}

fn answer(request: Request) -> Result<ExitCode, Error> {
    match request {
        Request::Build(build) => build.run()?,
        Request::Check { file, no_load } => {
            let (mut report, entries) = check::bytes(&check::read(&file)?, MAX_BYTES);
            if let Some(entries) = entries.filter(|_| !no_load) {
                reference::check(&entries, &mut report);
            }
            print!("{report}");
            if !report.problems.is_empty() {
                return Ok(ExitCode::FAILURE);
            }
        }
        Request::Info { file } => print!("{}", info::of(&file)?),
        Request::Presets => PRESETS.iter().for_each(|preset| println!("{:8} {}", preset.name, preset.title())),
        Request::Live(of) => return python("live", of),
        Request::Page(of) => return python("page", of),
        Request::Cases(of) => return python("cases", of),
        Request::Judge(of) => return python("judge", of),
        Request::Record { folder, names } => reference::run(folder, names),
    }
    Ok(ExitCode::SUCCESS)
}
