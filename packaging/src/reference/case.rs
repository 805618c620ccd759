//! What is run for reference: the FMU as it is, and the presets of as many balls.

use newtons_cradle::variables::{Recipe, Settings, Variable};

use crate::build::{Choice, PRESETS};
use crate::error::Error;

/// From this number of balls on the run is short.
const MANY_BALLS: usize = 101;

/// The case of the FMU as it is.
pub const START: &str = "start";

/// A cradle that the FMU becomes when parameters are set.
pub struct Case {
    /// What its files are called.
    pub name: &'static str,
    /// One line on it.
    pub title: &'static str,
    /// Its start values.
    pub settings: Settings,
}

/// The FMU's own start values first, then the presets.
pub fn cases(recipe: &Recipe) -> Result<Vec<Case>, Error> {
    let settings = recipe.settings().map_err(|error| Error::Usage(error.to_string()))?;
    let mut cases = vec![Case { name: START, title: "The start values of this FMU.", settings }];
    for preset in PRESETS {
        let settings = Choice::settings_of(preset)?;
        if settings.balls() == recipe.balls {
            cases.push(Case { name: preset.name, title: preset.title(), settings });
        }
    }
    Ok(cases)
}

/// The communication points of the results in the FMU, s: ten seconds, or one of many balls, in steps of 0.1 s.
pub fn times(balls: usize) -> Vec<f64> {
    (0..=if balls < MANY_BALLS { 100 } else { 10 }).map(|step| f64::from(step) / 10.0).collect()
}

/// What is recorded, at most ten variables: balls at both ends, the impulses of the contacts there, momentum and
/// energy.
pub fn recorded(balls: usize) -> Vec<Variable> {
    let ends = |name: &str, count: usize, of: usize| -> Vec<String> {
        (1..=of)
            .filter(|index| *index <= count || *index + count > of)
            .map(|index| format!("{name}[{index}]"))
            .collect()
    };
    let mut names = ends("x", 3, balls);
    names.extend(ends("impulse", 1, balls - 1));
    names.extend(["p_total", "E_total"].map(str::to_owned));
    names.iter().filter_map(|name| Variable::named(name, balls)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_most_ten_variables_are_recorded() {
        let names = |balls| recorded(balls).iter().map(Variable::to_string).collect::<Vec<_>>().join(" ");
        assert_eq!(names(1), "x[1] p_total E_total");
        assert_eq!(names(2), "x[1] x[2] impulse[1] p_total E_total");
        assert_eq!(names(13), "x[1] x[2] x[3] x[11] x[12] x[13] impulse[1] impulse[12] p_total E_total");
    }

    #[test]
    fn presets_of_other_numbers_of_balls_are_none_of_this_fmu() {
        let names =
            |balls| cases(&Recipe::new(balls)).unwrap().iter().map(|case| case.name).collect::<Vec<_>>().join(" ");
        assert_eq!(names(5), "start figure4 figure5 figure6 desk");
        assert_eq!(names(13), "start figure3");
        assert_eq!(names(2), "start");
    }
}
