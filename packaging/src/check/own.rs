//! Description, resources and GUID of an FMU belong together.

use newtons_cradle::variables::{Description, FILE_NAME, Recipe};

use super::model::Model;
use super::report::Report;
use crate::archive::Entries;

/// Checks an FMU of ours; whether this version can check all of it.
pub fn check(entries: &Entries, model: &Model, report: &mut Report) -> bool {
    let place = format!("resources/{FILE_NAME}");
    let recipe = entries.get(&place).map_or_else(|| Ok(Recipe::default()), |text| Recipe::from_json(text));
    let Some(settings) = report.accept(place, recipe.and_then(|recipe| recipe.settings())) else { return false };
    if model.tool != concat!("newtons-cradle ", env!("CARGO_PKG_VERSION")) {
        report.remark(format_args!("written by {}: this version cannot check its GUID", model.tool));
        return false;
    }
    let description = match model.is_fmi3() {
        true => Description::of_token(&settings, &model.guid).unwrap_or(Description::fmi3(&settings)),
        false => Description::of(&settings),
    };
    let guid = description.guid();
    if model.guid != guid {
        report.problem(format_args!("guid = \"{}\"; that of the resources is {guid}", model.guid));
    } else if description.xml(&model.date) != model.text {
        report.problem("modelDescription.xml: not the description that belongs to its GUID");
    }
    let picture = if model.is_fmi3() { "terminalsAndIcons/icon.png" } else { "model.png" };
    for name in ["documentation/index.html", "documentation/licenses/third-party.txt", picture] {
        report.require(entries.contains_key(name), format_args!("{name}: missing"));
    }
    true
}
