//! Newton's cradle with compliant contacts as an FMU: FMI 2.0 and 3.0, for co-simulation and
//! model exchange.
//!
//! The model is P. C. Breedveld's (Modelling & simulation of bouncing objects: Newton's cradle revisited, Mechatronics
//! 2002): neighbouring balls are joined by springs that act only while the balls overlap, so that a collision is a
//! short, stiff, continuous contact, and the one-after-another transfer of momentum comes out by itself. The classical
//! model that he sets it against, impacts without duration, is there to compare (`contact.model = rigid`).
//!
//! # How it is built
//!
//! A call of a host passes three of the modules below: [`fmi2`] or [`fmi3`] turns C into Rust and asks whether the call
//! is legal now, `instance` carries it out, [`engine`] moves the trajectory. What the host reads is evaluated at its
//! communication point without moving anything. [`model`] is the physics in SI units, `solver` numerics that know no
//! cradle, [`variables`] the interface as one table. The producer of the FMU is built without the feature `engine`: it
//! needs the parameters and the table only.
//!
//! Beside the event-driven engine stand the methods that one would take without it (`solver.method`):
//! [`engine::Continuous`] integrates the whole chain by backward differentiation, Adams-Moulton or Runge-Kutta
//! formulas. They are slow, for comparison, and an independent check. In model exchange the host takes their part
//! ([`engine::Exchange`]). An instance sees either of them as an [`engine::Simulation`], the variables as
//! [`model::Results`].
//!
//! # Three ideas
//!
//! 1. *Flight is exact.* Between contacts a ball swings in closed form from its anchor; it is evaluated, never stepped.
//!    On an arc, a power series takes the place of the closed form.
//! 2. *A contact costs only what touches.* Two elastic balls have an outcome in closed form. All others form clusters
//!    with their neighbours: contacts that are not linear, and those on arcs, are followed by Gauss collocation; linear
//!    ones by Taylor series or, if they are damped or stay closed, by their natural modes; what is stiff for the pace
//!    of the motion by an L-stable collocation method.
//! 3. *The communication grid is not the integration grid.* While the inputs stay as they are, the trajectory is the
//!    same bit for bit, however a host cuts its steps.
//!
//! How the cradle is computed and why, with equations and sources: [`theory`]. How to change it: `CONTRIBUTING.md`.
//!
//! # Example
//!
//! ```
//! use newtons_cradle::engine::{Chain, Engine, Results};
//! use newtons_cradle::model::{Inputs, Parameters};
//!
//! let parameters = Parameters::default_for(5);
//! let mut cradle = Engine::new(&parameters, &Inputs::zero(5), 0.0)?;
//! let mut pulses = Vec::new();
//! cradle.advance(10.0, &mut pulses)?;
//! assert_eq!(pulses.len(), 42);
//! assert!(cradle.energy_residual().abs() < 1e-12 * cradle.total_energy());
//! # Ok::<(), newtons_cradle::engine::EngineError>(())
//! ```

// In tests what goes wrong fails the test.
#![cfg_attr(test, allow(clippy::unwrap_used))]
// A browser calls the instance directly: what only the C interfaces use is unused there.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_imports))]

#[cfg(feature = "engine")]
pub mod engine;
// In a browser no host could call them: web/ has functions of its own.
#[cfg(all(feature = "engine", not(target_family = "wasm")))]
mod ffi;
pub mod files;
#[cfg(all(feature = "engine", not(target_family = "wasm")))]
pub mod fmi2;
#[cfg(all(feature = "engine", not(target_family = "wasm")))]
pub mod fmi3;
pub mod forecast;
#[cfg(feature = "engine")]
mod instance;
#[cfg_attr(not(feature = "engine"), allow(dead_code, unused_imports))]
pub mod model;
mod number;
#[cfg_attr(not(feature = "engine"), allow(dead_code, unused_imports))]
mod solver;
// The link to another page leads to the item here.
#[doc = "[loss laws]: crate::model::DampingLaw"]
#[doc = ""]
#[doc = include_str!("../docs/theory.md")]
#[cfg(doc)]
pub mod theory {}
pub mod variables;
