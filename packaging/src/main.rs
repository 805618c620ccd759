//! `cradle-fmu`: builds, checks and shows FMUs on the command line. `cargo pack` runs it from the sources.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program speaks to its user")]

mod arguments;
mod packing;

use std::process::ExitCode;

use arguments::{Program, Request};
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

fn answer(request: Request) -> Result<ExitCode, Error> {
    match request {
        Request::Build(build) => build.run()?,
        Request::Check { file, no_load } => {
            let (mut report, entries) = check::bytes(&check::read(&file)?, MAX_BYTES);
            if let Some(entries) = entries.filter(|_| !no_load) {
                reference::check(&entries, &mut report);
            }
            print!("{report}");
            if !report.is_clean() {
                return Ok(ExitCode::FAILURE);
            }
        }
        Request::Info { file } => print!("{}", info::of(&file)?),
        Request::Presets => PRESETS.iter().for_each(|preset| println!("{:8} {}", preset.name, preset.title())),
        Request::Live(of) => return environment::hand_over("live", of.python, &of.arguments).map(ExitCode::from),
        Request::Page(of) => return environment::hand_over("page", of.python, &of.arguments).map(ExitCode::from),
        Request::Record { folder, name } => reference::run(&folder, &name)?,
    }
    Ok(ExitCode::SUCCESS)
}
