//! What a host is given: start values and resources.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::{env, fs, process};

use newtons_cradle::variables::{Access, FILE_NAME, MODEL_IDENTIFIER, Variable, variables};

/// Variables with values, `name=value` for each, with spaces between. An array takes one value for all elements, or one
/// for each, with commas between; an enumeration takes the name of an item.
pub fn assignments(balls: usize, text: &str) -> Vec<(Variable, f64)> {
    let assigned = |assignment: &str| {
        let (name, values) = assignment.split_once('=').unwrap();
        let is_named = |variable: &Variable| variable.row.name == name || variable.to_string() == name;
        let elements: Vec<Variable> = variables(balls).filter(is_named).collect();
        let values: Vec<&str> = values.split(',').collect();
        assert!(!elements.is_empty() && [1, elements.len()].contains(&values.len()), "{assignment}");
        let value = |element: Variable, text: &str| {
            let items = if let Access::Enumeration(of) = element.row.access { of.items } else { &[] };
            let item = items.iter().find(|item| item.name == text);
            (element, item.map_or_else(|| text.parse().unwrap(), |item| item.value.into()))
        };
        let texts = values.into_iter().cycle();
        elements.into_iter().zip(texts).map(|(element, text)| value(element, text)).collect::<Vec<_>>()
    };
    text.split_whitespace().flat_map(assigned).collect()
}

/// A folder of resources with this text in it, and its location. It lies beside the running program, in Cargo's target
/// folder.
pub fn resources(test: &str, text: &[u8]) -> (PathBuf, String) {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let beside = env::current_exe().unwrap().with_file_name("tmp");
    let folder = beside.join(format!("{MODEL_IDENTIFIER}-{test}/resources"));
    fs::create_dir_all(&folder).unwrap();
    // Replaced in one step, because another test may be reading the file.
    let draft = folder.join(format!("draft-{}-{}", process::id(), COUNT.fetch_add(1, Relaxed)));
    fs::write(&draft, text).unwrap();
    fs::rename(draft, folder.join(FILE_NAME)).unwrap();
    let location = format!("file://{}", folder.display());
    (folder, location)
}
