//! Binaries and licences from another FMU of this program.

use std::path::Path;

use newtons_cradle::variables::MODEL_IDENTIFIER;

use super::choice::PRESETS;
use super::contents::Binary;
use crate::archive::Entries;
use crate::check::{self, MAX_BYTES, TOOL};
use crate::error::Error;
use crate::platform::libraries;
use crate::universal;

/// The parts of an FMU that are the same for every cradle.
#[derive(Default)]
pub struct Ready {
    /// The shared libraries.
    pub binaries: Vec<Binary>,
    /// The licences of their code, by path.
    pub licenses: Entries,
}

impl Ready {
    /// Takes the parts from an FMU, if it is valid and was written by this version of this program.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let refused = |reason: &str| Error::Usage(format!("--from {} is refused: {reason}", path.display()));
        let (mut entries, model, mut report) = check::open(&check::read(path)?, MAX_BYTES);
        if let Some(model) = &model {
            if !model.is_own() || model.tool != TOOL {
                let (name, tool) = (&model.name, if model.tool.is_empty() { "an unknown tool" } else { &model.tool });
                let reason = format!("it is \"{name}\", written by {tool}; allowed: {MODEL_IDENTIFIER} of {TOOL}");
                return Err(refused(&reason));
            }
            check::contents(&entries, model, &mut report);
        }
        if let Some(problem) = report.problems.first() {
            return Err(refused(problem));
        }
        let mut ready = Self::default();
        let fmi3 = model.is_some_and(|model| model.is_fmi3());
        for (platform, _, library) in libraries(&entries, MODEL_IDENTIFIER, fmi3) {
            ready.add((platform, library.to_vec())).map_err(|error| refused(&error))?;
        }
        entries.retain(|name, _| name.starts_with("documentation/licenses/"));
        ready.licenses = entries;
        Ok(ready)
    }

    /// Adds a shared library. Two libraries of macOS for different processors become a universal binary.
    pub fn add(&mut self, binary: Binary) -> Result<(), String> {
        let Some((platform, other)) = self.binaries.iter_mut().find(|(platform, _)| *platform == binary.0) else {
            self.binaries.push(binary);
            return Ok(());
        };
        let folder = platform.folder;
        let refused = |allowed: &str| format!("there are two binaries for {folder}; allowed: {allowed}");
        if folder != "darwin64" {
            return Err(refused("one"));
        }
        *other = universal::join(other, &binary.1)
            .map_err(|error| refused(&format!("one for each processor, but {error}")))?;
        Ok(())
    }
}

/// The contents of the file that the FMU `new` with this GUID is to replace, in words; none if there is no file, or it
/// has the same bytes.
pub fn replaced(path: &Path, new: &[u8], guid: &str) -> Option<String> {
    let old = check::read(path).ok().filter(|old| old != new)?;
    let (entries, Some(was), _) = check::open(&old, MAX_BYTES) else {
        return Some(format!("{} bytes, not an FMU", old.len()));
    };
    if was.guid == guid {
        return Some("the same cradle, with other binaries or documents".to_owned());
    }
    let what = match check::recipe(&entries).filter(|_| was.is_own()) {
        Some(own) => match PRESETS.iter().find(|preset| preset.recipe().is_ok_and(|recipe| recipe == own)) {
            Some(preset) => format!("preset {}", preset.name),
            None => format!("n = {}", own.balls),
        },
        None => format!("\"{}\"", was.name),
    };
    Some(format!("{what}, GUID {}; now GUID {guid}", was.guid))
}
