//! `page` hands its arguments to a Python; here to scripts that stand in for one. tests/hosts makes a page with a real
//! one.
use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use super::support::{Folder, output, run};

/// A program in `folder` that is called as Python would be.
fn script(folder: &Folder, name: &str, text: &str) -> String {
    let path = folder.file(name);
    fs::create_dir_all(Path::new(&path).parent().unwrap()).unwrap();
    fs::write(&path, format!("#!/bin/sh\n{text}\n")).unwrap();
    fs::set_permissions(&path, Permissions::from_mode(0o755)).unwrap();
    path
}

#[test]
fn arguments_and_exit_code_are_passed_on() {
    let folder = Folder::new("passed");
    let python = script(&folder, "python", "[ \"$1\" = -c ] && exit 0\nprintf '<%s>' \"$@\"\nexit 7");
    let ended = run(&["page", "--python", &python, "a b.fmu", "--out", "c.html", "--python", "x", "--help"]);
    assert_eq!(ended.output, "<-m><newtons_cradle><page><a b.fmu><--out><c.html><--python><x><--help>");
    assert_eq!((ended.code, ended.error.as_str()), (7, ""));
}

#[test]
fn the_virtual_environment_above_is_taken() {
    let folder = Folder::new("venv");
    script(&folder, ".venv/bin/python", "printf %s \"$0\"");
    fs::create_dir_all(folder.file("deep/down")).unwrap();
    // Without a PATH no other Python is found.
    let command =
        format!("cd '{}' && PATH= exec '{}' page x.fmu", folder.file("deep/down"), env!("CARGO_BIN_EXE_cradle-fmu"));
    let ended = output("/bin/sh", &["-c", &command]);
    assert_eq!(ended.code, 0, "{}", ended.error);
    assert!(ended.output.ends_with("venv/.venv/bin/python"), "{}", ended.output);
}

#[test]
fn what_is_missing_is_named() {
    let folder = Folder::new("missing");
    let bare = script(&folder, "python", "exit 1");
    for (python, expected) in [(bare, "cannot import newtons_cradle; "), (folder.file("nothing"), "cannot run ")] {
        let failed = run(&["page", "--python", &python, "x.fmu"]);
        assert_eq!(failed.code, 1);
        for part in [expected, &python, "`pip install newtons-cradle`", "`python3 cradle.py paper`"] {
            assert!(failed.error.contains(part), "{}", failed.error);
        }
    }
    let refused = run(&["page"]);
    assert!(refused.code == 2 && refused.error.contains("<FILE>"), "{}", refused.error);
}
