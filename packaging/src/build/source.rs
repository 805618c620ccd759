//! Where binaries come from that are not compiled: another FMU of this program.

use std::path::{Path, PathBuf};

use newtons_cradle::variables::{Description, MODEL_IDENTIFIER};

use super::choice::Choice;
use super::contents::Binary;
use super::preset::PRESETS;
use crate::archive::Entries;
use crate::check::{self, MAX_BYTES, Model, Report};
use crate::error::Error;
use crate::platform::Platform;
use crate::universal;

const TOOL: &str = concat!("newtons-cradle ", env!("CARGO_PKG_VERSION"));

/// What an FMU has that serves every cradle.
#[derive(Default)]
pub struct Ready {
    /// The shared libraries.
    pub binaries: Vec<Binary>,
    /// The licences of what is in them.
    pub licenses: Entries,
}

impl Ready {
    /// Takes them from an FMU, if this version of this program has written it and nothing is wrong with it.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let bytes = check::read(path)?;
        let refused = |reason: &str| Error::Usage(format!("--from {} is refused: {reason}", path.display()));
        let mut report = Report::default();
        let entries = check::unpack(&bytes, MAX_BYTES, &mut report).unwrap_or_default();
        let model = entries.get("modelDescription.xml").and_then(|text| Model::read(text, &mut report));
        if let Some(model) = &model {
            let (name, tool) = (&model.name, if model.tool.is_empty() { "an unknown tool" } else { &model.tool });
            if !model.is_own() {
                return Err(refused(&format!(
                    "it is \"{name}\", written by {tool}; allowed: {MODEL_IDENTIFIER} of {TOOL}"
                )));
            }
            if tool != TOOL {
                return Err(refused(&format!("it was written by {tool}; allowed: {TOOL}")));
            }
        }
        let (report, _) = check::bytes(&bytes, MAX_BYTES);
        if let Some(problem) = report.problems.first() {
            return Err(refused(problem));
        }
        let mut ready = Self::default();
        for (name, contents) in entries {
            if let Some(platform) = Platform::of_path(&name, MODEL_IDENTIFIER) {
                match ready.binaries.iter_mut().find(|other| other.platform == platform) {
                    Some(other) => {
                        other.contents =
                            universal::join(&other.contents, &contents).map_err(|error| refused(&error))?;
                    }
                    None => ready.binaries.push(Binary { platform, contents }),
                }
            } else if name.starts_with("documentation/licenses/") {
                ready.licenses.insert(name, contents);
            }
        }
        Ok(ready)
    }
}

/// The folder of the sources that this folder lies in, if it does.
pub fn checkout() -> Option<PathBuf> {
    let is_ours = |folder: &&Path| {
        let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
        let manifest: toml::Table = manifest.parse().unwrap_or_default();
        let name = manifest.get("package").and_then(|package| package.get("name"));
        name.and_then(toml::Value::as_str) == Some("newtons-cradle")
    };
    std::env::current_dir().ok()?.ancestors().find(is_ours).map(Path::to_path_buf)
}

/// What is in a file that is about to be replaced by the FMU `new`, in words; nothing if there is no file, or the same.
pub fn replaced(path: &Path, new: &[u8]) -> Option<String> {
    let old = check::read(path).ok().filter(|old| old != new)?;
    let model = |bytes: &[u8]| {
        let mut unused = Report::default();
        let entries = check::unpack(bytes, MAX_BYTES, &mut unused)?;
        Model::read(entries.get("modelDescription.xml")?, &mut unused)
    };
    let (Some(was), Some(is)) = (model(&old), model(new)) else {
        return Some(format!("{} bytes, not an FMU", old.len()));
    };
    if was.guid == is.guid {
        return Some("the same cradle, with other binaries or documents".to_owned());
    }
    let balls = was.balls;
    let preset = PRESETS.iter().find(|preset| {
        Choice::settings_of(preset).is_ok_and(|settings| match was.is_fmi3() {
            true => Description::of_token(&settings, &was.guid).is_some(),
            false => Description::of(&settings).guid() == was.guid,
        })
    });
    let what = match preset {
        Some(preset) => format!("preset {}", preset.name),
        None if was.is_own() => format!("n = {balls}"),
        None => format!("\"{}\"", was.name),
    };
    Some(format!("{what}, GUID {}; now GUID {}", was.guid, is.guid))
}
