//! Directional, adjoint and output derivatives by the value references of FMI 3.0.

use crate::instance::legality::{Kind, Phase};
use crate::instance::lifecycle::Instance;
use crate::instance::refusal::Refusal;
use crate::variables::{Array, ArrayType, Extra};

/// An element: its reference in a cradle of as many balls, or nothing for one that belongs to no contact.
type Element = Option<u32>;

impl Instance {
    /// The elements of the real variables behind `references`.
    fn elements(&self, references: &[u32]) -> Result<Vec<Element>, Refusal> {
        let balls = self.balls();
        let mut elements = Vec::new();
        for reference in references {
            match self.array(*reference, ArrayType::Float64)? {
                array @ (Array::Row(_) | Array::Extra(Extra::Positions | Extra::Rates)) => {
                    let element = |index| array.element(index, balls).map(|variable| variable.reference());
                    elements.extend((0..array.len(balls)).map(element));
                }
                other => return Err(Refusal::Derivative(other.to_string())),
            }
        }
        Ok(elements)
    }

    /// The elements of the knowns. Slopes act over a step: at a point, and where no step is made, nothing depends on
    /// them.
    fn knowns(&self, references: &[u32]) -> Result<Vec<Element>, Refusal> {
        let of_step = self.run.kind == Kind::CoSimulation
            && self.run.phase > Phase::InitializationMode
            && !self.hybrid()?.derives_at_point();
        let mut elements = Vec::new();
        for reference in references {
            match self.array(*reference, ArrayType::Float64)? {
                slope @ Array::Slope(_) if !of_step => elements.resize(elements.len() + slope.len(self.balls()), None),
                _ => elements.extend(self.elements(&[*reference])?),
            }
        }
        Ok(elements)
    }

    /// Derivatives of the unknowns, element by element, along the direction in which the elements of the knowns change
    /// by `seed`.
    pub fn directional(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Refusal> {
        let (unknowns, knowns) = (self.elements(unknowns)?, self.knowns(knowns)?);
        require_length("nSeed", seed.len(), knowns.len())?;
        let (references, direction): (Vec<u32>, Vec<f64>) =
            knowns.iter().zip(seed).filter_map(|(known, change)| Some(((*known)?, *change))).unzip();
        self.along(&unknowns, &references, &direction)
    }

    /// The sums of the derivatives of the unknowns by each element of the knowns, weighted by `seed`.
    pub fn adjoint(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Refusal> {
        let (unknowns, knowns) = (self.elements(unknowns)?, self.knowns(knowns)?);
        require_length("nSeed", seed.len(), unknowns.len())?;
        self.update_in_event_mode()?;
        let (references, weights): (Vec<u32>, Vec<f64>) =
            unknowns.iter().zip(seed).filter_map(|(unknown, weight)| Some(((*unknown)?, *weight))).unzip();
        let existing: Vec<u32> = knowns.iter().filter_map(|known| *known).collect();
        let mut found = self.adjoint_derivatives(&references, &weights, &existing)?.into_iter();
        Ok(knowns.iter().map(|known| known.and_then(|_| found.next()).unwrap_or_default()).collect())
    }

    fn along(&mut self, unknowns: &[Element], knowns: &[u32], direction: &[f64]) -> Result<Vec<f64>, Refusal> {
        self.update_in_event_mode()?;
        let references: Vec<u32> = unknowns.iter().filter_map(|unknown| *unknown).collect();
        let mut found = self.directional_derivatives(&references, knowns, direction)?.into_iter();
        Ok(unknowns.iter().map(|unknown| unknown.and_then(|_| found.next()).unwrap_or_default()).collect())
    }

    /// In Event Mode what was set acts at once.
    fn update_in_event_mode(&mut self) -> Result<(), Refusal> {
        if self.run.phase == Phase::EventMode && self.run.takes_part_in_events() {
            self.update_simulation()?;
        }
        Ok(())
    }

    /// Derivatives by time of the elements of real outputs, each of its order.
    pub fn output_derivatives_of_arrays(&mut self, references: &[u32], orders: &[i32]) -> Result<Vec<f64>, Refusal> {
        let (mut elements, mut element_orders) = (Vec::new(), Vec::new());
        for (reference, order) in references.iter().zip(orders) {
            elements.extend(self.elements(&[*reference])?);
            element_orders.resize(elements.len(), *order);
        }
        let (known, orders): (Vec<u32>, Vec<i32>) =
            elements.iter().zip(element_orders).filter_map(|(element, order)| Some(((*element)?, order))).unzip();
        let mut found = self.output_derivatives(&known, &orders)?.into_iter();
        Ok(elements.iter().map(|element| element.and_then(|_| found.next()).unwrap_or_default()).collect())
    }
}

pub(super) fn require_length(name: &'static str, given: usize, wanted: usize) -> Result<(), Refusal> {
    if given == wanted {
        return Ok(());
    }
    Err(Refusal::Argument { name, value: given.to_string(), allowed: wanted.to_string() })
}
