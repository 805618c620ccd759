//! The recipe in the FMU's resources, whose location hosts give in very different ways.

use std::ffi::{CStr, OsString};
use std::io;
use std::path::PathBuf;
use std::sync::Mutex;

use crate::files::{self, MAX_START_VALUES};
use crate::instance::{Purpose, Start};
use crate::variables::{Description, FILE_NAME, Recipe, Refusal, Settings, ensure};

/// The description that an instance was made from.
struct KnownDescription {
    fmi3: bool,
    settings: Settings,
    guid: String,
    scalars: bool,
}

/// The last description used. Writing one for its hash takes longer than all else here, and a host that makes several
/// instances in a row uses the same one.
static KNOWN: Mutex<Option<KnownDescription>> = Mutex::new(None);

/// The recipe at `location`, a URI; the default one if there is no location or no file. Only this one file is looked
/// for.
pub(crate) fn at_location(location: &[u8]) -> Result<Recipe, Refusal> {
    if location.is_empty() { Ok(Recipe::default()) } else { first_of(folders(location, cfg!(windows))?) }
}

/// The recipe in the folder `path`; the default one if there is no path or no file. A URI is accepted, too.
pub(crate) fn at_path(path: &[u8]) -> Result<Recipe, Refusal> {
    let is_uri = path.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case(b"file:"));
    if path.is_empty() || is_uri { at_location(path) } else { first_of(vec![path.to_vec()]) }
}

/// What an instance is made from: the start values of a recipe, as in the first of its descriptions that has this
/// `token` (argument `name`); otherwise the reason why there is none.
pub(crate) fn start(
    purpose: Purpose,
    recipe: Result<Recipe, Refusal>,
    (name, token): (&str, &CStr),
) -> Result<Start, Refusal> {
    let settings = recipe?.settings().map_err(|error| Refusal::new(format_args!("resources: {error}")))?;
    let guid = token.to_string_lossy().into_owned();
    let is_known =
        |known: &&KnownDescription| known.fmi3 == purpose.fmi3 && known.guid == guid && known.settings == settings;
    let known = KNOWN.lock().ok().and_then(|known| known.as_ref().filter(is_known).map(|known| known.scalars));
    if let Some(scalars) = known {
        return Ok(Start { purpose, settings, scalars, guid });
    }
    let descriptions = Description::all(&settings, purpose.fmi3);
    if let Some(own) = descriptions.iter().find(|own| own.guid() == guid) {
        let scalars = own.scalars;
        if let Ok(mut known) = KNOWN.lock() {
            *known =
                Some(KnownDescription { fmi3: purpose.fmi3, settings: settings.clone(), guid: guid.clone(), scalars });
        }
        return Ok(Start { purpose, settings, scalars, guid });
    }
    let own = descriptions[0].guid();
    let allowed = format_args!("{own}, that of the description that belongs to this binary and resources");
    Err(Refusal::argument(name, guid, allowed))
}

/// The recipe in the first of these folders that has one; otherwise the default one.
fn first_of(folders: Vec<Vec<u8>>) -> Result<Recipe, Refusal> {
    for folder in folders {
        let file = os_path(folder).join(FILE_NAME);
        let text = match files::read(&file, MAX_START_VALUES) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(error) => return Err(Refusal::new(format_args!("{}: {error}", file.display()))),
        };
        return Recipe::from_json(&text).map_err(|refusal| Refusal::new(format_args!("{}: {refusal}", file.display())));
    }
    Ok(Recipe::default())
}

/// The folders that `location` may mean, likelier first: most hosts encode it, some do not.
fn folders(location: &[u8], windows: bool) -> Result<Vec<Vec<u8>>, Refusal> {
    let scheme = location.split_at_checked(5).filter(|(scheme, _)| scheme.eq_ignore_ascii_case(b"file:"));
    let Some((_, rest)) = scheme else {
        let text = String::from_utf8_lossy(location);
        let allowed = "a location that starts with file:";
        ensure(!text.contains("://"), || Refusal::argument("fmuResourceLocation", text, allowed))?;
        return Ok(vec![location.to_vec()]); // A plain path, from a host that does not know better.
    };
    let decoded = decode(rest);
    let mut folders = vec![path(&decoded, windows)?];
    if decoded != rest {
        folders.push(path(rest, windows)?);
    }
    Ok(folders)
}

/// Replaces `%41` by `A`; invalid sequences stay.
fn decode(text: &[u8]) -> Vec<u8> {
    let (mut decoded, mut rest) = (Vec::new(), text);
    while let [byte, tail @ ..] = rest {
        let code = tail.get(..2).filter(|code| *byte == b'%' && code.iter().all(u8::is_ascii_hexdigit));
        let code = code.and_then(|code| u8::from_str_radix(std::str::from_utf8(code).ok()?, 16).ok());
        decoded.push(code.unwrap_or(*byte));
        rest = if code.is_some() { &tail[2..] } else { tail };
    }
    decoded
}

fn refused(rest: &[u8], allowed: &str) -> Refusal {
    Refusal::argument("fmuResourceLocation", format_args!("file:{}", String::from_utf8_lossy(rest)), allowed)
}

/// The path behind `file:`, with one to four slashes in front, a host name between, or a Windows drive.
fn path(rest: &[u8], windows: bool) -> Result<Vec<u8>, Refusal> {
    let slashes = rest.iter().take_while(|byte| **byte == b'/').count();
    let bare = &rest[slashes..];
    if windows && let [drive, b':' | b'|', tail @ ..] = bare {
        return Ok([&[*drive, b':'], tail].concat());
    }
    match slashes {
        0 => Err(refused(rest, "an absolute path")),
        2 => match bare.strip_prefix(b"localhost/") {
            Some(local) => path(&[b"/", local].concat(), windows),
            None if windows => Ok([b"//", bare].concat()),
            None => Err(refused(rest, "a path on this machine, as in file:///path")),
        },
        4 if windows => Ok([b"//", bare].concat()),
        _ => Ok([b"/", bare].concat()),
    }
}

#[cfg(unix)]
fn os_path(path: Vec<u8>) -> PathBuf {
    use std::os::unix::ffi::OsStringExt;
    PathBuf::from(OsString::from_vec(path))
}

#[cfg(not(unix))]
fn os_path(path: Vec<u8>) -> PathBuf {
    PathBuf::from(OsString::from(String::from_utf8_lossy(&path).into_owned()))
}

#[cfg(test)]
mod tests {
    use std::ffi::CString;

    use super::*;
    use crate::instance::Kind;

    fn on(windows: bool, location: &str) -> Vec<String> {
        let folders = folders(location.as_bytes(), windows).unwrap();
        folders.into_iter().map(|folder| String::from_utf8(folder).unwrap()).collect()
    }

    #[test]
    fn resources_description_is_recognised() {
        let (five, six) = (Recipe::default(), Recipe::new(6));
        let settings = five.settings().unwrap();
        let [fmi2, fmi3] = [Description::of(&settings), Description::fmi3(&settings)].map(|own| own.guid());
        let made = |recipe: &Recipe, purpose, token: &str| {
            let token = CString::new(token).unwrap();
            start(purpose, Ok(recipe.clone()), ("fmuGUID", &token)).map(|start| start.scalars)
        };
        let of_fmi2 = Purpose::fmi2(Kind::CoSimulation);
        let of_fmi3 = Purpose { fmi3: true, ..of_fmi2 };
        for _ in 0..2 {
            assert_eq!(made(&five, of_fmi2, &fmi2), Ok(true));
            assert!(made(&six, of_fmi2, &fmi2).unwrap_err().to_string().contains(&fmi2));
            assert!(made(&five, of_fmi3, &fmi2).is_err() && made(&five, of_fmi2, &fmi3).is_err());
            assert_eq!(made(&five, of_fmi3, &fmi3), Ok(false));
        }
    }

    #[test]
    fn resources_location_of_every_host_is_understood() {
        for location in ["file:///a/r", "file:/a/r", "file:////a/r", "file://localhost/a/r", "FILE:///a/r", "/a/r"] {
            assert_eq!(on(false, location), ["/a/r"], "{location}");
        }
        assert_eq!(on(false, "file:///a/r/"), ["/a/r/"]);
        assert_eq!(on(false, "file:///a%20b/r"), ["/a b/r", "/a%20b/r"]);
        assert_eq!(on(false, "file:///a b/100%/%zz/r"), ["/a b/100%/%zz/r"]);
        assert_eq!(on(false, "file:///a/r%"), ["/a/r%"]);
        assert_eq!(on(false, "file:///a/r%2"), ["/a/r%2"]);
    }

    #[test]
    fn resources_location_on_windows_is_understood() {
        for location in ["file:///C:/a/r", "file:/C:/a/r", "file:////C:/a/r", "file://C:/a/r", "file:///C|/a/r"] {
            assert_eq!(on(true, location), ["C:/a/r"], "{location}");
        }
        assert_eq!(on(true, "file:///C%3A/a/r").first().unwrap(), "C:/a/r");
        assert_eq!(on(true, "file://server/share/r"), ["//server/share/r"]);
        assert_eq!(on(true, "file:////server/share/r"), ["//server/share/r"]);
    }

    #[test]
    fn resources_location_elsewhere_is_refused() {
        for location in ["http://example.org/r", "file:r", "file://elsewhere/r"] {
            assert!(folders(location.as_bytes(), false).unwrap_err().to_string().contains("allowed: "), "{location}");
        }
    }
}
