//! `cargo pack`: builds the FMU and writes it to one file.

mod archive;
mod compile;
mod contents;
mod date;
mod page;
mod platform;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand, value_parser};
use newtons_cradle::variables::{DEFAULT_BALLS, MAX_BALLS, MIN_BALLS, MODEL_IDENTIFIER, Recipe};

/// Builds and packs the Newton's cradle FMU.
#[derive(Parser)]
#[command(name = "cargo pack", bin_name = "cargo pack", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compile the FMU's binary and pack it with description, documentation, licences and icon.
    Build {
        /// Optimise the binary; what an FMU to be used should have.
        #[arg(long)]
        release: bool,
        /// Number of balls.
        #[arg(long, value_name = "N", default_value_t = DEFAULT_BALLS as u64,
              value_parser = value_parser!(u64).range(MIN_BALLS as u64..=MAX_BALLS as u64))]
        balls: u64,
        /// Where to write the FMU [default: fmu/NewtonsCradle.fmu in Cargo's target folder].
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

/// What can go wrong, in words for the user.
type Error = String;

fn main() -> ExitCode {
    let Arguments { command } = Arguments::parse();
    let done = match command {
        Command::Build { release, balls, out } => build(release, balls as usize, out),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn build(release: bool, balls: usize, out: Option<PathBuf>) -> Result<(), Error> {
    let workspace = compile::Workspace::find()?;
    let out = out.unwrap_or_else(|| workspace.target.join("fmu").join(format!("{MODEL_IDENTIFIER}.fmu")));
    eprintln!("Compiling the FMU's binary ({})", if release { "release" } else { "debug" });
    let binary = compile::library(&workspace, release)?;
    eprintln!("Packing {}", shown(&out).display());
    let entries = contents::entries(&Recipe::new(balls), &[(platform::host()?, binary)])?;
    let bytes = archive::write(&out, entries)?;
    let path = shown(&out).display().to_string();
    println!("{path} ({} kB)", bytes.div_ceil(1000));
    println!("Try it: fmpy simulate {path} --show-plot");
    Ok(())
}

/// A path as short as it can be typed from here.
fn shown(path: &Path) -> &Path {
    std::env::current_dir().ok().and_then(|here| path.strip_prefix(here).ok()).unwrap_or(path)
}
