//! `cradle-fmu`: builds and checks FMUs on the command line. `cargo pack` runs it from the sources.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use cradle_packaging::choice::{Choice, PRESETS, Preset};
use cradle_packaging::compile::Workspace;
use cradle_packaging::contents::{self, Binary};
use cradle_packaging::platform::{self, Platform};
use cradle_packaging::{Error, archive, check, info};
use newtons_cradle::variables::MODEL_IDENTIFIER;

const EXIT_CODES: &str = "\
Exit codes: 0 done, or nothing to report; 1 it did not work, or `check` found problems; 2 the arguments are refused, or the file
cannot be read.";

/// Builds, checks and describes FMUs of Newton's cradle.
#[derive(Parser)]
#[command(name = "cradle-fmu", version, after_help = EXIT_CODES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Build(Build),
    /// Say what is wrong with an FMU: entries, description, binaries, and what they answer on this machine.
    ///
    /// Works on anybody's FMI 2.0 FMU. A binary for this machine is loaded, in a process of its own, and runs for one step.
    #[command(after_help = EXIT_CODES)]
    Check {
        /// The FMU.
        file: PathBuf,
        /// Do not load the binary.
        #[arg(long)]
        no_load: bool,
    },
    /// Say what is in an FMU.
    #[command(after_help = EXIT_CODES)]
    Info {
        /// The FMU.
        file: PathBuf,
    },
    /// Load the binary of an unpacked FMU and write what is wrong with its answers to a file; `check` runs this.
    #[command(hide = true)]
    Probe {
        folder: PathBuf,
        findings: PathBuf,
    },
}

/// Write an FMU of a cradle: compile the binary, or take ready ones, and pack it with description and documentation.
#[derive(Args)]
#[command(after_help = build_help())]
struct Build {
    /// Number of balls, 1 to 10000 [default: of the preset or parameter file, else 5].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    balls: Option<usize>,
    /// A start value; for arrays `x_start[1]=-0.1` or `x_start=-0.1,-0.1,0`; items of enumerations by name.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Take balls and start values from a TOML file, as the presets are.
    #[arg(long, value_name = "FILE.toml")]
    parameters: Vec<PathBuf>,
    /// Begin with a ready cradle, see below.
    #[arg(long, value_name = "NAME", value_parser = preset)]
    preset: Option<&'static Preset>,
    /// Compile for a target triple of Rust [default: this machine].
    ///
    /// `x86_64-unknown-linux-gnu.2.17`, with a version of glibc, needs cargo-zigbuild and makes a binary for that and newer systems.
    #[arg(long, value_name = "TRIPLE")]
    target: Vec<String>,
    /// Take a ready binary, such as `linux64=libnewtons_cradle.so`; nothing is compiled unless there is a --target.
    #[arg(long, value_name = "PLATFORM=FILE")]
    binary: Vec<String>,
    /// Optimise what is compiled: what an FMU to be used should have.
    #[arg(long)]
    release: bool,
    /// Where to write the FMU [default: fmu/NewtonsCradle.fmu in Cargo's target folder; NewtonsCradle.fmu here if nothing is compiled].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

fn build_help() -> String {
    let presets: Vec<String> = PRESETS.iter().map(|preset| format!("  {:8} {}", preset.name, preset.title())).collect();
    format!(
        "Presets:\n{}\n\nA --parameters file replaces values of the preset, a --set those of both.\n\n\
         The same sources and arguments give the same bytes. The date in the FMU is SOURCE_DATE_EPOCH, else 1980-01-01.\n\n{EXIT_CODES}",
        presets.join("\n")
    )
}

fn preset(name: &str) -> Result<&'static Preset, String> {
    let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
    Preset::named(name).ok_or_else(|| format!("allowed: {}", names.join(", ")))
}

fn main() -> ExitCode {
    let Arguments { command } = Arguments::parse();
    let done = match command {
        Command::Build(build) => build.run(),
        Command::Check { file, no_load } => show_check(&file, !no_load),
        Command::Info { file } => info::of(&file).map(|text| {
            print!("{text}");
            ExitCode::SUCCESS
        }),
        Command::Probe { folder, findings } => check::probe::run(&folder, &findings).map(|()| ExitCode::SUCCESS),
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
        let bytes = archive::write(&out, contents::entries(&recipe, binaries)?)?;
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
    if binaries.iter().any(|(other, _)| *other == platform) {
        return Err(Error::Usage(format!("{argument}: there are two binaries for {}; allowed: one", platform.folder)));
    }
    binaries.push((platform, contents));
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
