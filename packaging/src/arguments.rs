//! The command line. It is put together by calls: to derive it, procedural macros would have to be compiled that nothing else
//! needs.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use cradle_packaging::build::{PRESETS, Standard};

/// What the user asks for.
pub enum Request {
    Build(Build),
    Check { file: PathBuf, load: bool },
    Info { file: PathBuf },
    Presets,
    Live { out: PathBuf },
    Page { python: Option<OsString>, arguments: Vec<OsString> },
    Probe { folder: PathBuf, findings: PathBuf },
    Record { folder: PathBuf, experiment: bool },
}

/// Write an FMU.
pub struct Build {
    pub standard: Standard,
    pub balls: Option<usize>,
    pub set: Vec<String>,
    pub parameters: Vec<PathBuf>,
    pub preset: Option<String>,
    pub from: Option<PathBuf>,
    pub target: Vec<String>,
    pub binary: Vec<String>,
    pub release: bool,
    pub out: Option<PathBuf>,
    pub reference: Option<PathBuf>,
}

/// Reads the command line; ends the program if it is wrong or asks for help.
pub fn parse() -> Request {
    let mut matches = command().get_matches();
    let (name, mut given) = matches.remove_subcommand().expect("a subcommand is required");
    match name.as_str() {
        "build" => Request::Build(Build::of(given)),
        "check" => Request::Check { file: required(&mut given, "file"), load: !given.get_flag("no-load") },
        "info" => Request::Info { file: required(&mut given, "file") },
        "presets" => Request::Presets,
        "live" => Request::Live { out: required(&mut given, "out") },
        "record" => {
            Request::Record { folder: required(&mut given, "folder"), experiment: given.get_flag("experiment") }
        }
        "page" => Request::Page { python: given.remove_one("python"), arguments: several(&mut given, "arguments") },
        _ => Request::Probe { folder: required(&mut given, "folder"), findings: required(&mut given, "findings") },
    }
}

impl Build {
    fn of(mut given: ArgMatches) -> Self {
        let version = given.remove_one::<String>("fmi").unwrap_or_default();
        let clocks = given.remove_one::<String>("clocks").is_none();
        if version != "3" && !clocks {
            let reason = "--clocks none is refused: FMI 2.0 has no clocks; allowed: together with --fmi 3\n";
            command().error(ErrorKind::ArgumentConflict, reason).exit();
        }
        Self {
            standard: if version == "3" { Standard::Fmi3 { clocks } } else { Standard::Fmi2 },
            balls: given.remove_one("balls"),
            set: several(&mut given, "set"),
            parameters: several(&mut given, "parameters"),
            preset: given.remove_one("preset"),
            from: given.remove_one("from"),
            target: several(&mut given, "target"),
            binary: several(&mut given, "binary"),
            release: given.get_flag("release"),
            out: given.remove_one("out"),
            reference: given.remove_one("reference"),
        }
    }
}

fn required(given: &mut ArgMatches, name: &str) -> PathBuf {
    given.remove_one(name).expect("clap has seen to it")
}

fn several<T: Clone + Send + Sync + 'static>(given: &mut ArgMatches, name: &str) -> Vec<T> {
    given.remove_many(name).into_iter().flatten().collect()
}

const EXIT_CODES: &str = "\
Exit codes: 0 success; 1 failure, or `check` found problems; 2 the arguments are refused, or the file cannot be read.";

fn command() -> Command {
    let command = |name: &'static str, about: &'static str| Command::new(name).about(about).after_help(EXIT_CODES);
    let path = |name: &'static str| Arg::new(name).value_parser(value_parser!(PathBuf)).required(true);
    let file = path("file").value_name("FILE").help("The FMU");
    let check = command(
        "check",
        "Say what is wrong with an FMU: zip entries, description, binaries, and how they answer on this machine",
    )
    .long_about(
        "Say what is wrong with an FMU: zip entries, description, binaries, and how they answer on this machine.\n\n\
         Works on any FMU of FMI 2.0, and of FMI 3.0 for co-simulation. The binary for this machine is loaded in a separate process and runs for one step.",
    )
    .args([file.clone(), flag("no-load").help("Do not load the binary")]);
    let probe = Command::new("probe")
        .about("Load the binary of an unpacked FMU and write problems with its answers to a file; `check` runs this")
        .hide(true)
        .args([path("folder"), path("findings")]);
    let record = Command::new("record")
        .about("Run the binary of an unpacked FMU for its reference results; `build` runs this")
        .hide(true)
        .args([path("folder"), flag("experiment")]);
    let presets = command("presets", "List the presets that `build --preset` takes");
    let live =
        command("live", "Write the page in which the cradle runs live: one HTML file for a browser, no network needed")
            .arg(
                path("out")
                    .long("out")
                    .value_name("FILE")
                    .required(false)
                    .default_value("cradle.html")
                    .help("Where to write it"),
            );
    command("cradle-fmu", "Builds, checks, describes and shows FMUs of Newton's cradle")
        .version(env!("CARGO_PKG_VERSION"))
        .subcommand_required(true)
        .arg_required_else_help(true)
        .subcommands([
            build(),
            check,
            command("info", "Say what is in an FMU").arg(file),
            presets,
            live,
            page(),
            probe,
            record,
        ])
}

fn page() -> Command {
    Command::new("page")
        .about("Make a 3D animation of an FMU's run, or of a result in CSV: one HTML file that needs no network")
        .long_about(
            "Make a 3D animation of an FMU's run, or of a result in CSV: one HTML file that needs no network.\n\n\
             This runs `python -m newtons_cradle page`, with all arguments except --python. \
             `cradle-fmu page x.fmu --help` lists them. `pip install newtons-cradle` installs what is needed. So does \
             `python3 cradle.py paper` in the folder of the sources.",
        )
        .after_help("Exit codes: those of Python; 1 if Python cannot be run.")
        .args([
            Arg::new("python")
                .long("python")
                .value_name("PROGRAM")
                .value_parser(value_parser!(OsString))
                .help("The Python to run [default: the first that has the package: beside this program, on the PATH, or in .venv in \
                       this folder or one above]"),
            Arg::new("arguments")
                .value_names(["FILE", "ARGUMENT"])
                .value_parser(value_parser!(OsString))
                .num_args(1..)
                .required(true)
                .trailing_var_arg(true)
                .allow_hyphen_values(true)
                .help("An .fmu or .csv file, then options such as --out cradle.html, --stop 5, --set contact.model=hertz"),
        ])
}

fn build() -> Command {
    let option = |name: &'static str, value: &'static str| Arg::new(name).long(name).value_name(value);
    let list = |name: &'static str, value: &'static str| option(name, value).action(ArgAction::Append);
    Command::new("build")
        .about("Write an FMU of a cradle: pack existing or newly compiled binaries with description and documentation")
        .after_help(build_help())
        .args([
            option("balls", "N")
                .value_parser(value_parser!(usize))
                .allow_negative_numbers(true)
                .help("Number of balls, 1 to 10000 [default: that of the preset or parameter file, or 5]"),
            list("set", "NAME=VALUE")
                .help("Set a start value; an array as `x_start[1]=-0.1` or `x_start=-0.1,-0.1,0`, an enumeration by item name"),
            list("parameters", "FILE.toml")
                .value_parser(value_parser!(PathBuf))
                .help("Take the number of balls and start values from a TOML file in the format of the presets"),
            option("fmi", "VERSION")
                .value_parser(["2", "3"])
                .help("Version of the standard [default: 2]; the default file of version 3 is called NAME.fmi3.fmu"),
            option("clocks", "none")
                .value_parser(["none"])
                .help("Leave the clocks of version 3 out, with the variables they tell of, for hosts that take none"),
            option("preset", "NAME").help("Start from a preset, see below"),
            option("from", "FILE.fmu")
                .value_parser(value_parser!(PathBuf))
                .help("Take binaries and licences from an FMU that this version of this program has written; nothing is compiled"),
            list("target", "TRIPLE").help("Compile for a Rust target triple [default: this machine]").long_help(
                "Compile for a Rust target triple [default: this machine].\n\n\
                 A triple with a glibc version, such as `x86_64-unknown-linux-gnu.2.17`, needs cargo-zigbuild. Its binary \
                 runs on systems with that glibc or a newer one.",
            ),
            list("binary", "PLATFORM=FILE")
                .help("Take an existing binary, such as `linux64=libnewtons_cradle.so`; compile only if there is a --target"),
            flag("release").help("Optimise what is compiled; recommended for every FMU that is to be used"),
            option("out", "FILE").value_parser(value_parser!(PathBuf)).help(
                "Where to write the FMU [default: a name from the preset, the parameter file or NewtonsCradle, and --balls; in \
                 Cargo's target/fmu if something is compiled, otherwise in the current folder]",
            ),
            option("reference", "FOLDER").value_parser(value_parser!(PathBuf)).help(
                "Also run the FMU for its default experiment and write the results and options there, as NAME_ref.csv and NAME_ref.opt",
            ),
        ])
}

fn build_help() -> String {
    let presets: Vec<String> = PRESETS.iter().map(|preset| format!("  {:8} {}", preset.name, preset.title())).collect();
    format!(
        "Presets:\n{}\n\n--parameters overrides the preset; --set overrides both.\n\n\
         Binaries come from --from, --binary and --target. Without any of them, one is compiled for this machine if you are in the \
         folder of the sources; elsewhere they come from the FMU that was installed with this program.\n\n\
         An FMU of FMI 2.0 gets parameter sets and reference results with which a host can check itself. Its binary is run to make \
         them.\n\n\
         The same sources and arguments give the same bytes. The date in the FMU is SOURCE_DATE_EPOCH, or 1980-01-01 if it is not set.\
         \n\n{EXIT_CODES}",
        presets.join("\n")
    )
}

fn flag(name: &'static str) -> Arg {
    Arg::new(name).long(name).action(ArgAction::SetTrue)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_arguments_are_consistent() {
        super::command().debug_assert();
    }
}
