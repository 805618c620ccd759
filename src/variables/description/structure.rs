//! ModelStructure: which unknowns there are and on what they depend.

use std::fmt::{self, Write};

use crate::model::ContactModel;
use crate::variables::settings::Settings;
use crate::variables::states::states;
use crate::variables::table::TABLE;
use crate::variables::table::row::{Causality, Groups, Row, Shape};
use crate::variables::variable::{Variable, variables};

/// Balls beyond which it is not listed on which overlaps each position depends: that grows with the square of their
/// number.
const LISTED: usize = 500;

/// What the force of a rigid contact depends on.
const EVERYTHING: Groups = &[&["all positions", "all v", "all F_ext", "a_support"]];

/// Writes Outputs, Derivatives and InitialUnknowns of the FMU with these start values.
///
/// In co-simulation no output depends on an input at the same communication point: an input acts from the next step on.
/// In model exchange outputs and derivatives depend on states and inputs. At initialization they depend on parameters.
pub(super) fn write_structure(out: &mut String, start: &Settings) -> fmt::Result {
    let balls = start.balls();
    let indices = Indices::of(balls);
    let rigid = start.parameters.contact_model == ContactModel::Rigid;
    out.write_str("    <Outputs>\n")?;
    for variable in variables(balls).filter(|variable| variable.row.causality == Causality::Output) {
        write_following(out, &indices, variable, rigid)?;
    }
    out.write_str("    </Outputs>\n    <Derivatives>\n")?;
    for (_, derivative) in states(balls) {
        write_following(out, &indices, derivative, rigid)?;
    }
    out.write_str("    </Derivatives>\n    <InitialUnknowns>\n")?;
    for (position, row) in TABLE.iter().enumerate() {
        let exchanged = Variable { row, position, index: 0 }.is_exchanged();
        if exchanged || matches!(row.causality, Causality::Output | Causality::CalculatedParameter) {
            write_initial(out, &indices, position, row)?;
        }
    }
    out.write_str("    </InitialUnknowns>\n")
}

/// Writes on which states and inputs `variable` depends in model exchange.
fn write_following(out: &mut String, indices: &Indices, variable: Variable, rigid: bool) -> fmt::Result {
    write!(out, "      <Unknown index=\"{}\"", indices.of_variable(variable))?;
    let row = variable.row;
    let of_forces = matches!(row.name, "F" | "F_mean" | "a" | "der(E_dissipated)");
    let many = row.shape == Shape::Balls && indices.balls > LISTED;
    if !many || row.follows.iter().copied().flatten().all(|name| *name != "position") {
        let groups = if rigid && of_forces { EVERYTHING } else { row.follows };
        write_indices(out, indices.following(variable, groups))?;
    }
    out.write_str("/>\n")
}

fn write_indices(out: &mut String, indices: Vec<usize>) -> fmt::Result {
    out.write_str(" dependencies=\"")?;
    for (i, dependency) in indices.into_iter().enumerate() {
        write!(out, "{}{dependency}", if i == 0 { "" } else { " " })?;
    }
    out.write_str("\"")
}

/// Writes the initial unknowns of one row.
fn write_initial(out: &mut String, indices: &Indices, position: usize, row: &'static Row) -> fmt::Result {
    let knowns = row.initially.map(|groups| indices.knowns(groups));
    for index in 0..row.shape.len(indices.balls) {
        let variable = Variable { row, position, index };
        write!(out, "      <Unknown index=\"{}\"", indices.of_variable(variable))?;
        if let Some(knowns) = &knowns {
            write_indices(out, indices.dependencies(variable, knowns))?;
        }
        out.write_str("/>\n")?;
    }
    Ok(())
}

/// The index of the first variable of each row in ModelVariables, counted from 1.
pub(super) fn first_indices(balls: usize) -> Vec<usize> {
    let next = |next: &mut usize, row: &Row| {
        let first = *next;
        *next += row.shape.len(balls);
        Some(first)
    };
    TABLE.iter().scan(1, next).collect()
}

/// Positions in ModelVariables, counted from 1.
struct Indices {
    balls: usize,
    /// Index of the first variable of each row.
    first: Vec<usize>,
}

/// What a value depends on, a row or one variable of a row: the index of its first variable, its shape, and whether it
/// depends on balls next to its own as well.
type Known = (usize, Shape, bool);

impl Indices {
    fn of(balls: usize) -> Self {
        Self { balls, first: first_indices(balls) }
    }

    fn of_variable(&self, variable: Variable) -> usize {
        self.first.get(variable.position).map_or(0, |first| first + variable.index)
    }

    /// The rows and variables behind names, looked up once for all variables of a row.
    fn knowns(&self, groups: Groups) -> Vec<Known> {
        let known = |name: &&str| {
            let (name, beside) = name.strip_suffix('*').map_or((*name, false), |name| (name, true));
            match Variable::named(name, self.balls) {
                Some(single) => Some((self.of_variable(single), Shape::Scalar, false)),
                None => {
                    let (first, row) = self.first.iter().zip(TABLE).find(|(_, row)| row.name == name)?;
                    Some((*first, row.shape, beside))
                }
            }
        };
        groups.iter().copied().flatten().filter_map(known).collect()
    }

    /// Indices of the states and inputs that `variable` depends on in model exchange, ascending.
    fn following(&self, variable: Variable, groups: Groups) -> Vec<usize> {
        let all = |name: &str| {
            let row = self.first.iter().zip(TABLE).find(|(_, row)| row.name == name);
            row.map_or(0..0, |(first, row)| *first..first + row.shape.len(self.balls))
        };
        // A position is the one of the first ball less overlaps.
        let position = |balls: usize| {
            let overlaps = all("overlap");
            all("x").take(1).chain(overlaps.start..(overlaps.start + balls).min(overlaps.end))
        };
        let mut indices = self.dependencies(variable, &self.knowns(groups));
        for name in groups.iter().copied().flatten() {
            match *name {
                "position" if variable.row.shape == Shape::Balls => indices.extend(position(variable.index)),
                "position" | "all positions" => indices.extend(position(self.balls)),
                _ => indices.extend(name.strip_prefix("all ").map_or(0..0, all)),
            }
        }
        indices.sort_unstable();
        indices.dedup();
        indices
    }

    /// Indices of what `variable` depends on, ascending.
    fn dependencies(&self, variable: Variable, knowns: &[Known]) -> Vec<usize> {
        let of = |(first, shape, beside): &Known| {
            let mut range = neighbours(variable, *shape, self.balls);
            if *beside {
                range = range.start.saturating_sub(1)..(range.end + 1).min(shape.len(self.balls));
            }
            range.start + first..range.end + first
        };
        let mut indices: Vec<usize> = knowns.iter().flat_map(of).collect();
        indices.sort_unstable();
        indices.dedup();
        indices
    }
}

/// Zero-based indices of an array of `shape` that belong to `variable`.
fn neighbours(variable: Variable, shape: Shape, balls: usize) -> std::ops::Range<usize> {
    let (i, len) = (variable.index, shape.len(balls));
    match (variable.row.shape, shape) {
        (Shape::Balls, Shape::Balls) | (Shape::Contacts, Shape::Contacts) => i..i + 1,
        (Shape::Contacts, Shape::Balls) => i..i + 2,
        (Shape::Balls, Shape::Contacts) => i.saturating_sub(1)..(i + 1).min(len),
        (Shape::Scalar, _) | (_, Shape::Scalar) => 0..len,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dependency_names_a_row() {
        for row in TABLE {
            for name in row.initially.into_iter().flatten().copied().flatten() {
                let name = name.trim_end_matches('*');
                let found = Variable::named(name, 5).is_some() || TABLE.iter().any(|other| other.name == name);
                assert!(found, "{} depends on {name}", row.name);
            }
        }
    }

    #[test]
    fn a_contact_depends_on_its_two_balls() {
        let indices = Indices::of(5);
        let contact = Variable::named("inContact[2]", 5).unwrap();
        let names: Vec<String> = indices
            .dependencies(contact, &indices.knowns(&[&["contact.deadBand", "contact.gap", "x_start"]]))
            .iter()
            .map(|index| variables(5).nth(index - 1).unwrap().to_string())
            .collect();
        assert_eq!(names, ["contact.deadBand", "contact.gap[2]", "x_start[2]", "x_start[3]"]);
    }

    #[test]
    fn one_ball_has_no_contact_to_depend_on() {
        let energy = Variable::named("E_total", 1).unwrap();
        let indices = Indices::of(1);
        assert!(indices.dependencies(energy, &indices.knowns(&[&["contact.gap"]])).is_empty());
    }
}
