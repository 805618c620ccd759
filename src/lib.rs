//! Newton's cradle with compliant contacts as an FMU: FMI 2.0 and 3.0, for co-simulation and
//! model exchange.
//!
//! The model is P. C. Breedveld's (Modelling & simulation of bouncing objects: Newton's cradle revisited, Mechatronics
//! 2002): neighbouring balls are joined by springs that act only while the balls overlap. A collision is a short,
//! stiff, continuous contact; the transfer of momentum from ball to ball is a result, not an assumption. The classical
//! model to which he compares it, impacts without duration, is here too (`contact.model = rigid`).
//!
//! # How it is built
//!
//! A call of a host passes three of the modules below: [`fmi2`] or [`fmi3`] turns C into Rust and checks that the call
//! is legal in the current state, `instance` carries it out, [`engine`] moves the trajectory. Reading a value evaluates
//! it at the communication point and moves nothing. [`model`] is the physics in SI units, `solver` numerics that know
//! no cradle, [`variables`] the interface as one table. `cradle-fmu`, which writes FMUs, is built without the feature
//! `engine`, because it needs only the parameters and the table.
//!
//! `solver.method` also offers the usual methods, for comparison and as an independent check; they are slow.
//! [`engine::Continuous`] integrates the whole chain by backward differentiation, Adams-Moulton or Runge-Kutta
//! formulas. In model exchange the host integrates ([`engine::Exchange`]). An instance sees each of them as an
//! [`engine::Simulation`], the variables as [`model::Results`].
//!
//! # Three ideas
//!
//! 1. *Flight is exact.* Between contacts a ball swings in closed form from its anchor; it is evaluated, never stepped.
//!    On an arc, a power series takes the place of the closed form.
//! 2. *A contact costs only what touches.* The impact of two elastic balls has a closed form. All others form clusters
//!    with their neighbours. Their contacts are followed by Gauss collocation if nonlinear or on arcs; by Taylor series
//!    if linear, or by natural modes if damped or long closed; by an L-stable collocation method if stiff.
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

// Tests may unwrap: a panic fails the test.
#![cfg_attr(test, allow(clippy::unwrap_used))]
// A browser calls the instance directly, so items that only the C interfaces use are unused there.
#![cfg_attr(target_family = "wasm", allow(dead_code, unused_imports))]

#[cfg(feature = "engine")]
pub mod engine;
// No host can call the C interfaces in a browser; web/ has its own functions.
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
// Here the page's link to the loss laws leads to the item instead of another page.
#[doc = "[loss laws]: crate::model::DampingLaw"]
#[doc = ""]
#[doc = include_str!("../docs/theory.md")]
#[cfg(doc)]
pub mod theory {}
pub mod variables;
