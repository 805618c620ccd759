//! `cradle-fmu`: builds, checks and shows FMUs on the command line. `cargo pack` runs it from the sources.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program speaks to its user")]

mod arguments;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use arguments::{Build, Request};
use cradle_packaging::build::{self, Binary, Choice, Workspace};
use cradle_packaging::platform::{self, Platform};
use cradle_packaging::{Error, animation, archive, check, info};
use newtons_cradle::variables::MODEL_IDENTIFIER;

fn main() -> ExitCode {
    let done = match arguments::parse() {
        Request::Build(build) => build.run(),
        Request::Check { file, load } => show_check(&file, load),
        Request::Info { file } => info::of(&file).map(|text| {
            print!("{text}");
            ExitCode::SUCCESS
        }),
        Request::Page { python, arguments } => animation::make(python, &arguments).map(ExitCode::from),
        Request::Probe { folder, findings } => check::probe::run(&folder, &findings).map(|()| ExitCode::SUCCESS),
    };
    done.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        match error {
            Error::Usage(_) => ExitCode::from(2),
            Error::Failure(_) => ExitCode::FAILURE,
        }
    })
}

impl Build {
    fn run(self) -> Result<ExitCode, Error> {
        let recipe = self.choice()?.recipe()?;
        let mut binaries = self.binaries()?;
        let compiled = binaries.is_empty() || !self.target.is_empty();
        let mut default_out = PathBuf::from(format!("{MODEL_IDENTIFIER}.fmu"));
        if compiled {
            let workspace = Workspace::find()?;
            let targets: Vec<Option<&str>> = match self.target.as_slice() {
                [] => vec![None],
                targets => targets.iter().map(|target| Some(target.as_str())).collect(),
            };
            for target in targets {
                let platform = target.map_or_else(Platform::host, Platform::of_target)?;
                let how = if self.release { "release" } else { "debug" };
                eprintln!("Compiling the FMU's binary for {} ({how})", platform.folder);
                add(&mut binaries, platform, &workspace.library(target, self.release)?, "--target")?;
            }
            default_out = workspace.target.join("fmu").join(default_out);
        }
        let out = self.out.unwrap_or(default_out);
        let bytes = archive::write(&out, build::entries(&recipe, binaries)?)?;
        let path = shown(&out).display().to_string();
        println!("{path} ({} kB, n = {})", bytes.div_ceil(1000), recipe.balls);
        println!("Try it: fmpy simulate {path} --show-plot");
        Ok(ExitCode::SUCCESS)
    }

    fn choice(&self) -> Result<Choice, Error> {
        let mut choice = Choice::default();
        if let Some(preset) = self.preset {
            choice.preset(preset)?;
        }
        for file in &self.parameters {
            choice.file(file)?;
        }
        for text in &self.set {
            choice.set(text)?;
        }
        if let Some(balls) = self.balls {
            choice.balls(balls);
        }
        Ok(choice)
    }

    /// The ready binaries, each looked at whether it is for its platform.
    fn binaries(&self) -> Result<Vec<Binary>, Error> {
        let mut binaries = Vec::new();
        for text in &self.binary {
            let refused = |reason: &str| Error::Usage(format!("--binary {text} is refused: {reason}"));
            let (folder, file) = text.split_once('=').ok_or_else(|| refused("allowed: PLATFORM=FILE"))?;
            let platform = Platform::named(folder)
                .ok_or_else(|| refused(&format!("allowed platforms: {}", platform::folders())))?;
            add(&mut binaries, platform, Path::new(file), &format!("--binary {folder}"))?;
        }
        Ok(binaries)
    }
}

fn add(binaries: &mut Vec<Binary>, platform: &'static Platform, file: &Path, argument: &str) -> Result<(), Error> {
    let name = file.display();
    let contents =
        fs::read(file).map_err(|error| Error::Failure(format!("{argument}: cannot read {name}: {error}")))?;
    platform.check(&contents).map_err(|error| Error::Usage(format!("{argument}: {name} is {error}")))?;
    if binaries.iter().any(|other| other.platform == platform) {
        return Err(Error::Usage(format!("{argument}: there are two binaries for {}; allowed: one", platform.folder)));
    }
    binaries.push(Binary { platform, contents });
    Ok(())
}

fn show_check(file: &Path, load: bool) -> Result<ExitCode, Error> {
    let report = check::file(file, load)?;
    print!("{report}");
    Ok(if report.is_clean() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A path as short as it can be typed from here.
fn shown(path: &Path) -> &Path {
    std::env::current_dir().ok().and_then(|here| path.strip_prefix(here).ok()).unwrap_or(path)
}
