//! `cradle-fmu`: builds, checks and shows FMUs on the command line. `cargo pack` runs it from the sources.

// In tests, a panic fails the test.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod arguments;
mod build_command;
mod say;

use std::process::ExitCode;

use arguments::{Program, Python, Request};
use cradle_packaging::build::{Choice, PRESETS};
use cradle_packaging::check::MAX_BYTES;
use cradle_packaging::{Error, check, environment, info, reference};
use say::{say, tell};

fn main() -> ExitCode {
    let ended = match Program::of_command_line() {
        Ok(program) => answer(program),
        Err(help) if !help.use_stderr() => say(help.render()).map(|()| ExitCode::SUCCESS),
        Err(refusal) => Err(Error::Usage(refusal.render().to_string().trim_start_matches("error: ").trim_end().into())),
    };
    ended.unwrap_or_else(|error| {
        tell(format_args!("error: {error}"));
        match error {
            Error::Usage(_) => ExitCode::from(2),
            Error::Failure(_) => ExitCode::FAILURE,
        }
    })
}

fn answer(Program { python, request }: Program) -> Result<ExitCode, Error> {
    // Hands a command over to the Python package.
    let hand_over = |command: &str, own: Python| {
        let (program, arguments) = own.split(python.clone())?;
        environment::hand_over(command, program, &arguments).map(ExitCode::from)
    };
    match request {
        Request::Live(own) => return hand_over("live", own),
        Request::Page(own) => return hand_over("page", own),
        Request::Cases(own) => return hand_over("cases", own),
        // Code 1 would be the verdict "wrong", but nothing was judged.
        Request::Judge(own) => return hand_over("judge", own).map_err(|error| Error::Usage(error.to_string())),
        _ if python.is_some() => {
            return Err(Error::Usage("--python is refused; allowed: for page, live, cases and judge".to_owned()));
        }
        Request::Build(build) => build.run()?,
        Request::Check { file, no_load } => {
            let (mut report, entries) = check::bytes(&check::read(&file)?, MAX_BYTES);
            if let Some(entries) = entries.filter(|_| !no_load) {
                reference::check(&entries, &mut report);
            }
            say(&report)?;
            if !report.problems.is_empty() {
                return Ok(ExitCode::FAILURE);
            }
        }
        Request::Info { file } => say(info::of(&file)?)?,
        Request::Presets => {
            let lines = PRESETS.iter().map(|preset| format!("{:8} {}\n", preset.name, preset.title()));
            say(lines.collect::<String>())?;
        }
        Request::Damping { restitution, set } => {
            let mut choice = Choice::default();
            choice.balls(2);
            set.iter().try_for_each(|text| choice.set(text))?;
            let (name, value) = restitution.of_pair(choice.recipe()?.settings()?)?;
            say(format_args!("{name}={value:e}\n"))?;
        }
        Request::Record { folder, names } => reference::run(folder, names),
    }
    Ok(ExitCode::SUCCESS)
}
