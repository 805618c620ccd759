//! Reading and setting by value reference: whole arrays or, in FMI 2.0 and where variables are scalars, one element.

use super::legality::Phase;
use super::lifecycle::{Instance, Start};
use super::run::Run;
use super::values::unknown_reference;
use crate::engine::{NEVER, Pulse};
use crate::variables::{Access, Array, Extra, Refusal, Settings, Shape, Type, Variable, padding};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    Float(f64),
    Count(u64),
    Item(i64),
    /// Of a truth value or a clock.
    Flag(bool),
}

impl Start {
    /// The variable behind a value reference in a cradle of `balls` balls: an array or, where variables are scalars,
    /// one of them.
    #[inline]
    pub fn array_at(&self, reference: u32, balls: usize) -> Option<Array> {
        match (self.purpose.fmi3, self.scalars) {
            (false, _) => Variable::at(reference, balls).map(Variable::scalar),
            (true, true) => Array::scalar_at(reference, balls),
            (true, false) => Array::at(reference),
        }
    }
}

impl Instance {
    /// The variable behind a value reference, if it is one of this type.
    pub fn array(&self, reference: u32, asked: Type) -> Result<Array, Refusal> {
        let balls = self.balls();
        let array = self.start.array_at(reference, balls).ok_or_else(|| unknown_reference(reference, balls))?;
        let of = array.row.access.data_type();
        let fmi3 = self.run.purpose.fmi3;
        if of == asked || !fmi3 && (of, asked) == (Type::Enumeration, Type::Integer) {
            return Ok(array);
        }
        if !fmi3 {
            return Err(array.variable(0).wrong_type(asked));
        }
        let (asked, of) = (asked.fmi3(), of.fmi3());
        Err(refuse_reference(array, format_args!("variables of type {asked}; this one is of type {of}")))
    }

    /// The same, if its value is known; before initialization only start values are.
    pub fn readable(&mut self, reference: u32, asked: Type) -> Result<Array, Refusal> {
        let array = self.array(reference, asked)?;
        let within_step = self.run.phase == Phase::IntermediateUpdate && !array.is_intermediate();
        if within_step && !std::mem::replace(&mut self.run.read_logged, true) {
            let text =
                "is read in the middle of a step, where the standard allows variables with intermediateUpdate only";
            self.log.solver(format_args!("{array} {text}")); // Some hosts read others, again and again.
        }
        if self.run.phase >= Phase::InitializationMode || array.has_start() {
            return Ok(array);
        }
        Err(refuse_reference(array, "before initialization, those with a start value"))
    }

    /// The elements of the variables behind `references`, all of this type, each paired with one of the `values`.
    fn elements<T: Copy>(
        &self,
        references: &[u32],
        asked: Type,
        values: &[T],
    ) -> Result<Vec<(Array, usize, T)>, Refusal> {
        let balls = self.balls();
        let (mut elements, mut wanted) = (Vec::with_capacity(values.len()), 0);
        for reference in references {
            let array = self.array(*reference, asked)?;
            if self.run.phase == Phase::IntermediateUpdate && !array.is_intermediate() {
                return Err(refuse_reference(array, "in the middle of a step, inputs with intermediateUpdate"));
            }
            for index in 0..array.len(balls) {
                elements.extend(values.get(wanted).map(|value| (array, array.index(index), *value)));
                wanted += 1;
            }
        }
        if wanted != values.len() {
            let first = references.first().and_then(|first| self.start.array_at(*first, balls));
            let first = first.map(|array| array.to_string()).unwrap_or_default();
            let more = if references.len() > 1 { " and others" } else { "" };
            let allowed = format_args!("{wanted}, the elements of {first}{more} with n = {balls}");
            return Err(Refusal::argument("nValues", values.len(), allowed));
        }
        Ok(elements)
    }

    /// Recomputes values after setters that act at once; to be called before reading.
    pub fn recompute(&mut self) -> Result<(), Refusal> {
        let at_once = self.run.phase == Phase::EventMode && self.run.purpose.has_event_mode();
        if at_once { self.update_simulation() } else { Ok(()) }
    }

    /// The value of a scalar of this type.
    pub fn value(&mut self, reference: u32, asked: Type) -> Result<Value, Refusal> {
        self.element(self.array(reference, asked)?, 0)
    }

    /// An element of a variable, counted from 0.
    pub fn element(&mut self, array: Array, index: usize) -> Result<Value, Refusal> {
        let (row, index) = (array.row, array.index(index));
        let variable = array.variable(index);
        if let Access::Instance(_, extra) = row.access {
            return self.extra(array, extra, index);
        }
        if index >= row.shape.len(self.balls()) {
            return Ok(match row.access {
                Access::Count(_) => Value::Count(0),
                Access::Flag(_) => Value::Flag(false),
                _ => Value::Float(self.of_no_contact(variable)),
            });
        }
        if self.run.purpose.events
            && self.run.phase > Phase::InitializationMode
            && let Some(value) = self.after_tick(variable)
        {
            return Ok(value);
        }
        match row.access {
            Access::Count(get) => Ok(Value::Count(get(self.results()?, index))),
            Access::Flag(get) => Ok(Value::Flag(get(self.results()?, index))),
            Access::Enumeration(enumeration) => Ok(Value::Item((enumeration.get)(&self.run.settings).into())),
            _ => self.real_of(variable).map(Value::Float),
        }
    }

    /// The value after the last tick of a variable that changes in Event Mode only.
    fn after_tick(&self, variable: Variable) -> Option<Value> {
        let (discrete, work) = (self.run.clocks.discrete.get(variable.index), self.run.clocks.work);
        Some(match variable.row.name {
            "t_onset" => Value::Float(discrete?.onset),
            "t_release" => Value::Float(discrete?.release),
            "pulses" => Value::Count(discrete?.pulses),
            "inContact" => Value::Flag(discrete?.closed),
            "solver.steps" => Value::Count(work.steps),
            "solver.evaluations" => Value::Count(work.evaluations),
            "solver.events" => Value::Count(work.events),
            _ => return None,
        })
    }

    fn extra(&mut self, array: Array, extra: Extra, index: usize) -> Result<Value, Refusal> {
        let clocks = &self.run.clocks;
        let ended = |of: fn(Pulse) -> f64| Value::Float(clocks.ended(index).map_or(0.0, of));
        Ok(match extra {
            Extra::Time | Extra::Pulses => Value::Float(self.time()),
            Extra::Balls => Value::Count(self.balls() as u64),
            Extra::Clock(edge) => Value::Flag(self.run.phase == Phase::EventMode && clocks.active[edge as usize]),
            Extra::TickTime(edge) => Value::Float(clocks.time(edge)),
            Extra::TickOf(edge) => Value::Flag(clocks.is_part(edge, index)),
            Extra::EndedImpulse => ended(|pulse| pulse.impulse),
            Extra::EndedPeak => ended(|pulse| pulse.peak),
            Extra::EndedDuration => ended(|pulse| pulse.release - pulse.onset),
            Extra::Joined(..) => {
                let variable = array.element(index, self.balls());
                Value::Float(variable.map_or(Ok(0.0), |variable| self.real_of(variable))?)
            }
            Extra::ContactIndicator | Extra::ClipIndicator => Value::Float(self.indicator(extra, index)?),
        })
    }

    /// The text of `log.pulses`, the only binary variable. It stays valid until the next call.
    pub fn binary(&mut self, references: &[u32]) -> Result<&str, Refusal> {
        for reference in references {
            self.readable(*reference, Type::Binary)?;
        }
        self.run.csv = self.run.clocks.log.csv();
        Ok(&self.run.csv)
    }

    /// The value of an element that belongs to no contact; for a parameter, the value last set.
    fn of_no_contact(&self, variable: Variable) -> f64 {
        match (self.run.padding.get(&variable.position), variable.row.name) {
            (Some(value), _) => *value,
            (None, "overlap" | "t_onset" | "t_release") => -NEVER,
            _ => padding(variable.row),
        }
    }

    /// Sets the real variables behind `references` to `values`, element after element: all, or none if any is refused.
    pub fn set_floats(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        let balls = self.balls();
        let (mut set, mut unused) = (Vec::with_capacity(values.len()), Vec::new());
        let by_states = self.run.phase == Phase::ContinuousTimeMode && self.run.purpose.fmi3;
        let (mut states, mut place): (Option<Vec<f64>>, _) = (None, None);
        for (array, index, value) in self.elements(references, Type::Real, values)? {
            let variable = array.variable(index);
            let first = array.index(0);
            if by_states && index == first {
                place = array.state_place(balls);
            }
            if let Some(place) = place {
                variable.check_real(value)?;
                let states = match &mut states {
                    Some(states) => states,
                    none => none.insert(self.continuous_states()?),
                };
                states[place + index - first] = value;
                continue;
            }
            self.check_settable(variable)?;
            variable.check_real(value)?;
            match index < array.row.shape.len(balls) {
                true => set.push((variable, value)),
                false => unused.push((variable.position, value)),
            }
        }
        if self.run.phase == Phase::IntermediateUpdate {
            self.keep_inputs_in_step()?;
        }
        if let Some(states) = states {
            self.set_continuous_states(&states)?;
        }
        self.set(set, Variable::set_real);
        self.run.padding.extend(unused);
        Ok(())
    }

    /// Selects items of the enumerations behind `references`: all of them, or none if any is refused.
    pub fn set_items(&mut self, references: &[u32], values: &[i64]) -> Result<(), Refusal> {
        let asked = if self.run.purpose.fmi3 { Type::Enumeration } else { Type::Integer };
        let mut set = Vec::new();
        for (array, index, value) in self.elements(references, asked, values)? {
            let variable = array.variable(index);
            self.check_settable(variable)?;
            variable.check_item(value)?;
            set.push((variable, value as i32));
        }
        self.set(set, Variable::set_item);
        Ok(())
    }

    /// Sets the number of balls, in Configuration Mode. This resets arrays to their defaults and keeps scalars.
    pub fn set_counts(&mut self, references: &[u32], values: &[u64]) -> Result<(), Refusal> {
        let mut wanted = self.balls();
        for (array, _, value) in self.elements(references, Type::Integer, values)? {
            if !array.has_start() {
                return Err(array.row.not_settable(array));
            }
            if self.run.phase != Phase::ConfigurationMode {
                return Err(Refusal::new(format_args!("{array} can only be set in Configuration Mode")));
            }
            if !array.row.range.contains(value as f64) {
                return Err(Refusal::value(array, value, array.row.range));
            }
            wanted = value as usize;
        }
        if wanted != self.balls() {
            self.resize(wanted);
        }
        Ok(())
    }

    fn resize(&mut self, balls: usize) {
        let before = &self.run.settings;
        let mut settings = Settings::default_for(balls);
        for array in Array::all().filter(|array| array.row.shape == Shape::Scalar) {
            let variable = array.variable(0);
            match (variable.real(before), variable.item(before)) {
                (Some(value), _) => _ = variable.set_real(&mut settings, value),
                (_, Some(item)) => _ = variable.set_item(&mut settings, item),
                _ => {}
            }
        }
        self.run = Run { phase: self.run.phase, ..Run::new(self.run.purpose, &settings) };
    }

    /// The refusal to set variables of a type that has no settable ones.
    pub fn refuse_to_set(&self, references: &[u32], asked: Type) -> Result<(), Refusal> {
        references.iter().try_for_each(|reference| {
            let array = self.array(*reference, asked)?;
            Err(array.row.not_settable(array))
        })
    }
}

fn refuse_reference(array: Array, allowed: impl std::fmt::Display) -> Refusal {
    Refusal::argument("valueReference", array, allowed)
}
