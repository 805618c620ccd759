//! `build`: from the arguments to the file.

use std::fs;
use std::path::{Path, PathBuf};

use cradle_packaging::archive;
use cradle_packaging::build::{self, Choice, Preset, Ready, Workspace};
use cradle_packaging::platform::Platform;
use cradle_packaging::{Error, check, environment, reference};

use super::arguments::Build;
use super::say::{say, tell};

impl Build {
    /// Writes the FMU.
    pub fn run(self) -> Result<(), Error> {
        let choice = self.choice()?;
        let name = choice.name.clone();
        let is_chosen = choice.names("contact.dampingLaw");
        let mut recipe = choice.recipe()?;
        if let Some(asked) = self.restitution {
            tell(asked.apply(&mut recipe, is_chosen)?);
        }
        let start = recipe.settings()?;
        let description = self.description(&start)?;
        // A preset alone gives no warnings.
        if !self.set.is_empty() || !self.parameters.is_empty() {
            start.warnings(None).iter().for_each(|warning| tell(format_args!("warning: {warning}")));
        }
        // The parent of a bare file name is an empty path, which stands for the current folder.
        let missing = |folder: &&Path| *folder != Path::new("") && !folder.is_dir();
        if let Some(missing) = self.out.as_deref().and_then(Path::parent).filter(missing) {
            return Err(Error::Usage(format!("--out: there is no folder {}", missing.display())));
        }
        if let Some(out) = &self.out {
            archive::target(out)
                .map_err(|error| Error::Usage(format!("--out: cannot write {}: {error}", out.display())))?;
        }
        let (ready, folder) = self.ready()?;
        let out = self.out.clone().unwrap_or_else(|| folder.join(format!("{name}.fmu")));
        let real = |path: &Path| fs::canonicalize(path).ok();
        let same = |from: &&PathBuf| real(from).is_some_and(|from| real(&out) == Some(from));
        if let Some(from) = self.from.as_ref().filter(same).map(|from| from.display()) {
            return Err(Error::Usage(format!(
                "the new FMU would replace {from}, from which it is made; give another file with --out"
            )));
        }
        let runs_here = ready.binaries.iter().any(|(platform, _)| Platform::host() == Some(*platform));
        let mut entries = build::entries(&recipe, &description, ready.binaries)?;
        entries.extend(ready.licenses);
        for missing in reference::add(&mut entries, &description) {
            tell(format_args!("warning: the FMU gets no reference results{missing}"));
        }
        let beside = self.reference.as_ref().map(|folder| reference::beside(&entries, &out, folder)).transpose()?;
        let bytes = archive::bytes(entries)
            .map_err(|error| Error::Failure(format!("cannot pack {}: {error}", out.display())))?;
        let replaced = build::replaced(&out, &bytes, &description.guid());
        archive::replace(&out, &bytes)?;
        let path = shown(&out).display().to_string();
        if let Some(what) = replaced {
            tell(format_args!("Replaced {path}, which was: {what}"));
        }
        let beside: String = beside.iter().flatten().map(|file| format!("{}\n", shown(file).display())).collect();
        // The Python package makes the page.
        let command = if environment::has_package() { "page" } else { "check" };
        let program = quoted(&std::env::args().next().unwrap_or_else(|| "cradle-fmu".to_owned()));
        let hint = format!("Try it: {program} {command} {}\n", quoted(&path));
        let (size, hint) = (bytes.len().div_ceil(1000), if runs_here { &hint } else { "" });
        say(format_args!("{path} ({size} kB, n = {})\n{beside}{hint}", recipe.balls))
    }

    /// The cradle, and the name of its file.
    fn choice(&self) -> Result<Choice, Error> {
        let mut choice = Choice::default();
        if let Some(preset) = &self.preset {
            choice.preset(Preset::named(preset)?)?;
        }
        self.parameters.iter().try_for_each(|file| choice.file(file))?;
        self.set.iter().try_for_each(|text| choice.set(text))?;
        if let Some(balls) = self.balls {
            choice.balls(balls);
        }
        if self.fmi.as_deref() == Some("3") {
            choice.name.push_str(".fmi3");
        }
        Ok(choice)
    }

    /// The binaries, and the folder for the FMU if none is named: Cargo's if they are compiled, else the current one.
    fn ready(&self) -> Result<(Ready, PathBuf), Error> {
        let mut ready = self.from.as_deref().map_or_else(|| Ok(Ready::default()), Ready::of)?;
        for text in &self.binary {
            let refused = |reason: &str| Error::Usage(format!("--binary {text} is refused: {reason}"));
            let (folder, file) = text.split_once('=').ok_or_else(|| refused("allowed: PLATFORM=FILE"))?;
            let platform = Platform::named(folder).map_err(|reason| refused(&reason))?;
            add(&mut ready, platform, Path::new(file), &format!("--binary {folder}"))?;
        }
        let (here, workspace) = (self.target.is_empty(), Workspace::find());
        if here && ready.binaries.is_empty() && workspace.is_none() {
            ready = Ready::of(&environment::fmu().ok_or_else(|| Error::Failure(NO_BINARY.to_owned()))?)?;
        }
        if here && !ready.binaries.is_empty() {
            return Ok((ready, PathBuf::new()));
        }
        let workspace = workspace.ok_or_else(|| Error::Failure(NO_SOURCES.to_owned()))?;
        let how = if self.release { "release" } else { "debug" };
        let of = if here { "this machine".to_owned() } else { self.target.join(", ") };
        tell(format_args!("Compiling the FMU's binary for {of} ({how})"));
        for (platform, file) in workspace.libraries(&self.target, self.release)? {
            add(&mut ready, platform, &file, "--target")?;
        }
        Ok((ready, workspace.target.join("fmu")))
    }
}

const NO_SOURCES: &str = "to compile, run this in the folder of the sources, or use --from or --binary";

const NO_BINARY: &str = concat!(
    "there is no binary to pack: give an FMU of newtons-cradle ",
    env!("CARGO_PKG_VERSION"),
    " with --from, or use the program that `pip install newtons-cradle` installs, or run this in the folder of the \
     sources"
);

fn add(ready: &mut Ready, platform: &'static Platform, file: &Path, argument: &str) -> Result<(), Error> {
    let name = file.display();
    let contents = check::read(file).map_err(|error| Error::Usage(format!("{argument}: {error}")))?;
    platform.check(&contents).map_err(|error| Error::Usage(format!("{argument}: {name} is {error}")))?;
    ready.add((platform, contents)).map_err(|error| Error::Usage(format!("{argument}: {error}")))
}

/// A path as typed from the current folder.
fn shown(path: &Path) -> &Path {
    std::env::current_dir().ok().and_then(|here| path.strip_prefix(here).ok()).unwrap_or(path)
}

/// A word, quoted for the shell if necessary.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '/' | '\\' | '.' | ':' | '_' | '-' | '+');
    if word.chars().all(plain) {
        word.to_owned()
    } else if cfg!(windows) {
        format!("\"{word}\"")
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
