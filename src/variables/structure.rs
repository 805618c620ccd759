//! ModelStructure: which unknowns there are and on what they depend.

use std::fmt::{self, Write};

use super::row::{Causality, Initially, Shape};
use super::{TABLE, Variable, variables};

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
    for variable in variables(balls) {
        if !matches!(variable.row.causality, Causality::Output | Causality::CalculatedParameter) {
            continue;
        }
        write!(out, "      <Unknown index=\"{}\"", indices.of_variable(variable))?;
        if let Initially::On(groups) = variable.row.initially {
            let dependencies = indices.dependencies(variable, groups);
            let list: Vec<String> = dependencies.iter().map(usize::to_string).collect();
            write!(out, " dependencies=\"{}\"", list.join(" "))?;
        }
        out.write_str("/>\n")?;
    }
    out.write_str("    </InitialUnknowns>\n")
}

/// Positions in ModelVariables, counted from 1.
struct Indices {
    balls: usize,
    /// Index of the first variable of each row.
    first: Vec<usize>,
}

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

    /// Indices of what `variable` depends on, ascending.
    fn dependencies(&self, variable: Variable, groups: &[&[&str]]) -> Vec<usize> {
        let mut indices = Vec::new();
        for name in groups.iter().copied().flatten() {
            if let Some(single) = Variable::named(name, self.balls) {
                indices.push(self.of_variable(single));
            } else if let Some((position, row)) = TABLE.iter().enumerate().find(|(_, row)| row.name == *name) {
                let first = self.first.get(position).copied().unwrap_or_default();
                indices.extend(neighbours(variable, row.shape, self.balls).map(|index| first + index));
            }
        }
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
            let Initially::On(groups) = row.initially else { continue };
            for name in groups.iter().copied().flatten() {
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
            .dependencies(contact, &[&["contact.deadBand", "contact.gap", "x_start"]])
            .iter()
            .map(|index| variables(5).nth(index - 1).unwrap().to_string())
            .collect();
        assert_eq!(names, ["contact.deadBand", "contact.gap[2]", "x_start[2]", "x_start[3]"]);
    }

    #[test]
    fn one_ball_has_no_contact_to_depend_on() {
        let energy = Variable::named("E_total", 1).unwrap();
        assert!(Indices::of(1).dependencies(energy, &[&["contact.gap"]]).is_empty());
    }
}
