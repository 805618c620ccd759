//! ModelStructure: the unknowns and their dependencies.

use std::collections::{BTreeSet, HashMap};
use std::fmt::{self, Write};
use std::ops::Range;

use crate::model::{ContactModel, PendulumModel};
use crate::variables::arrays::Array;
use crate::variables::settings::Settings;
use crate::variables::table::TABLE;
use crate::variables::table::row::{Access, Causality, Extra, Groups, Row, Shape, Type};
use crate::variables::variable::Variable;

/// Above this many balls, dependencies of positions on overlaps are omitted: they grow with the square of the number.
const LISTED: usize = 500;

/// Dependencies of the force and the indicators of rigid contacts.
const EVERYTHING: Groups = &[&["all position", "all v", "all F_ext", "a_support"]];
/// Inputs on which the forecast of the next onset depends.
const INPUTS: Groups = &[&["F_ext", "a_support"]];

/// Whether circular pendulums make it depend on all states and inputs and, at the start, on all parameters: positions
/// follow from angles and the directions of contacts, the tension of a string from all that acts on its ball.
fn is_of_arcs(row: &Row, start: &Settings) -> bool {
    let from_states = !row.follows.is_empty() || row.name == "F_support_vertical";
    start.parameters.pendulum == PendulumModel::Circular && from_states && !matches!(row.name, "v" | "impulse")
}

/// Writes the unknowns of ModelStructure with their dependencies: for FMI 2.0 those of scalars, by their indices.
///
/// In co-simulation no output depends on an input at the same communication point: an input acts from the next step on.
/// In FMI 3.0 it acts from now on: at once it changes only the forecast and the force of rigid balls that stay in
/// contact, which the host may select. In model exchange outputs and derivatives depend on states and inputs. At
/// initialization they depend on parameters.
pub(super) fn write_structure(
    out: &mut String,
    start: &Settings,
    fmi3: bool,
    states: &[(Array, Array)],
    arrays: &[Array],
) -> fmt::Result {
    let balls = start.balls();
    let reference = |(position, row)| Variable { row, position, index: 0 }.reference() as usize;
    let first = if fmi3 { TABLE.iter().enumerate().map(reference).collect() } else { first_indices(balls) };
    let mut found: HashMap<&str, Vec<Known>> = HashMap::new(); // once for all scalars
    let mut write = |out: &mut String, element: &str, array: Array, groups: Option<Groups>| {
        let variable = array.variable(0);
        match fmi3 {
            true => write!(out, "    <{element} valueReference=\"{}\"", array.reference())?,
            false => write!(out, "      <Unknown index=\"{}\"", first[variable.position] + variable.index)?,
        }
        let places = |name: &&'static str| match array.is_single() {
            true => {
                let found = found.entry(*name).or_insert_with(|| knowns(name, balls, &first));
                found.iter().flat_map(|known| known.indices(variable)).collect()
            }
            false => Vec::from_iter(array_of(name).map(|array| array.reference() as usize)),
        };
        if let Some(groups) = groups {
            out.write_str(" dependencies=\"")?;
            let each_once: BTreeSet<usize> = groups.iter().copied().flatten().flat_map(places).collect();
            for (i, dependency) in each_once.into_iter().enumerate() {
                write!(out, "{}{dependency}", if i == 0 { "" } else { " " })?;
            }
            out.write_str("\"")?;
        }
        out.write_str("/>\n")
    };
    // Only FMI 2.0 has lists of unknowns.
    let list = |out: &mut String, tag: &str| if fmi3 { Ok(()) } else { writeln!(out, "    <{tag}>") };
    list(out, "Outputs")?;
    for array in arrays.iter().filter(|array| array.row.causality == Causality::Output) {
        write(out, "Output", *array, following(*array, start, fmi3))?;
    }
    list(out, "/Outputs")?;
    list(out, "Derivatives")?;
    let mut exchanged = BTreeSet::new();
    for (state, derivative) in states {
        write(out, "ContinuousStateDerivative", *derivative, following(*derivative, start, fmi3))?;
        exchanged.extend([state.reference(), derivative.reference()]);
    }
    list(out, "/Derivatives")?;
    list(out, "InitialUnknowns")?;
    for &array in arrays {
        let is_unknown = matches!(array.row.causality, Causality::Output | Causality::CalculatedParameter)
            && !matches!(array.row.access, Access::Instance(..));
        // By the standard clocks have no `initial`; FMPy expects them as calculated outputs.
        if array.row.access.data_type() == Type::Clock {
            write(out, "InitialUnknown", array, Some(&[]))?;
        } else if is_unknown || exchanged.contains(&array.reference()) {
            write(out, "InitialUnknown", array, array.row.initially.filter(|_| !is_of_arcs(array.row, start)))?;
        }
    }
    list(out, "/InitialUnknowns")?;
    let is_indicator =
        |row: &Row| matches!(row.access, Access::Instance(_, Extra::ContactIndicator | Extra::ClipIndicator));
    for array in arrays.iter().filter(|array| fmi3 && is_indicator(array.row)) {
        write(out, "EventIndicator", *array, (!array.is_single()).then_some(EVERYTHING))?;
    }
    Ok(())
}

/// States and inputs on which an output or a derivative depends at the same time; none if they are not listed, as those
/// of an FMI 3.0 scalar that depends on everything.
fn following(array: Array, start: &Settings, fmi3: bool) -> Option<Groups> {
    let (row, of_arcs, many) = (array.row, is_of_arcs(array.row, start), start.balls() > LISTED);
    let of_positions = row.follows.iter().copied().flatten().any(|name| *name == "position");
    if many && array.is_single() && row.shape == Shape::Balls && of_positions {
        return None;
    }
    // Whether a contact force is part of it.
    let of_forces = matches!(row.name, "F" | "F_mean" | "a" | "der(E_dissipated)");
    let rigid = start.parameters.contact_model == ContactModel::Rigid;
    if of_arcs || of_forces && (fmi3 || rigid) {
        let listed = if fmi3 { !array.is_single() } else { !(of_arcs && many) };
        return listed.then_some(EVERYTHING);
    }
    Some(if fmi3 && row.name == "t_next" { INPUTS } else { row.follows })
}

/// The array behind a name in [`Groups`].
fn array_of(name: &str) -> Option<Array> {
    let name = name.trim_start_matches("all ").trim_end_matches('*').split('[').next().unwrap_or_default();
    Array::named(if matches!(name, "position" | "overlap") { "q" } else { name })
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

/// Variables of one row of the table that others depend on.
struct Known {
    first: usize,
    len: usize,
    /// Which of them the dependent variable needs.
    reach: Reach,
}

#[derive(Clone, Copy)]
enum Reach {
    All,
    /// Those of a row of this shape at the same ball or contact; also those next to it, if this is set.
    Own(Shape, bool),
    /// Those before it: a position is that of the first ball minus the overlaps between.
    Before,
}

/// The variables of a `name` in [`Groups`].
fn knowns(name: &str, balls: usize, first: &[usize]) -> Vec<Known> {
    if let Some(single) = Variable::named(name, balls) {
        return vec![Known { first: first[single.position] + single.index, len: 1, reach: Reach::All }];
    }
    let row = |name: &str, reach: fn(Shape) -> Reach| {
        let found = first.iter().zip(TABLE).find(|(_, row)| row.name == name);
        found.map(|(first, row)| Known { first: *first, len: row.shape.len(balls), reach: reach(row.shape) })
    };
    let of_positions = |reach: fn(Shape) -> Reach| {
        let origin = row("x", |_| Reach::All).map(|x| Known { len: 1, ..x });
        origin.into_iter().chain(row("overlap", reach)).collect()
    };
    match (name, name.strip_prefix("all "), name.strip_suffix('*')) {
        ("position", ..) => of_positions(|_| Reach::Before),
        (_, Some("position"), _) => of_positions(|_| Reach::All),
        (_, Some(name), _) => row(name, |_| Reach::All).into_iter().collect(),
        (_, _, Some(name)) => row(name, |shape| Reach::Own(shape, true)).into_iter().collect(),
        _ => row(name, |shape| Reach::Own(shape, false)).into_iter().collect(),
    }
}

impl Known {
    /// Indices of those that `variable` depends on.
    fn indices(&self, variable: Variable) -> Range<usize> {
        let (i, len, of) = (variable.index, self.len, variable.row.shape);
        let own = match (of, self.reach) {
            (Shape::Scalar, _) | (_, Reach::All | Reach::Own(Shape::Scalar, _)) => 0..len,
            (_, Reach::Before) => 0..if of == Shape::Balls { i } else { len },
            (Shape::Contacts, Reach::Own(Shape::Balls, _)) => i..i + 2,
            (Shape::Balls, Reach::Own(Shape::Contacts, _)) => i.saturating_sub(1)..i + 1,
            (_, Reach::Own(..)) => i..i + 1,
        };
        let beside = usize::from(matches!(self.reach, Reach::Own(_, true)));
        self.first + own.start.saturating_sub(beside)..self.first + (own.end + beside).min(len)
    }
}
