//! Directional, adjoint and output derivatives by the value references of FMI 3.0.

use super::derivatives::no_derivative;
use super::legality::{Kind, Phase};
use super::lifecycle::Instance;
use crate::variables::{Access, DerivativesOf, Extra, Refusal, Type};

/// Value reference of an element in FMI 2.0; none if it belongs to no contact.
type Element = Option<u32>;

impl Instance {
    /// The elements of the real variables behind `references`. Slopes `without_effect` count as elements of no contact.
    fn parts(&self, references: &[u32], without_effect: bool) -> Result<Vec<Element>, Refusal> {
        let balls = self.balls();
        let mut elements = Vec::new();
        for reference in references {
            let array = self.array(*reference, Type::Real)?;
            let known = match array.row.access {
                Access::Instance(_, extra) => matches!(extra, Extra::Joined(..)),
                _ => without_effect || !array.is_slope(),
            };
            if !known {
                return Err(no_derivative(array));
            }
            let element = |index| array.element(index, balls).map(|variable| variable.reference());
            elements.extend((0..array.len(balls)).map(element));
        }
        Ok(elements)
    }

    fn knowns(&self, references: &[u32]) -> Result<Vec<Element>, Refusal> {
        let of_step = self.run.purpose.kind == Kind::CoSimulation
            && self.run.phase > Phase::InitializationMode
            && self.run.settings.derivatives_of != DerivativesOf::Point;
        self.parts(references, !of_step)
    }

    /// Derivatives of all elements of the unknowns along the direction `seed` of the elements of the knowns.
    pub fn directional(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Refusal> {
        let (unknowns, knowns) = (self.parts(unknowns, false)?, self.knowns(knowns)?);
        Refusal::unless_count("nSeed", seed.len(), knowns.len())?;
        self.recompute()?;
        let (references, direction) = existing(&knowns, seed);
        in_places(&unknowns, |wanted| self.directional_derivatives(wanted, &references, &direction))
    }

    /// The sums of the derivatives of the unknowns by each element of the knowns, weighted by `seed`.
    pub fn adjoint(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Refusal> {
        let (unknowns, knowns) = (self.parts(unknowns, false)?, self.knowns(knowns)?);
        Refusal::unless_count("nSeed", seed.len(), unknowns.len())?;
        self.recompute()?;
        let (references, weights) = existing(&unknowns, seed);
        in_places(&knowns, |wanted| self.adjoint_derivatives(&references, &weights, wanted))
    }

    /// Time derivatives of the elements of real outputs, one order for each variable.
    pub fn output_derivatives_of_arrays(&mut self, references: &[u32], orders: &[i32]) -> Result<Vec<f64>, Refusal> {
        let (mut elements, mut element_orders) = (Vec::new(), Vec::new());
        for (reference, order) in references.iter().zip(orders) {
            elements.extend(self.parts(&[*reference], false)?);
            element_orders.resize(elements.len(), *order);
        }
        let (_, orders) = existing(&elements, &element_orders);
        in_places(&elements, |wanted| self.output_derivatives(wanted, &orders))
    }
}

/// The elements that exist in FMI 2.0, each with its entry of `with`.
fn existing<T: Copy>(elements: &[Element], with: &[T]) -> (Vec<u32>, Vec<T>) {
    elements.iter().zip(with).filter_map(|(element, with)| Some(((*element)?, *with))).unzip()
}

/// Puts the values of the existing elements in their places; the others are 0.
fn in_places(
    elements: &[Element],
    find: impl FnOnce(&[u32]) -> Result<Vec<f64>, Refusal>,
) -> Result<Vec<f64>, Refusal> {
    let wanted: Vec<u32> = elements.iter().flatten().copied().collect();
    let mut found = find(&wanted)?.into_iter();
    Ok(elements.iter().map(|element| element.and_then(|_| found.next()).unwrap_or_default()).collect())
}
