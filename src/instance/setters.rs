//! Setting by value reference, as hosts of either version do.

use super::legality::{Kind, Phase};
use super::lifecycle::Instance;
use super::run::Run;
use super::values::refuse_reference;
use crate::model::{Inputs, Tunables};
use crate::variables::{Causality, Refusal, Settings, Shape, TABLE, Type, Variability, Variable};

impl Instance {
    /// The elements of the variables behind `references`, all of this type, each paired with one of the `values`.
    fn elements<T: Copy>(&self, references: &[u32], asked: Type, values: &[T]) -> Result<Vec<(Variable, T)>, Refusal> {
        let balls = self.balls();
        let (mut elements, mut wanted) = (Vec::with_capacity(values.len()), 0);
        for reference in references {
            let variable = self.variable(*reference, asked)?;
            if self.run.phase == Phase::IntermediateUpdate && !variable.is_intermediate() {
                return Err(refuse_reference(variable, "in the middle of a step, inputs with intermediateUpdate"));
            }
            for index in 0..variable.len(balls) {
                elements.extend(values.get(wanted).map(|value| (variable.element(index), *value)));
                wanted += 1;
            }
        }
        if wanted != values.len() {
            let first = references.first().and_then(|first| self.start.variable(*first, balls));
            let first = first.map(|variable| variable.to_string()).unwrap_or_default();
            let more = if references.len() > 1 { " and others" } else { "" };
            let allowed = format_args!("{wanted}, the elements of {first}{more} with n = {balls}");
            return Err(Refusal::argument("nValues", values.len(), allowed));
        }
        Ok(elements)
    }

    /// Sets the real variables behind `references` to `values`, element after element: all, or none if any is refused.
    pub fn set_floats(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        let (balls, scalars) = (self.balls(), self.start.scalars);
        let (mut set, mut unused, mut states) = (Vec::with_capacity(values.len()), Vec::new(), Vec::new());
        let by_states = self.run.phase == Phase::ContinuousTimeMode && self.run.purpose.fmi3;
        for (variable, value) in self.elements(references, Type::Real, values)? {
            if by_states && let Some(place) = variable.state_place(balls, scalars) {
                variable.check_real(value)?;
                if states.is_empty() {
                    states = self.continuous_states()?;
                }
                states[place] = value;
                continue;
            }
            self.check_settable(variable)?;
            variable.check_real(value)?;
            match variable.index < variable.row.shape.len(balls) {
                true => set.push((variable, value)),
                false => unused.push((variable.position, value)),
            }
        }
        if self.run.phase == Phase::IntermediateUpdate {
            self.keep_inputs_in_step()?;
        }
        if !states.is_empty() {
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
        for (variable, value) in self.elements(references, asked, values)? {
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
        for (variable, value) in self.elements(references, Type::Integer, values)? {
            if !variable.has_start() {
                return Err(variable.row.not_settable(variable));
            }
            if self.run.phase != Phase::ConfigurationMode {
                return Err(Refusal::new(format_args!("{variable} can only be set in Configuration Mode")));
            }
            if !variable.row.range.contains(value as f64) {
                return Err(Refusal::value(variable, value, variable.row.range));
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
        for scalar in Variable::arrays().filter(|array| array.row.shape == Shape::Scalar) {
            match (scalar.real(before), scalar.item(before)) {
                (Some(value), _) => _ = scalar.set_real(&mut settings, value),
                (_, Some(item)) => _ = scalar.set_item(&mut settings, item),
                _ => {}
            }
        }
        self.run = Run { phase: self.run.phase, ..Run::new(self.run.purpose, &settings) };
    }

    /// The refusal to set variables of a type that has no settable ones.
    pub fn refuse_to_set(&self, references: &[u32], asked: Type) -> Result<(), Refusal> {
        references.iter().try_for_each(|reference| {
            let variable = self.variable(*reference, asked)?;
            Err(variable.row.not_settable(variable))
        })
    }

    /// Sets time derivatives of inputs, of `orders` from 1 on, for the next step: all, or none if any is refused. After
    /// that step the inputs keep the value they reached.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Refusal> {
        let each = |((reference, order), value): ((&u32, &i32), &f64)| {
            let variable = self.known(*reference)?;
            Ok((variable, variable.check_input_derivative(*order, *value)?, *value))
        };
        let checked = references.iter().zip(orders).zip(values).map(each).collect::<Result<Vec<_>, Refusal>>()?;
        let run = &mut self.run;
        let balls = run.settings.balls();
        let mut derivatives = std::mem::take(&mut run.input_derivatives);
        for (variable, order, value) in checked {
            derivatives.resize_with(order.max(derivatives.len()), || Inputs::zero(balls));
            variable.set_input(&mut derivatives[order - 1], value);
        }
        while derivatives.pop_if(|derivative| *derivative == Inputs::zero(balls)).is_some() {}
        run.inputs_changed |= !derivatives.is_empty();
        run.input_derivatives = derivatives;
        Ok(())
    }

    /// Sets variables to checked values. They take effect with the next step, in Initialization Mode and model exchange
    /// at once. Setting the same value again is no change.
    fn set<T>(&mut self, values: Vec<(Variable, T)>, set: impl Fn(&Variable, &mut Settings, T) -> bool) {
        let before = self.run.settings.parameters.tunables();
        let mut any = false;
        for (variable, value) in values {
            // The engine knows neither slopes nor `derivatives.of`, which only FMI 3.0 has: they are read when they are
            // used.
            if set(&variable, &mut self.run.settings, value) && variable.position < TABLE.len() {
                self.changed(variable, before);
                any = true;
            }
        }
        if any
            && self.run.phase > Phase::InitializationMode
            && let Some(exchange) = &mut self.run.exchange
        {
            let Settings { parameters, inputs, .. } = &self.run.settings;
            exchange.set(parameters, inputs);
        }
    }

    /// Whether a variable can be set now.
    fn check_settable(&self, variable: Variable) -> Result<(), Refusal> {
        let phase = self.run.phase;
        variable.check_settable(phase > Phase::InitializationMode)?;
        if phase == Phase::ContinuousTimeMode && variable.row.causality != Causality::Input {
            let text = "cannot be set in Continuous-Time Mode: only inputs can; tunable parameters in Event Mode";
            return Err(Refusal::new(format_args!("{variable} {text}")));
        }
        Ok(())
    }

    /// Marks a setting to be passed to the simulation; `before` are the tunable parameters before the call.
    fn changed(&mut self, variable: Variable, before: Tunables) {
        if self.run.phase <= Phase::InitializationMode {
            (self.run.simulation, self.run.exchange) = (None, None);
        } else if self.run.purpose.kind == Kind::ModelExchange {
            // There it acts at once.
        } else if variable.row.variability == Variability::Tunable {
            self.run.tuned_from.get_or_insert(before);
        } else {
            self.run.inputs_changed = true;
        }
    }
}
