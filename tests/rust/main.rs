//! The tests of the FMU in Rust: through its C functions, and of the engine below them. One program, as linking is most
//! of what each costs.

#![expect(unsafe_code, reason = "hosts call C functions")]
#![expect(clippy::unwrap_used, reason = "what goes wrong fails the test")]

mod arcs;
mod creeping;
mod description;
mod differences;
mod directional_derivatives;
mod exchange;
mod ffi;
mod fmi3;
mod hopeless;
mod losses;
mod methods;
mod peaks;
mod properties;
mod reference;
mod rigid;
mod run_derivatives;
mod running;
mod runs;
mod spheres;
mod stiff;
mod time_derivatives;
mod viscoelastic;
mod waves;
mod work;
