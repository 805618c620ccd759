//! Runs an FMU by the simulation loops of the crate `fmi-rs`, prints what it finds wrong with the description, and
//! writes the result as it does:
//!
//!     run FMU OUT.csv INPUT.csv|- NAMES STEP STOP [exchange|located] [events] [early] [NAME=VALUE ...]
//!
//! NAMES are joined by `;`. Model exchange is by Euler's method, with steps of STEP / 512: the crate's, which cannot
//! end a step at an event off its grid, or, with `located`, one that can.

use std::fs::{File, read_to_string};
use std::path::Path;
use std::sync::Arc;

use fmi_rs::sim::SimulationError;
use fmi_rs::sim::solver::{Dae, ForwardEulerFactory, Ode, Solver, SolverFactory};
use fmi_rs::zip::extract_zip_archive;

/// Relative, to tell times apart: contacts of a row may close within some 1e-14 s.
const CLOCK: f64 = 1e-15;

/// Euler's method with steps of a length, s.
enum Method {
    OfTheCrate(f64),
    Located(f64),
}

struct Located<O> {
    length: f64,
    time: f64,
    x: Vec<f64>,
    ode: O,
}

impl SolverFactory for Method {
    fn create<'a, O: Ode + 'a, D: Dae + 'a>(
        &self,
        time: f64,
        tolerance: f64,
        ode: O,
        dae: Option<D>,
    ) -> Result<Box<dyn Solver + 'a>, SimulationError> {
        match *self {
            Self::OfTheCrate(fixed_step_size) => {
                ForwardEulerFactory { fixed_step_size }.create(time, tolerance, ode, dae)
            }
            Self::Located(length) => {
                let mut solver = Located { length, time, x: vec![0.0; ode.nx()], ode };
                solver.reset(time)?;
                Ok(Box::new(solver))
            }
        }
    }
}

impl<O: Ode> Solver for Located<O> {
    fn reset(&mut self, time: f64) -> Result<(), SimulationError> {
        self.time = time;
        let mut nominals = vec![0.0; self.x.len()];
        self.ode.init(&mut self.x, &mut nominals)?;
        assert!(nominals.iter().all(|nominal| *nominal > 0.0));
        Ok(())
    }

    fn step(&mut self, end: f64) -> Result<(f64, &[f64], bool), SimulationError> {
        let (mut rates, mut indicators) = (vec![0.0; self.x.len()], vec![0.0; self.ode.nz()]);
        while self.time < end {
            let length = self.length.min(end - self.time);
            self.ode.f(self.time, &self.x, &mut rates)?;
            self.x.iter_mut().zip(&rates).for_each(|(x, rate)| *x += length * rate);
            self.time = if length < self.length { end } else { self.time + length };
            self.ode.g(self.time, &self.x, &mut indicators)?;
        }
        Ok((self.time, &self.x, false))
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [fmu, out, input, names, step, stop, options @ ..] = arguments.as_slice() else { panic!("see the source") };
    let folder = tempfile::TempDir::new().unwrap();
    extract_zip_archive(Path::new(fmu), &folder).unwrap();
    let description = folder.path().join("modelDescription.xml");
    let (step, stop): (f64, f64) = (step.parse().unwrap(), stop.parse().unwrap());
    let given = |name: &str| options.iter().any(|option| option == name);
    let solver = match (given("exchange"), given("located")) {
        (true, _) => Some(Method::OfTheCrate(step / 512.0)),
        (_, true) => Some(Method::Located(step / 512.0)),
        _ => None,
    };
    let start = options.iter().filter_map(|option| option.split_once('='));
    // Both versions of FMI have types of their own.
    macro_rules! run {
        ($version:ident $($own:tt)*) => {{
            use fmi_rs::model_description::$version::ModelDescription;
            use fmi_rs::sim::$version as sim;
            let model = Arc::new(ModelDescription::from_path(&description).unwrap());
            model.validate().iter().for_each(|problem| println!("{}", problem.message));
            let indices = names.split(';').map(|name| model.variable_index_by_name(name).unwrap()).collect();
            let recorder = Arc::new(sim::recorder::Recorder::new(sim::Trajectories::new(model.clone(), indices)));
            let input = (input != "-").then(|| {
                let trajectories = sim::csv::read_csv(File::open(input).unwrap(), model.clone()).unwrap();
                Arc::new(sim::input::StaticInput::new(trajectories, CLOCK))
            });
            let settings = sim::SimulationSettings {
                unzipdir: folder.path().to_owned(),
                model_description: model,
                start_time: 0.0,
                stop_time: stop,
                set_stop_time: true,
                output_interval: step,
                tolerance: CLOCK,
                set_tolerance: false,
                start_values: start.map(|(name, value)| (name.to_owned(), value.to_owned())).collect(),
                event_mode_used: given("events"),
                early_return_allowed: given("early"),
                input_file: None,
                logging_on: false,
                log_time_scale: false,
                log_fmi_calls: false,
                log_file: None,
                initial_fmu_state_file: None,
                final_fmu_state_file: None,
                $($own)*
            };
            let ended = match solver {
                Some(solver) => sim::me::simulate(&settings, &solver, input, recorder.clone()),
                None => sim::cs::simulate(&settings, input, recorder.clone()),
            };
            sim::csv::write_csv(&recorder.trajectories.borrow(), out).unwrap();
            ended.err().map(|problem| format!("{problem:?}"))
        }};
    }
    let problem = if read_to_string(&description).unwrap().contains("fmiVersion=\"3.0\"") {
        run!(fmi3
            library_kind: fmi_rs::fmi3::LibraryKind::Native,
            enable_dae: false,
            visible: false,
            // The crate takes a callback for it and does not hand it on.
            intermediate_update: false,
        )
    } else {
        run!(fmi2)
    };
    if let Some(problem) = problem {
        eprintln!("error: {problem}");
        std::process::exit(1);
    }
}
