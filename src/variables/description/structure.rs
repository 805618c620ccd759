//! ModelStructure: the unknowns and their dependencies.

use std::collections::{BTreeSet, HashMap};
use std::fmt::{self, Write};
use std::ops::Range;

use crate::model::{ContactModel, PendulumModel};
use crate::variables::settings::Settings;
use crate::variables::table::TABLE;
use crate::variables::table::row::{Access, Causality, Extra, Groups, Row, Shape, Type};
use crate::variables::variable::Variable;

/// Above this many balls, dependencies of positions on overlaps are omitted: they grow with the square of the number.
const LISTED: usize = 500;

/// Up to this many balls, a value that depends on everything at the start lists everything: some hosts need a list.
const ALL_LISTED: usize = 10;

/// Dependencies of the force and the indicators of rigid contacts.
const EVERYTHING: Groups = &[&["all position", "all v", "all F_ext", "a_support"]];
/// Inputs on which the forecast of the next onset depends.
const INPUTS: Groups = &[&["F_ext", "a_support"]];

/// What the variables and their structure are written from.
pub(super) struct Contents<'a> {
    /// Start values.
    pub start: &'a Settings,
    /// Whether the FMU is one of FMI 3.0.
    pub fmi3: bool,
    /// Whether only real variables are outputs.
    pub real_outputs: bool,
    /// The states with their derivatives.
    pub states: Vec<(Variable, Variable)>,
    /// The variables in their order.
    pub variables: Vec<Variable>,
}

impl Contents<'_> {
    /// What the variables of a row are to the host.
    pub(super) fn causality(&self, row: &Row) -> Causality {
        let is_other = row.causality == Causality::Output && row.access.data_type() != Type::Real;
        if self.real_outputs && is_other { Causality::Local } else { row.causality }
    }
}

/// Whether circular pendulums make a row depend on all states and inputs and, at the start, on all parameters:
/// positions follow from angles and the directions of contacts, the tension of a string from all that acts on its ball.
fn is_of_arcs(row: &Row, start: &Settings) -> bool {
    let from_states = !row.follows.is_empty() || row.name == "F_support_vertical";
    start.parameters.pendulum == PendulumModel::Circular && from_states && !matches!(row.name, "v" | "impulse")
}

/// Writes the unknowns of ModelStructure with their dependencies; for FMI 2.0 those of scalars, by their indices.
///
/// In co-simulation of FMI 2.0 no output depends on an input at the same communication point: an input acts from the
/// next step on. In FMI 3.0 an input acts at once, but changes at once only the forecast and the force of rigid balls
/// that stay in contact, which the host may select. In model exchange outputs and derivatives depend on states and
/// inputs. At initialization they depend on parameters.
pub(super) fn write_structure(out: &mut String, contents: &Contents) -> fmt::Result {
    let Contents { start, fmi3, ref states, ref variables, .. } = *contents;
    let number = numbering(start.balls(), fmi3);
    let mut found: HashMap<&str, Vec<KnownVariables>> = HashMap::new(); // once for all scalars
    let mut write = |out: &mut String, element: &str, variable: Variable, groups: Option<Groups>| {
        match fmi3 {
            true => write!(out, "    <{element} valueReference=\"{}\"", number(variable))?,
            false => write!(out, "      <Unknown index=\"{}\"", number(variable))?,
        }
        let mut numbers = BTreeSet::new();
        for name in groups.into_iter().flatten().copied().flatten() {
            let knowns = found.entry(*name).or_insert_with(|| knowns(name, variable.whole, start.balls(), &number));
            numbers.extend(knowns.iter().flat_map(|known| known.numbers(variable)));
        }
        if groups.is_none() && element == "InitialUnknown" && start.balls() <= ALL_LISTED {
            numbers.extend(variables.iter().filter(|variable| variable.row.settable()).map(|known| number(*known)));
        }
        if groups.is_some() || !numbers.is_empty() {
            out.write_str(" dependencies=\"")?;
            for (i, number) in numbers.into_iter().enumerate() {
                write!(out, "{}{number}", if i == 0 { "" } else { " " })?;
            }
            out.write_str("\"")?;
        }
        out.write_str("/>\n")
    };
    // Only FMI 2.0 has lists of unknowns.
    let list = |out: &mut String, tag: &str| if fmi3 { Ok(()) } else { writeln!(out, "    <{tag}>") };
    list(out, "Outputs")?;
    for variable in variables.iter().filter(|variable| contents.causality(variable.row) == Causality::Output) {
        write(out, "Output", *variable, following(variable, start, fmi3))?;
    }
    list(out, "/Outputs")?;
    list(out, "Derivatives")?;
    let mut exchanged = BTreeSet::new();
    for (state, derivative) in states {
        write(out, "ContinuousStateDerivative", *derivative, following(derivative, start, fmi3))?;
        exchanged.extend([state.reference(), derivative.reference()]);
    }
    list(out, "/Derivatives")?;
    list(out, "InitialUnknowns")?;
    for variable in variables {
        let row = variable.row;
        let is_unknown = matches!(contents.causality(row), Causality::Output | Causality::CalculatedParameter)
            && !matches!(row.access, Access::Instance(..));
        // By the standard clocks have no `initial`; FMPy expects them as calculated outputs.
        if row.access.data_type() == Type::Clock {
            write(out, "InitialUnknown", *variable, Some(&[]))?;
        } else if is_unknown || exchanged.contains(&variable.reference()) {
            write(out, "InitialUnknown", *variable, row.initially.filter(|_| !is_of_arcs(row, start)))?;
        }
    }
    list(out, "/InitialUnknowns")?;
    let is_indicator =
        |row: &Row| matches!(row.access, Access::Instance(_, Extra::ContactIndicator | Extra::ClipIndicator));
    for variable in variables.iter().filter(|variable| fmi3 && is_indicator(variable.row)) {
        write(out, "EventIndicator", *variable, variable.whole.then_some(EVERYTHING))?;
    }
    Ok(())
}

/// States and inputs on which an output or a derivative depends at the same time; `None` if they are not listed, as for
/// an FMI 3.0 scalar that depends on everything.
fn following(variable: &Variable, start: &Settings, fmi3: bool) -> Option<Groups> {
    let (row, of_arcs, many) = (variable.row, is_of_arcs(variable.row, start), start.balls() > LISTED);
    let of_positions = row.follows.iter().copied().flatten().any(|name| *name == "position");
    if many && !variable.whole && row.shape == Shape::Balls && of_positions {
        return None;
    }
    // Whether contact forces are part of it.
    let of_forces = matches!(row.name, "F" | "F_mean" | "a" | "der(E_dissipated)");
    let rigid = start.parameters.contact_model == ContactModel::Rigid;
    if of_arcs || of_forces && (fmi3 || rigid) {
        let listed = if fmi3 { variable.whole } else { !(of_arcs && many) };
        return listed.then_some(EVERYTHING);
    }
    Some(if fmi3 && row.name == "t_next" { INPUTS } else { row.follows })
}

/// What identifies a variable: its value reference or, in FMI 2.0, its index in ModelVariables, counted from 1.
pub(super) fn numbering(balls: usize, fmi3: bool) -> impl Fn(Variable) -> usize {
    let next = |next: &mut usize, row: &Row| Some(std::mem::replace(next, *next + row.shape.len(balls)));
    let first: Vec<usize> = TABLE.iter().scan(1, next).collect();
    move |variable| if fmi3 { variable.reference() as usize } else { first[variable.position] + variable.index }
}

/// An array, or scalars of one row, that others depend on.
struct KnownVariables {
    first: usize,
    len: usize,
    shape: Shape,
    /// Which of them the dependent variable needs.
    reach: Reach,
}

#[derive(Clone, Copy)]
enum Reach {
    All,
    /// Variables of its own ball or contact.
    Own,
    /// Also those of the balls next to this one.
    Beside,
    /// For a position, those before it: it is the first position less the overlaps up to it.
    Before,
}

/// The variables behind a `name` in [`Groups`]: the array or, unless it is `whole`, scalars.
fn knowns(name: &str, whole: bool, balls: usize, number: &impl Fn(Variable) -> usize) -> Vec<KnownVariables> {
    let known =
        |first: Variable, len, reach| KnownVariables { first: number(first), len, shape: first.row.shape, reach };
    if whole {
        let name = name.trim_start_matches("all ").trim_end_matches('*').split('[').next().unwrap_or_default();
        let array = Variable::array(if matches!(name, "position" | "overlap") { "q" } else { name });
        return array.map(|array| known(array, 1, Reach::All)).into_iter().collect();
    }
    if let Some(single) = Variable::named(name, balls) {
        return vec![known(single, 1, Reach::All)];
    }
    let row = |name: &str, reach| {
        Variable::array(name).map(|array| known(array.element(0), array.row.shape.len(balls), reach))
    };
    let of_positions = |reach| {
        let origin = row("x", Reach::All).map(|x| KnownVariables { len: 1, ..x });
        origin.into_iter().chain(row("overlap", reach)).collect()
    };
    match (name, name.strip_prefix("all "), name.strip_suffix('*')) {
        ("position", ..) => of_positions(Reach::Before),
        (_, Some("position"), _) => of_positions(Reach::All),
        (_, Some(name), _) => row(name, Reach::All).into_iter().collect(),
        (_, _, Some(name)) => row(name, Reach::Beside).into_iter().collect(),
        _ => row(name, Reach::Own).into_iter().collect(),
    }
}

impl KnownVariables {
    /// Numbers of the variables here that `variable` depends on.
    fn numbers(&self, variable: Variable) -> Range<usize> {
        let (i, len) = (variable.index, self.len);
        let own = match (variable.row.shape, self.shape, self.reach) {
            (Shape::Scalar, ..) | (_, Shape::Scalar, _) | (_, _, Reach::All) => 0..len,
            (of, _, Reach::Before) => 0..if of == Shape::Balls { i } else { len },
            (Shape::Contacts, Shape::Balls, _) => i..i + 2,
            (Shape::Balls, Shape::Contacts, _) => i.saturating_sub(1)..i + 1,
            (Shape::Balls, Shape::Balls, Reach::Beside) => i.saturating_sub(1)..i + 2,
            _ => i..i + 1,
        };
        self.first + own.start..self.first + own.end.min(len)
    }
}
