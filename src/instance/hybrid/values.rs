//! Variables as arrays: read and set by the value references of FMI 3.0, all elements of them.

use crate::engine::NEVER;
use crate::instance::legality::Phase;
use crate::instance::lifecycle::Instance;
use crate::instance::refusal::Refusal;
use crate::model::Inputs;
use crate::variables::{
    Access, Array, ArrayType, Causality, DERIVATIVES_OF, Extra, MAX_BALLS, MIN_BALLS, Settings, Shape, TABLE, Type,
    Variable, VariableError, padding, variables,
};

use super::Hybrid;
use super::ticks::Edge;

/// The value of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Of a real variable.
    Float(f64),
    /// Of a count.
    Count(u64),
    /// Of an enumeration.
    Item(i64),
    /// Of a truth value or a clock.
    Flag(bool),
}

impl Instance {
    /// The variable behind a value reference, if it is one of this type.
    pub fn array(&self, reference: u32, asked: ArrayType) -> Result<Array, Refusal> {
        let balls = self.balls();
        let array = Array::at(reference).ok_or(VariableError::UnknownReference { reference, balls })?;
        if array.data_type() == asked {
            return Ok(array);
        }
        let allowed = format!("variables of type {asked:?}; this one is of type {:?}", array.data_type());
        Err(Refusal::Argument { name: "valueReference", value: array.to_string(), allowed })
    }

    /// The same, if its value is known: before initialization only what has a start value is.
    pub fn readable(&mut self, reference: u32, asked: ArrayType) -> Result<Array, Refusal> {
        let array = self.array(reference, asked)?;
        if self.run.phase == Phase::IntermediateUpdate && !array.is_intermediate() {
            self.log_read_within_step(array);
        }
        if self.run.phase >= Phase::InitializationMode || array.has_start() {
            return Ok(array);
        }
        let allowed = "before initialization, those with a start value".to_owned();
        Err(Refusal::Argument { name: "valueReference", value: array.to_string(), allowed })
    }

    /// Says once that a host reads more within a step than the standard allows: some read every variable.
    #[cold]
    fn log_read_within_step(&mut self, array: Array) {
        let Some(hybrid) = &mut self.run.hybrid else { return };
        if !std::mem::replace(&mut hybrid.read_logged, true) {
            self.log.solver(format_args!(
                "{array} is read in the middle of a step, where the standard allows variables with intermediateUpdate only"
            ));
        }
    }

    /// The variables behind `references`, all of this type, that so many values are given for.
    fn arrays(&self, references: &[u32], asked: ArrayType, given: usize) -> Result<Vec<Array>, Refusal> {
        let mut arrays = Vec::with_capacity(references.len());
        for reference in references {
            let array = self.array(*reference, asked)?;
            if self.run.phase == Phase::IntermediateUpdate && !array.is_intermediate() {
                let allowed = "in the middle of a step, inputs with intermediateUpdate".to_owned();
                return Err(Refusal::Argument { name: "valueReference", value: array.to_string(), allowed });
            }
            arrays.push(array);
        }
        let balls = self.balls();
        let wanted: usize = arrays.iter().map(|array| array.len(balls)).sum();
        if wanted == given {
            return Ok(arrays);
        }
        let first = arrays.first().map(Array::to_string).unwrap_or_default();
        let more = if arrays.len() > 1 { " and others" } else { "" };
        let allowed = format!("{wanted}, the elements of {first}{more} with n = {balls}");
        Err(Refusal::Argument { name: "nValues", value: given.to_string(), allowed })
    }

    /// To be called before values are read: makes them those of what has been set, where setters act at once.
    pub fn recompute(&mut self) -> Result<(), Refusal> {
        let at_once = self.run.phase == Phase::EventMode && self.run.takes_part_in_events();
        if at_once { self.update_simulation() } else { Ok(()) }
    }

    /// An element of a variable, counted from 0.
    pub fn element(&mut self, array: Array, index: usize) -> Result<Value, Refusal> {
        let position = match array {
            Array::Row(position) => position,
            Array::Slope(position) => return self.slope(position, index).map(Value::Float),
            Array::Extra(extra) => return self.extra(extra, index),
        };
        let row = &TABLE[position];
        let variable = Variable { row, position, index };
        let is_told = self.run.tells_of_events() && self.run.phase > Phase::InitializationMode;
        let ticks = &self.hybrid()?.ticks;
        if index >= row.shape.len(self.balls()) {
            return Ok(match row.access {
                Access::Count(_) => Value::Count(0),
                Access::Flag(_) => Value::Flag(false),
                _ => Value::Float(self.of_no_contact(position)),
            });
        }
        // What changes in Event Mode only.
        let told = ticks.shown(index).filter(|_| is_told).and_then(|shown| match row.name {
            "t_onset" => Some(Value::Float(shown.onset)),
            "t_release" => Some(Value::Float(shown.release)),
            "pulses" => Some(Value::Count(shown.pulses)),
            "inContact" => Some(Value::Flag(shown.closed)),
            _ => None,
        });
        if let Some(told) = told {
            return Ok(told);
        }
        match row.access {
            Access::Count(_) if is_told => Ok(Value::Count(match row.name {
                "solver.steps" => ticks.work.steps,
                "solver.evaluations" => ticks.work.evaluations,
                _ => ticks.work.events,
            })),
            Access::Count(get) => Ok(Value::Count(get(self.results()?, index))),
            Access::Flag(get) => Ok(Value::Flag(get(self.results()?, index))),
            Access::Enumeration(_) => Ok(Value::Item(variable.item(&self.run.settings).map_or(0, i64::from))),
            _ => self.real(variable.reference()).map(Value::Float),
        }
    }

    fn slope(&self, input: usize, index: usize) -> Result<f64, Refusal> {
        Ok(match TABLE[input].access {
            Access::Input { get, .. } => get(&self.hybrid()?.slopes).get(index).copied().unwrap_or_default(),
            _ => 0.0,
        })
    }

    fn extra(&mut self, extra: Extra, index: usize) -> Result<Value, Refusal> {
        let (time, balls, events) = (self.time(), self.balls(), self.run.phase == Phase::EventMode);
        let hybrid = self.hybrid()?;
        let ticks = &hybrid.ticks;
        Ok(match extra {
            Extra::Time | Extra::Pulses => Value::Float(time),
            Extra::Balls => Value::Count(balls as u64),
            Extra::DerivativesOf => Value::Item(hybrid.derivatives_of.into()),
            Extra::OnsetClock => Value::Flag(events && ticks.is_active(Edge::Onset)),
            Extra::ReleaseClock => Value::Flag(events && ticks.is_active(Edge::Release)),
            Extra::OnsetTime => Value::Float(ticks.time(Edge::Onset)),
            Extra::ReleaseTime => Value::Float(ticks.time(Edge::Release)),
            Extra::OnsetClosed => Value::Flag(ticks.is_part(Edge::Onset, index)),
            Extra::ReleaseOpened => Value::Flag(ticks.is_part(Edge::Release, index)),
            Extra::ReleaseImpulse => Value::Float(ticks.ended(index).impulse),
            Extra::ReleasePeak => Value::Float(ticks.ended(index).peak),
            Extra::ReleaseDuration => Value::Float(ticks.ended(index).duration),
            Extra::Positions | Extra::Rates | Extra::ContactIndicators | Extra::ClipIndicators => {
                Value::Float(self.exchanged(extra, index)?)
            }
        })
    }

    /// The text of the variables behind `references`, of which there is but `log.pulses`. It stays until the next call.
    pub fn binary(&mut self, references: &[u32]) -> Result<&str, Refusal> {
        for reference in references {
            self.readable(*reference, ArrayType::Binary)?;
        }
        let hybrid = self.hybrid_mut()?;
        hybrid.csv = hybrid.ticks.log.csv();
        Ok(&hybrid.csv)
    }

    /// The value of an element that belongs to no contact: of a parameter what it was set to.
    fn of_no_contact(&self, position: usize) -> f64 {
        let row = &TABLE[position];
        let set = self.run.hybrid.iter().flat_map(|hybrid| &hybrid.padding).find(|(set, _)| *set == position);
        match (set, row.name) {
            (Some((_, value)), _) => *value,
            (None, "overlap" | "t_onset" | "t_release") => -NEVER,
            _ => padding(row),
        }
    }

    /// Sets the real variables behind `references` to `values`, element after element: all of them, or none if any of
    /// it is refused.
    pub fn set_floats(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        let balls = self.balls();
        let arrays = self.arrays(references, ArrayType::Float64, values.len())?;
        let (mut elements, mut set, mut spares, mut slopes) = (Vec::new(), Vec::new(), Vec::new(), None);
        let mut states: Option<Vec<f64>> = None;
        let mut rest = values;
        for array in arrays {
            let (own, behind) = rest.split_at(array.len(balls));
            rest = behind;
            if let Some(first) = self.place_of_state(array) {
                if let Some(variable) = array.element(0, balls) {
                    own.iter().try_for_each(|value| variable.check_real(*value))?;
                }
                let all = self.array_states(self.count_states())?;
                states.get_or_insert(all)[first..first + own.len()].copy_from_slice(own);
                continue;
            }
            match array {
                Array::Row(position) => {
                    let row = &TABLE[position];
                    for (index, value) in own.iter().enumerate() {
                        let variable = Variable { row, position, index };
                        if index < row.shape.len(balls) {
                            elements.push(variable.reference());
                            set.push(*value);
                        } else {
                            variable.check_settable(Type::Real, self.run.phase > Phase::InitializationMode)?;
                            variable.check_real(*value)?;
                            spares.push((position, *value));
                        }
                    }
                }
                Array::Slope(position) => {
                    let new: &mut Inputs = slopes.get_or_insert(self.hybrid()?.slopes.clone());
                    for (index, value) in own.iter().enumerate() {
                        let variable = Variable { row: &TABLE[position], position, index };
                        variable.check_input_derivative(1, *value)?;
                        variable.set_input(new, *value);
                    }
                }
                other => {
                    return Err(not_settable(other));
                }
            }
        }
        if self.run.phase == Phase::IntermediateUpdate || states.is_some() {
            // A refused call changes nothing.
            for (reference, value) in elements.iter().zip(&set) {
                self.settable(*reference, Type::Real)?.check_real(*value)?;
            }
            self.keep_inputs_in_step()?;
        }
        if let Some(states) = states {
            self.set_array_states(&states)?;
        }
        self.set_reals(&elements, &set)?;
        let hybrid = self.hybrid_mut()?;
        for (position, value) in spares {
            hybrid.padding.retain(|(other, _)| *other != position);
            hybrid.padding.push((position, value));
        }
        if let Some(slopes) = slopes {
            hybrid.slopes = slopes;
        }
        Ok(())
    }

    /// Selects items of the enumerations behind `references`: all of them, or none if any is refused.
    pub fn set_items(&mut self, references: &[u32], values: &[i64]) -> Result<(), Refusal> {
        let arrays = self.arrays(references, ArrayType::Enumeration, values.len())?;
        let (mut elements, mut items, mut derivatives_of) = (Vec::new(), Vec::new(), None);
        for (array, value) in arrays.into_iter().zip(values) {
            if let Array::Row(position) = array {
                elements.push(Variable { row: &TABLE[position], position, index: 0 }.reference());
                items.push(*value);
            } else if let Some(item) = DERIVATIVES_OF.iter().find(|item| i64::from(item.value) == *value) {
                derivatives_of = Some(item.value);
            } else {
                let known: Vec<String> =
                    DERIVATIVES_OF.iter().map(|item| format!("{} ({})", item.name, item.value)).collect();
                return Err(VariableError::not_allowed(array, value, known.join(" or ")).into());
            }
        }
        self.set_integers(&elements, &items)?;
        if let Some(item) = derivatives_of {
            self.hybrid_mut()?.derivatives_of = item;
        }
        Ok(())
    }

    /// Sets the number of balls, in Configuration Mode: all arrays have their defaults then, scalars what they had.
    pub fn set_counts(&mut self, references: &[u32], values: &[u64]) -> Result<(), Refusal> {
        let arrays = self.arrays(references, ArrayType::UInt64, values.len())?;
        let mut wanted = self.balls();
        for (array, value) in arrays.into_iter().zip(values) {
            if array != Array::Extra(Extra::Balls) {
                return Err(not_settable(array));
            }
            if self.run.phase != Phase::ConfigurationMode {
                return Err(VariableError::Structural { variable: array.to_string() }.into());
            }
            let balls = usize::try_from(*value).unwrap_or(usize::MAX);
            if !(MIN_BALLS..=MAX_BALLS).contains(&balls) {
                let allowed = format_args!("{MIN_BALLS} to {MAX_BALLS}");
                return Err(VariableError::not_allowed(array, value, allowed).into());
            }
            wanted = balls;
        }
        if wanted != self.balls() {
            self.resize(wanted);
        }
        Ok(())
    }

    fn resize(&mut self, balls: usize) {
        let before = &self.run.settings;
        let mut settings = Settings::default_for(balls);
        for variable in variables(balls).filter(|variable| variable.row.shape == Shape::Scalar) {
            match (variable.real(before), variable.item(before)) {
                (Some(value), _) => _ = variable.set_real(&mut settings, value),
                (_, Some(item)) => _ = variable.set_item(&mut settings, item),
                _ => {}
            }
        }
        self.run.settings = settings;
        // What has been calculated is of a cradle of another size.
        (self.run.simulation, self.run.exchange) = (None, None);
        self.run.hybrid = self
            .run
            .hybrid
            .as_ref()
            .map(|hybrid| Hybrid { derivatives_of: hybrid.derivatives_of, ..hybrid.anew(balls) });
    }

    /// Says why variables of this type cannot be set: there are none that can.
    pub fn refuse_to_set_arrays(&self, references: &[u32], asked: ArrayType) -> Result<(), Refusal> {
        references.iter().try_for_each(|reference| {
            let array = self.array(*reference, asked)?;
            Err(not_settable(array))
        })
    }

    pub(super) fn hybrid(&self) -> Result<&Hybrid, Refusal> {
        self.run.hybrid.as_ref().ok_or(Refusal::Unsupported("the instance has no arrays"))
    }

    pub(super) fn hybrid_mut(&mut self) -> Result<&mut Hybrid, Refusal> {
        self.run.hybrid.as_mut().ok_or(Refusal::Unsupported("the instance has no arrays"))
    }
}

/// Says that a variable is none that a host sets.
#[cold]
fn not_settable(array: Array) -> Refusal {
    let causality = array.causality().unwrap_or(Causality::Local);
    VariableError::NotSettable { variable: array.to_string(), causality }.into()
}
