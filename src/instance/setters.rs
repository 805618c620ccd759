//! Setting by value reference, as hosts of either version do.

use super::legality::{Kind, Phase};
use super::lifecycle::Instance;
use super::run::Run;
use super::values::refuse_reference;
use crate::model::{Inputs, Tunables};
use crate::variables::{Causality, Refusal, Settings, Shape, TABLE, Type, Variability, Variable};

impl Instance {
    /// Sets the variables behind `references`, all of this type, to `values`, element after element: all, or none if
    /// any is refused.
    pub fn set<T: Copy>(
        &mut self,
        asked: Type,
        references: &[u32],
        values: &[T],
        convert: impl Fn(T) -> f64,
    ) -> Result<(), Refusal> {
        let elements = self.elements(asked, references, values, convert)?;
        elements.iter().try_for_each(|(variable, value)| self.check(*variable, *value))?;
        self.set_checked(elements)
    }

    /// The elements of the variables behind `references`, all of this type, each paired with one of the `values`.
    fn elements<T: Copy>(
        &self,
        asked: Type,
        references: &[u32],
        values: &[T],
        convert: impl Fn(T) -> f64,
    ) -> Result<Vec<(Variable, f64)>, Refusal> {
        let balls = self.balls();
        let (mut elements, mut wanted) = (Vec::with_capacity(values.len()), 0);
        for reference in references {
            let variable = self.variable(*reference, asked)?;
            if self.run.phase == Phase::IntermediateUpdate && !variable.is_intermediate() {
                return Err(refuse_reference(variable, "in the middle of a step, inputs with intermediateUpdate"));
            }
            for index in 0..variable.len(balls) {
                elements.extend(values.get(wanted).map(|value| (variable.element(index), convert(*value))));
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

    /// Whether a variable can be set now, and to this value.
    fn check(&self, variable: Variable, value: f64) -> Result<(), Refusal> {
        let (phase, causality) = (self.run.phase, variable.row.causality);
        if causality == Causality::StructuralParameter {
            if phase != Phase::ConfigurationMode {
                return Err(Refusal::new(format_args!("{variable} can only be set in Configuration Mode")));
            }
        } else if self.state_place(variable).is_none() {
            variable.check_settable(phase > Phase::InitializationMode)?;
            if phase == Phase::ContinuousTimeMode && causality != Causality::Input {
                let text = "cannot be set in Continuous-Time Mode: only inputs can; tunable parameters in Event Mode";
                return Err(Refusal::new(format_args!("{variable} {text}")));
            }
        }
        variable.check(value)
    }

    /// The place of a variable among the states, if it can now be set as one.
    #[inline]
    fn state_place(&self, variable: Variable) -> Option<usize> {
        let by_states = self.run.phase == Phase::ContinuousTimeMode && self.run.purpose.fmi3;
        if by_states { variable.state_place(self.balls(), self.start.scalars) } else { None }
    }

    /// Sets elements to checked values. They take effect with the next step, in Initialization Mode and model exchange
    /// at once. Setting the same value again is no change.
    fn set_checked(&mut self, elements: Vec<(Variable, f64)>) -> Result<(), Refusal> {
        let (balls, before) = (self.balls(), self.run.settings.parameters.tunables());
        let (mut wanted, mut any, mut states) = (balls, false, Vec::new());
        if self.run.phase == Phase::IntermediateUpdate {
            self.keep_inputs_in_step()?;
        }
        for (variable, value) in elements {
            if let Some(place) = self.state_place(variable) {
                if states.is_empty() {
                    states = self.continuous_states()?;
                }
                states[place] = value;
            } else if variable.row.causality == Causality::StructuralParameter {
                wanted = value as usize;
            } else if variable.index >= variable.row.shape.len(balls) {
                self.run.padding.insert(variable.position, value);
            } else if variable.set(&mut self.run.settings, value) && variable.position < TABLE.len() {
                // The engine knows neither slopes nor `derivatives.of`, which only FMI 3.0 has: they are read when they
                // are used.
                self.changed(variable, before);
                any = true;
            }
        }
        if !states.is_empty() {
            self.set_continuous_states(&states)?;
        }
        if any
            && self.run.phase > Phase::InitializationMode
            && let Some(exchange) = &mut self.run.exchange
        {
            let Settings { parameters, inputs, .. } = &self.run.settings;
            exchange.set(parameters, inputs);
        }
        if wanted != balls {
            self.resize(wanted);
        }
        Ok(())
    }

    /// Changes the number of balls. This resets arrays to their defaults and keeps scalars.
    fn resize(&mut self, balls: usize) {
        let before = &self.run.settings;
        let mut settings = Settings::default_for(balls);
        for scalar in Variable::arrays().filter(|array| array.row.shape == Shape::Scalar) {
            if let Some(value) = scalar.value(before) {
                scalar.set(&mut settings, value);
            }
        }
        self.run = Run { phase: self.run.phase, ..Run::new(self.run.purpose, &settings) };
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
