//! FMUs that this program writes: description, resources and GUID belong together.

use newtons_cradle::variables::{Description, FILE_NAME, Recipe};

use super::description::model::Model;
use super::report::Report;
use crate::archive::Entries;

/// Checks an FMU of ours; nothing for others.
pub fn check(entries: &Entries, model: &Model, report: &mut Report) {
    if !model.is_own() {
        return;
    }
    let place = format!("resources/{FILE_NAME}");
    let recipe = entries.get(&place).map_or_else(|| Ok(Recipe::default()), |text| Recipe::from_json(text));
    let Some(settings) = report.accept(place, recipe.and_then(|recipe| recipe.settings())) else { return };
    if model.tool != concat!("newtons-cradle ", env!("CARGO_PKG_VERSION")) {
        return report.remark(format_args!("written by {}: this version cannot check its GUID", model.tool));
    }
    let description = match model.is_fmi3() {
        true => Description::of_token(&settings, &model.guid).unwrap_or(Description::fmi3(&settings)),
        false => Description::of(&settings),
    };
    let guid = description.guid();
    if model.guid != guid {
        report.problem(format_args!("guid = \"{}\"; that of the resources is {guid}", model.guid));
    } else if description.xml(model.date.as_deref().unwrap_or_default()) != model.text {
        report.problem("modelDescription.xml: not the description that belongs to its GUID");
    }
    let picture = if model.is_fmi3() { "terminalsAndIcons/icon.png" } else { "model.png" };
    for name in ["documentation/index.html", "documentation/licenses/third-party.txt", picture] {
        report.require(entries.contains_key(name), format_args!("{name}: missing"));
    }
}
