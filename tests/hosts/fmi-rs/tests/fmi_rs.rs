//! The `fmi-rs` crate of CATIA-Systems, another one than `fmi`, as the host, with its own simulation loops: what it
//! finds wrong with descriptions, and the same bits from FMUs of both versions in co-simulation and in model exchange.

use std::collections::HashSet;
use std::path::Path;

use cradle_host_fmi_rs::simulate;
use fmi_rs::model_description::{fmi2, fmi3};
use fmi_rs::sim::SimulationError;
use fmi_rs::sim::fmi3::VariableValue;
use fmi_rs::sim::solver::{Dae, Ode, Solver, SolverFactory};
use fmi_rs::zip::extract_zip_archive;
use newtons_cradle::engine::{Engine, Pulse};
use newtons_cradle::variables::{Description, START_TIME, STOP_TIME, Settings};
use tempfile::TempDir;

/// What is compared, with the number of elements in an array.
const COMPARED: [(&str, usize); 6] =
    [("x", 5), ("v", 5), ("E_total", 0), ("p_total", 0), ("impulse", 4), ("pulses", 4)];

/// Numbers recorded at a time, s: the last ones where there are several.
type Record = Vec<(f64, Vec<u64>)>;

fn record(time: &[f64], rows: impl Iterator<Item = Vec<f64>>) -> Record {
    let mut record = Record::new();
    for (time, row) in time.iter().zip(rows) {
        let bits = row.into_iter().map(f64::to_bits).collect();
        match record.last_mut() {
            Some((last, before)) if last == time => *before = bits,
            _ => record.push((*time, bits)),
        }
    }
    record
}

/// An FMU unpacked.
fn unpacked(path: &Path) -> TempDir {
    let folder = TempDir::new().unwrap();
    extract_zip_archive(path, &folder).unwrap();
    folder
}

/// Runs the FMU of FMI 2.0 with this solver, or in co-simulation.
fn run2(step: f64, solver: Option<Steps>) -> Record {
    let folder = unpacked(&cradle_host_fmi_rs::fmu());
    let names = COMPARED.iter().flat_map(|(name, count)| match count {
        0 => vec![(*name).to_owned()],
        _ => (1..=*count).map(|i| format!("{name}[{i}]")).collect(),
    });
    let (recorder, ended) =
        simulate!(2, folder.path(), names, None, solver, step, STOP_TIME, Vec::new(), [false, false]);
    ended.unwrap();
    let recorded = recorder.trajectories.borrow();
    record(&recorded.time, recorded.rows.iter().map(|row| row.iter().map(|value| value.to_f64().unwrap()).collect()))
}

/// Runs the FMU of FMI 3.0 likewise. The elements of arrays over contacts that belong to none are left out.
fn run3(step: f64, solver: Option<Steps>, modes: [bool; 2]) -> Record {
    let folder = unpacked(&cradle_host_fmi_rs::fmu3());
    let names = COMPARED.map(|(name, _)| name);
    let (recorder, ended) = simulate!(3, folder.path(), names, None, solver, step, STOP_TIME, Vec::new(), modes);
    ended.unwrap();
    let recorded = recorder.trajectories.borrow();
    let elements = |row: &Vec<VariableValue>| {
        let values = row.iter().zip(COMPARED);
        values.flat_map(|(value, (_, count))| value.as_f64().unwrap().into_iter().take(count.max(1))).collect()
    };
    record(&recorded.time, recorded.rows.iter().map(elements))
}

/// Euler's method with these steps at most, s. The crate's own cannot end a step at an event off its grid.
#[derive(Clone, Copy)]
struct Steps(f64);

struct Euler<O> {
    steps: Steps,
    time: f64,
    x: Vec<f64>,
    ode: O,
}

impl SolverFactory for Steps {
    fn create<'a, O: Ode + 'a, D: Dae + 'a>(
        &self,
        time: f64,
        _tolerance: f64,
        ode: O,
        _dae: Option<D>,
    ) -> Result<Box<dyn Solver + 'a>, SimulationError> {
        let mut solver = Euler { steps: *self, time, x: vec![0.0; ode.nx()], ode };
        solver.reset(time)?;
        Ok(Box::new(solver))
    }
}

impl<O: Ode> Solver for Euler<O> {
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
            let length = self.steps.0.min(end - self.time);
            self.ode.f(self.time, &self.x, &mut rates)?;
            self.x.iter_mut().zip(&rates).for_each(|(x, rate)| *x += length * rate);
            self.time = if length < self.steps.0 { end } else { self.time + length };
            self.ode.g(self.time, &self.x, &mut indicators)?;
        }
        Ok((self.time, &self.x, false))
    }
}

/// What the crate finds wrong. FMPy wants output clocks among the initial unknowns, this crate does not, and neither
/// minds an FMU without clocks.
#[test]
fn descriptions_are_valid() {
    let settings = Settings::default_for(5);
    let two = fmi2::ModelDescription::from_string(&Description::of(&settings).xml("2000-01-01T00:00:00Z")).unwrap();
    assert_eq!(two.validate().len(), 0);
    let problems = |description: Description| {
        let model = fmi3::ModelDescription::from_string(&description.xml("2000-01-01T00:00:00Z")).unwrap();
        model.validate().into_iter().map(|problem| problem.message).collect::<Vec<_>>()
    };
    let with_clocks = problems(Description::fmi3(&settings));
    assert!(with_clocks.len() == 1 && with_clocks[0].contains("initial unknowns"), "{with_clocks:?}");
    assert_eq!(problems(Description { clocks: false, ..Description::fmi3(&settings) }), [""; 0]);
}

#[test]
fn co_simulation_gives_the_same_bits_in_both_versions() {
    let settings = Settings::default_for(5);
    let mut pulses: Vec<Pulse> = Vec::new();
    let mut engine = Engine::new(&settings.parameters, &settings.inputs, START_TIME).unwrap();
    engine.advance(STOP_TIME, &mut pulses).unwrap();
    let instants: HashSet<u64> =
        pulses.iter().flat_map(|pulse| [pulse.onset, pulse.release]).map(f64::to_bits).collect();
    assert!(instants.len() > pulses.len());
    for step in [1.0 / 1024.0, 0.125, 10.0] {
        let two = run2(step, None);
        assert_eq!(two.len(), (STOP_TIME / step) as usize + 1);
        for options in [[false, false], [true, false], [true, true]] {
            let three = run3(step, None, options);
            let common: Vec<_> = three.iter().filter(|(time, _)| two.iter().any(|(other, _)| other == time)).collect();
            assert!(common.iter().copied().eq(&two), "{step} {options:?}");
            // Early return adds every onset and release.
            let added = if options[1] { instants.len() } else { 0 };
            assert_eq!(three.len() - two.len(), added, "{step} {options:?}");
        }
    }
}

#[test]
fn model_exchange_gives_the_same_bits_in_both_versions() {
    let solver = Some(Steps(1.0 / 1024.0));
    let (two, three) = (run2(0.125, solver), run3(0.125, solver, [false; 2]));
    assert!(two.len() > 81, "there are events off the grid");
    assert_eq!(two, three);
    let (time, last) = two.last().unwrap();
    assert_eq!(*time, STOP_TIME);
    // Euler's method adds its own energy, less at each step that an event or a communication point cuts in two.
    let numbers: Vec<f64> = last.iter().copied().map(f64::from_bits).collect();
    let (energy, pulses) = (numbers[10], &numbers[16..]);
    assert_eq!(pulses, [7.0, 14.0, 14.0, 7.0]);
    let growth = 5.0 / 1024.0_f64.powi(2);
    let (most, cuts) = (0.05 * (1.0 + growth).powi(10_240), two.len() as f64);
    assert!((1.0 - cuts * growth / 2.0..1.0).contains(&(energy / most)), "{energy} {most}");
}
