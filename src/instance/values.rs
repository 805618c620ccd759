//! Reading and setting by value reference: whole arrays or, in FMI 2.0 and where variables are scalars, one element.

use std::fmt::Display;
use std::mem::MaybeUninit;

use super::legality::{Kind, Phase};
use super::lifecycle::{Instance, InstanceState, Start};
use crate::engine::{Exchange, NEVER};
use crate::model::Inputs;
use crate::variables::{Access, Causality, Extra, Number, Refusal, Settings, Shape, TABLE, Type, Variable, padding};

/// In messages: why a value is not a number.
const BEYOND_RANGE: &str = "what it is calculated from is beyond the range of doubles";

impl Start {
    /// The variable behind a value reference in a cradle of `balls` balls: an array or, where variables are scalars,
    /// one of them.
    #[inline]
    pub fn variable(&self, reference: u32, balls: usize) -> Option<Variable> {
        match (self.purpose.fmi3, self.scalars) {
            (false, _) => Variable::at(reference, balls),
            (true, true) => Variable::scalar_at(reference, balls),
            (true, false) => Variable::array_at(reference),
        }
    }
}

impl Instance {
    #[inline]
    fn is_of(&self, variable: Variable, asked: Type) -> bool {
        let of = variable.row.access.data_type();
        of == asked || !self.run.purpose.fmi3 && (of, asked) == (Type::Enumeration, Type::Integer)
    }

    /// The variable behind a value reference.
    fn known(&self, reference: u32) -> Result<Variable, Refusal> {
        let unknown = || Refusal::unknown(format_args!("value reference {reference}"), self.balls());
        self.start.variable(reference, self.balls()).ok_or_else(unknown)
    }

    /// The variable behind a value reference, if it is of this type.
    pub(super) fn variable(&self, reference: u32, asked: Type) -> Result<Variable, Refusal> {
        let variable = self.known(reference)?;
        if self.is_of(variable, asked) {
            return Ok(variable);
        }
        let of = variable.row.access.data_type();
        if !self.run.purpose.fmi3 {
            return Err(Refusal::new(format_args!("{variable} is of type {of:?}, not {asked:?}")));
        }
        let (asked, of) = (asked.fmi3(), of.fmi3());
        Err(refuse_reference(variable, format_args!("variables of type {asked}; this one is of type {of}")))
    }

    /// The variable behind a value reference, if it is of this type and its value is known; before initialization only
    /// start values are.
    #[cold]
    fn readable(&mut self, reference: u32, asked: Type) -> Result<Variable, Refusal> {
        let variable = self.variable(reference, asked)?;
        if self.run.phase == Phase::IntermediateUpdate && !self.run.read_logged && !variable.is_intermediate() {
            self.run.read_logged = true;
            let text =
                "is read in the middle of a step, where the standard allows variables with intermediateUpdate only";
            self.log.solver(format_args!("{variable} {text}")); // Some hosts read others, again and again.
        }
        if self.run.phase >= Phase::InitializationMode || variable.has_start() {
            return Ok(variable);
        }
        Err(refuse_reference(variable, "before initialization, those with a start value"))
    }

    /// Reads the elements of the variables behind `references`, all of this type, into as many `places`. A truth value
    /// is 1 or 0, an item its integer.
    pub fn get<T>(
        &mut self,
        asked: Type,
        references: &[u32],
        places: &mut [MaybeUninit<T>],
        convert: impl Fn(f64) -> T,
    ) -> Result<(), Refusal> {
        self.recompute()?;
        let (balls, phase, mut found) = (self.balls(), self.run.phase, 0);
        // In these phases any variable of the type may be read.
        let any = phase >= Phase::InitializationMode && phase != Phase::IntermediateUpdate;
        for reference in references {
            let variable = match self.start.variable(*reference, balls) {
                Some(variable) if any && self.is_of(variable, asked) => variable,
                _ => self.readable(*reference, asked)?,
            };
            for index in 0..variable.len(balls) {
                let value = self.value(variable.element(index))?;
                if let Some(place) = places.get_mut(found) {
                    place.write(convert(value));
                }
                found += 1;
            }
        }
        Refusal::unless_count("nValues", places.len(), found)
    }

    /// Recomputes values after setters that act at once; to be called before reading.
    #[inline]
    pub(super) fn recompute(&mut self) -> Result<(), Refusal> {
        let at_once = self.run.phase == Phase::EventMode && self.run.purpose.has_event_mode();
        if at_once { self.update_simulation() } else { Ok(()) }
    }

    /// The value of a scalar or of an element of an array.
    #[inline(always)] // with a call, a getter of one value takes a twentieth longer
    fn value(&mut self, variable: Variable) -> Result<f64, Refusal> {
        let Variable { row, index, .. } = variable;
        if let Access::Instance(_, extra) = row.access {
            return self.extra(variable, extra);
        }
        if index >= row.shape.len(self.balls()) {
            return Ok(self.of_no_contact(variable));
        }
        if self.run.purpose.events
            && self.run.phase > Phase::InitializationMode
            && let Some(value) = self.after_tick(variable)
        {
            return Ok(value);
        }
        Ok(match row.access {
            Access::Real(get) => {
                let value = get(self.results()?, index);
                // In the error state values may be anything.
                if !value.is_finite() && self.run.phase != Phase::Error {
                    return Err(self.no_number(variable));
                }
                value
            }
            Access::Count(get) => get(self.results()?, index) as f64,
            Access::Flag(get) => get(self.results()?, index).into(),
            _ => variable.value(&self.run.settings).unwrap_or_default(),
        })
    }

    /// Refuses `values`, called `name` and numbered from `from` + 1 on, if one is not finite or a ball has no place.
    pub(super) fn require_numbers(&self, name: &str, from: usize, values: &[f64]) -> Result<(), Refusal> {
        let any = values.iter().fold(false, |any, value| any | !value.is_finite());
        let lost = any || self.run.exchange.as_ref().is_some_and(Exchange::lacks_places);
        if !lost || self.run.phase == Phase::Error {
            return Ok(());
        }
        Err(match values.iter().position(|value| !value.is_finite()) {
            Some(first) => self.no_number(format_args!("{name} {}", from + first + 1)),
            None => self.no_number(name),
        })
    }

    /// Why there is no value of `what`.
    #[cold]
    pub(super) fn no_number(&self, what: impl Display) -> Refusal {
        let text = match self.run.exchange.as_ref().and_then(Exchange::lost) {
            Some(error) => format!("{what} has no value: {error}"),
            None => format!("{what} has no value at t = {} s: {BEYOND_RANGE}", Number(self.time())),
        };
        if self.run.phase == Phase::ContinuousTimeMode { Refusal::of_state(text) } else { Refusal::no_value(text) }
    }

    /// The value after the last tick of a variable that changes in Event Mode only.
    fn after_tick(&self, variable: Variable) -> Option<f64> {
        let (discrete, work) = (self.run.clocks.discrete.get(variable.index), self.run.clocks.work);
        Some(match variable.row.name {
            "t_onset" => discrete?.onset,
            "t_release" => discrete?.release,
            "pulses" => discrete?.pulses as f64,
            "inContact" => discrete?.closed.into(),
            "solver.steps" => work.steps as f64,
            "solver.evaluations" => work.evaluations as f64,
            "solver.events" => work.events as f64,
            _ => return None,
        })
    }

    fn extra(&mut self, variable: Variable, extra: Extra) -> Result<f64, Refusal> {
        let (clocks, contact) = (&self.run.clocks, variable.index);
        Ok(match extra {
            Extra::Time | Extra::Pulses => self.time(),
            Extra::Balls => self.balls() as f64,
            Extra::Clock(edge) => (self.run.phase == Phase::EventMode && clocks.active[edge as usize]).into(),
            Extra::TickTime(edge) => clocks.time(edge),
            Extra::TickOf(edge) => clocks.is_part(edge, contact).into(),
            Extra::Ended(value) => clocks.ended(contact).and_then(|pulse| pulse.value(value)).unwrap_or_default(),
            Extra::Joined(..) => {
                return variable.of_fmi2(self.balls()).map_or(Ok(0.0), |of| self.value(of));
            }
            Extra::ContactIndicator | Extra::ClipIndicator => self.indicator(extra, contact)?,
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

    /// Checks that a variable can be set now, and to this value.
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
        let balls = self.balls();
        if self.run.phase > Phase::InitializationMode {
            self.check_tuned(&elements)?;
        }
        let (mut wanted, mut any, mut states) = (balls, false, Vec::new());
        if self.run.phase == Phase::IntermediateUpdate {
            self.keep_inputs();
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
                self.changed(variable);
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

    /// Refuses tunable parameters that give coefficients that are not finite, although each parameter is in its range.
    fn check_tuned(&self, elements: &[(Variable, f64)]) -> Result<(), Refusal> {
        let is_tuned = |(variable, _): &&(Variable, f64)| {
            variable.row.causality == Causality::Parameter && variable.index < variable.row.shape.len(self.balls())
        };
        let mut tuned = elements.iter().filter(is_tuned).peekable();
        if tuned.peek().is_none() {
            return Ok(());
        }
        let mut settings = self.run.settings.clone();
        tuned.for_each(|(variable, value)| {
            variable.set(&mut settings, *value);
        });
        settings.parameters.check_coefficients().map_err(Refusal::new)
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
        self.run = InstanceState { phase: self.run.phase, ..InstanceState::new(self.run.purpose, &settings) };
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

    /// Drops or marks what depends on a setting. Tunable parameters are compared with those of the simulation; in model
    /// exchange all act at once.
    fn changed(&mut self, variable: Variable) {
        if self.run.phase <= Phase::InitializationMode {
            (self.run.simulation, self.run.exchange) = (None, None);
        } else if variable.row.causality == Causality::Input {
            self.run.inputs_changed |= self.run.purpose.kind == Kind::CoSimulation;
        }
    }
}

fn refuse_reference(variable: Variable, allowed: impl Display) -> Refusal {
    Refusal::argument("valueReference", variable, allowed)
}
