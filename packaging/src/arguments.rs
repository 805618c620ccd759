//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use cradle_packaging::Error;
use cradle_packaging::build::{PRESETS, Restitution};
use newtons_cradle::variables::{Description, Settings};

const PYTHON: &str = "The Python package answers; this command with --help lists its arguments.";

const EXIT_CODES: &str = "\
Exit codes: 0 success; 1 failure, or `check` found problems; 2 the arguments are refused, or the file cannot be read.";

/// The commands of the Python package.
const HANDED_OVER: [&str; 4] = ["live", "page", "cases", "judge"];

/// Builds, packs, checks, describes and shows FMUs of Newton's cradle
#[derive(Parser)]
#[command(name = "cradle-fmu", version, after_help = EXIT_CODES)]
pub struct Program {
    /// The Python of the commands that need one.
    #[arg(long, value_name = "PROGRAM", hide = true)]
    pub python: Option<OsString>,
    #[command(subcommand)]
    pub request: Request,
}

impl Program {
    /// From the command line. clap takes a `--` directly behind a command for its own; for commands that are handed
    /// over it says where this program's options end, so there it stands twice.
    pub fn of_command_line() -> Result<Self, clap::Error> {
        let mut given: Vec<OsString> = std::env::args_os().collect();
        let handed_over = |pair: &[OsString]| HANDED_OVER.iter().any(|name| pair[0] == *name) && pair[1] == "--";
        if let Some(at) = given.windows(2).position(handed_over) {
            given.insert(at + 1, "--".into());
        }
        Self::try_parse_from(given)
    }
}

/// What the user asks for.
#[expect(clippy::large_enum_variant, reason = "there is only one")]
#[derive(Subcommand)]
pub enum Request {
    /// Write an FMU of a cradle: pack existing or newly compiled binaries with description and documentation
    #[command(after_help = build_help())]
    Build(Build),
    /// Validate an FMU that this program has written, possibly with binaries from elsewhere
    ///
    /// It checks zip entries, description and binaries. Then it runs the binary for this machine in a separate process,
    /// and compares the results with those in the FMU. `fmpy validate FILE` checks third-party FMUs.
    #[command(after_help = EXIT_CODES)]
    Check {
        /// The FMU
        file: PathBuf,
        /// Do not run the binary
        #[arg(long)]
        no_load: bool,
    },
    /// List the contents of an FMU of FMI 2.0 or 3.0, of this or any other program
    #[command(after_help = EXIT_CODES)]
    Info {
        /// The FMU
        file: PathBuf,
    },
    /// List the presets for `build --preset`
    #[command(after_help = EXIT_CODES)]
    Presets,
    /// Write the page of the live cradle: one HTML file for a browser, no network needed
    #[command(after_help = PYTHON, disable_help_flag = true)]
    Live(Python),
    /// Write the page of an FMU's run, or of a result in CSV: one HTML file for a browser, no network needed
    #[command(after_help = PYTHON, disable_help_flag = true)]
    Page(Python),
    /// Write small FMUs with known answers, to try out a tool that imports FMUs
    #[command(after_help = PYTHON, disable_help_flag = true)]
    Cases(Python),
    /// Say what a tool did right or wrong in those cases, from its results in CSV
    #[command(after_help = PYTHON, disable_help_flag = true)]
    Judge(Python),
    /// Print the damping by which two balls part so, as NAME=VALUE (used by the Python package)
    #[command(hide = true)]
    Damping {
        restitution: Restitution,
        #[arg(long)]
        set: Vec<String>,
    },
    /// Run a binary, from standard input, in a new folder for reference results (used by `build` and `check`)
    #[command(hide = true)]
    Record { folder: PathBuf, names: Vec<String> },
}

/// A command of the Python package.
#[derive(Args)]
pub struct Python {
    /// Arguments of the package's command; and `--python PROGRAM`, the Python to run [default: the first that has the
    /// package: beside this program, on the PATH, or in .venv in this folder or one above]
    #[arg(num_args = 0.., value_name = "ARGUMENT", trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

impl Python {
    /// The Python to run, if one is named here or was `before` the command, and the arguments for it: all but
    /// `--python` and a `--`, behind which nothing is taken for an option of this program.
    pub fn split(self, before: Option<OsString>) -> Result<(Option<OsString>, Vec<OsString>), Error> {
        let (mut program, mut own, mut rest) = (before, Vec::new(), self.arguments.into_iter());
        while let Some(argument) = rest.next() {
            let given = argument.to_str().and_then(|text| text.strip_prefix("--python="));
            if let Some(given) = given {
                program = Some(given.into());
            } else if argument == "--python" {
                let missing = || Error::Usage("--python needs the name of a program".to_owned());
                program = Some(rest.next().ok_or_else(missing)?);
            } else if argument == "--" {
                own.extend(rest.by_ref());
            } else {
                own.push(argument);
            }
        }
        Ok((program, own))
    }
}

#[derive(Args)]
pub struct Build {
    /// Number of balls, 1 to 10000 [default: that of the preset or parameter file, or 5]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub balls: Option<usize>,
    /// Set a start value; an array as `x_start[1]=-0.1` or `x_start=-0.1,-0.1,0`, an enumeration by the name or number of an item
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// Take the number of balls and start values from a TOML file in the format of the presets
    #[arg(long, value_name = "FILE.toml")]
    pub parameters: Vec<PathBuf>,
    /// Let two balls, free and alone, part at this fraction of the speed at which they meet, such as `0.9`; where that
    /// depends on the speed, it is given as well (m/s): `0.9@1.0`
    ///
    /// Sets contact.restitution or the coefficient of the damping law. If contacts lose nothing otherwise, and neither
    /// --set nor --parameters names a law, that is constantRestitution. Unlike balls: of the first two.
    #[arg(long, value_name = "E[@SPEED]")]
    pub restitution: Option<Restitution>,
    /// Version of the standard [default: 2]; the default file of version 3 is called NAME.fmi3.fmu
    #[arg(long, value_name = "VERSION", value_parser = ["2", "3"])]
    pub fmi: Option<String>,
    /// Leave out the clocks of version 3 and their variables, for hosts that do not support clocks
    #[arg(long, value_name = "none", value_parser = ["none"])]
    clocks: Option<String>,
    /// List x[1], x[2], ... of version 3 as scalars, for hosts that do not support arrays; n is fixed then
    #[arg(long)]
    scalars: bool,
    /// Make outputs that are not real numbers locals, for hosts that read every output as a real number; version 3 then
    /// has no clocks
    #[arg(long)]
    real_outputs: bool,
    /// Start from a preset, see below
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// Take binaries and licences from an FMU written by this version of this program; nothing is compiled
    #[arg(long, value_name = "FILE.fmu")]
    pub from: Option<PathBuf>,
    /// Compile for a Rust target triple [default: this machine]
    ///
    /// A triple with a glibc version, such as `x86_64-unknown-linux-gnu.2.17`, needs cargo-zigbuild. Its binary runs on
    /// systems with that glibc or a newer one.
    #[arg(long, value_name = "TRIPLE")]
    pub target: Vec<String>,
    /// Take an existing binary, such as `linux64=libnewtons_cradle.so`; compile only if there is a --target
    #[arg(long, value_name = "PLATFORM=FILE")]
    pub binary: Vec<String>,
    /// Optimise the compiled binary; recommended for every FMU in use
    #[arg(long)]
    pub release: bool,
    /// Where to write the FMU [default: a name from the preset, the parameter file or NewtonsCradle, and --balls; in
    /// Cargo's target/fmu if something is compiled, otherwise in the current folder]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Also run the FMU for its default experiment and write the results and options there, as NAME_ref.csv and
    /// NAME_ref.opt
    #[arg(long, value_name = "FOLDER")]
    pub reference: Option<PathBuf>,
}

impl Build {
    /// The description of the FMU with these start values.
    pub fn description<'a>(&self, start: &'a Settings) -> Result<Description<'a>, Error> {
        let refused = |what: &str, why: &str| {
            let text = format!("{what} is refused: FMI 2.0 has no {why}; allowed: together with --fmi 3");
            Err(Error::Usage(text))
        };
        let real_outputs = self.real_outputs;
        match (self.fmi.as_deref(), &self.clocks, self.scalars) {
            (Some("3"), clocks, scalars) => {
                let clocks = clocks.is_none() && !real_outputs;
                Ok(Description { clocks, scalars, real_outputs, ..Description::fmi3(start) })
            }
            (_, Some(_), _) => refused("--clocks none", "clocks"),
            (.., true) => refused("--scalars", "arrays"),
            _ => Ok(Description { real_outputs, ..Description::of(start) }),
        }
    }
}

fn build_help() -> String {
    let presets: Vec<String> = PRESETS.iter().map(|preset| format!("  {:8} {}", preset.name, preset.title())).collect();
    format!(
        "Presets:\n{}\n\n--parameters overrides the preset; --set overrides both.\n\n\
         Binaries come from --from, --binary and --target. Without any of them, one is compiled for this machine if \
         you are in the folder of the sources; elsewhere they come from the FMU that was installed with this \
         program.\n\n\
         An FMU gets parameter sets and reference results with which a host can check itself. Its binary is run to \
         make them.\n\n\
         The same sources and arguments give the same bytes. The date in the FMU is SOURCE_DATE_EPOCH, or 1980-01-01 \
         if it is not set.\
         \n\n{EXIT_CODES}",
        presets.join("\n")
    )
}
