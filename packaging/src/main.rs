//! `cradle-fmu`: builds, checks and shows FMUs on the command line. `cargo pack` runs it from the sources.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program speaks to its user")]

mod arguments;
mod packing;

use std::path::Path;
use std::process::ExitCode;

use arguments::{Program, Request};
use clap::Parser;
use cradle_packaging::build::PRESETS;
use cradle_packaging::check::MAX_BYTES;
use cradle_packaging::{Error, animation, check, info, live, reference};

fn main() -> ExitCode {
    let done = match Program::parse().request {
        Request::Build(build) => build.run(),
        Request::Check { file, no_load } => show_check(&file, !no_load),
        Request::Info { file } => info::of(&file).map(|text| {
            print!("{text}");
            ExitCode::SUCCESS
        }),
        Request::Presets => {
            for preset in PRESETS {
                println!("{:8} {}", preset.name, preset.title());
            }
            Ok(ExitCode::SUCCESS)
        }
        Request::Live { out } => live::write(&out).map(|bytes| {
            println!("{} ({} kB): open it in a browser", out.display(), bytes.div_ceil(1000));
            ExitCode::SUCCESS
        }),
        Request::Page { python, arguments } => animation::make(python, &arguments).map(ExitCode::from),
        Request::Record { folder, experiment } => reference::run(&folder, experiment).map(|()| ExitCode::SUCCESS),
    };
    done.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        match error {
            Error::Usage(_) => ExitCode::from(2),
            Error::Failure(_) => ExitCode::FAILURE,
        }
    })
}

fn show_check(file: &Path, load: bool) -> Result<ExitCode, Error> {
    let (mut report, entries) = check::bytes(&check::read(file)?, MAX_BYTES);
    if let Some(entries) = entries.filter(|_| load) {
        reference::check(&entries, &mut report);
    }
    print!("{report}");
    Ok(if report.is_clean() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
