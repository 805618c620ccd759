//! The page in which the engine runs live. It is compiled apart (`web/build.py`); here it is only found and handed out.

use std::env;
use std::path::{Path, PathBuf};

use crate::archive;
use crate::environment;
use crate::error::Error;

/// Where the installed package, and where a checkout has it.
const PACKAGED: &str = "live.html";
const BUILT: &str = "target/web/cradle.html";

/// Writes the page to `out`: its size in bytes.
pub fn write(out: &Path) -> Result<usize, Error> {
    let page = find().ok_or_else(|| Error::Failure(format!("the live page is missing: {ADVICE}")))?;
    let failed = |error: std::io::Error| Error::Failure(format!("cannot read {}: {error}", page.display()));
    let bytes = std::fs::read(&page).map_err(failed)?;
    archive::replace(out, &bytes)?;
    Ok(bytes.len())
}

/// That of the environment this program is installed in, else that of the checkout of this folder or one above.
fn find() -> Option<PathBuf> {
    let here = env::current_dir().unwrap_or_default();
    let built = here.ancestors().map(|folder| folder.join(BUILT)).find(|page| page.is_file());
    environment::file(PACKAGED).or(built)
}

const ADVICE: &str = "the wheels of a release have it; in the folder of the sources, `rustup target add wasm32-unknown-unknown` and \
                      `python3 web/build.py` make it, for `cradle.py wheel` as well";
