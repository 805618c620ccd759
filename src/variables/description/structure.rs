//! ModelStructure: which unknowns there are and on what they depend.

use std::fmt::{self, Write};

use crate::variables::row::{Causality, Groups, Row, Shape};
use crate::variables::table::TABLE;
use crate::variables::variable::{Variable, variables};

/// Writes Outputs and InitialUnknowns for `balls` balls.
///
/// No output depends on an input at the same communication point: an input acts from the next step on. At
/// initialization outputs depend on parameters.
pub(super) fn write_structure(out: &mut String, balls: usize) -> fmt::Result {
    let indices = Indices::of(balls);
    out.write_str("    <Outputs>\n")?;
    for variable in variables(balls).filter(|variable| variable.row.causality == Causality::Output) {
        writeln!(out, "      <Unknown index=\"{}\" dependencies=\"\"/>", indices.of_variable(variable))?;
    }
    out.write_str("    </Outputs>\n    <InitialUnknowns>\n")?;
    for (position, row) in TABLE.iter().enumerate() {
        if matches!(row.causality, Causality::Output | Causality::CalculatedParameter) {
            write_initial(out, &indices, position, row)?;
        }
    }
    out.write_str("    </InitialUnknowns>\n")
}

/// Writes the initial unknowns of one row.
fn write_initial(out: &mut String, indices: &Indices, position: usize, row: &'static Row) -> fmt::Result {
    let knowns = row.initially.map(|groups| indices.knowns(groups));
    for index in 0..row.shape.len(indices.balls) {
        let variable = Variable { row, position, index };
        write!(out, "      <Unknown index=\"{}\"", indices.of_variable(variable))?;
        if let Some(knowns) = &knowns {
            out.write_str(" dependencies=\"")?;
            for (i, dependency) in indices.dependencies(variable, knowns).into_iter().enumerate() {
                write!(out, "{}{dependency}", if i == 0 { "" } else { " " })?;
            }
            out.write_str("\"")?;
        }
        out.write_str("/>\n")?;
    }
    Ok(())
}

/// Positions in ModelVariables, counted from 1.
struct Indices {
    balls: usize,
    /// Index of the first variable of each row.
    first: Vec<usize>,
}

/// What a value depends on, a row or one variable of a row: the index of its first variable, and its shape.
type Known = (usize, Shape);

impl Indices {
    fn of(balls: usize) -> Self {
        let mut next = 1;
        let mut first = Vec::with_capacity(TABLE.len());
        for row in TABLE {
            first.push(next);
            next += row.shape.len(balls);
        }
        Self { balls, first }
    }

    fn of_variable(&self, variable: Variable) -> usize {
        self.first.get(variable.position).map_or(0, |first| first + variable.index)
    }

    /// The rows and variables behind names, looked up once for all variables of a row.
    fn knowns(&self, groups: Groups) -> Vec<Known> {
        let known = |name: &&str| match Variable::named(name, self.balls) {
            Some(single) => Some((self.of_variable(single), Shape::Scalar)),
            None => {
                let (first, row) = self.first.iter().zip(TABLE).find(|(_, row)| row.name == *name)?;
                Some((*first, row.shape))
            }
        };
        groups.iter().copied().flatten().filter_map(known).collect()
    }

    /// Indices of what `variable` depends on, ascending.
    fn dependencies(&self, variable: Variable, knowns: &[Known]) -> Vec<usize> {
        let of = |(first, shape): &Known| {
            let range = neighbours(variable, *shape, self.balls);
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
                let found = Variable::named(name, 5).is_some() || TABLE.iter().any(|other| other.name == *name);
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
