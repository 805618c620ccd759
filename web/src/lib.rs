//! The engine in a browser: functions that the page calls, and memory that both share.
//!
//! A run is known by a number. Texts and numbers lie in a buffer each, until the next call. The page starts a run from
//! a [`Recipe`], the JSON that an FMU carries in its resources, with the variables' names, units and ranges, and gets
//! the FMU's messages when it is refused. Nothing here needs unsafe code: this side owns buffers and runs.

use std::cell::RefCell;
use std::collections::BTreeMap;

use newtons_cradle::engine::{Chain, Engine, EngineError, Observer, Pulse, Results};
use newtons_cradle::forecast::Forecast;
use newtons_cradle::model::{Inputs, Parameters, SolverMethod};
use newtons_cradle::variables::{Causality, Kind, Recipe, Settings, StartValue, variables};

mod hands;

/// A run, with the parameters and inputs that it was started with.
#[derive(Clone)]
struct Run {
    engine: Engine,
    parameters: Parameters,
    inputs: Inputs,
}

impl Run {
    /// Starts at `time` (s) with these parameters.
    fn new(parameters: Parameters, inputs: Inputs, time: f64) -> Result<Self, EngineError> {
        Ok(Self { engine: Engine::new(&parameters, &inputs, time)?, parameters, inputs })
    }
}

thread_local! {
    static RUNS: RefCell<BTreeMap<i32, Run>> = RefCell::default();
    static TEXT: RefCell<Vec<u8>> = RefCell::default();
    static NUMBERS: RefCell<Vec<f64>> = RefCell::default();
}

/// Calls `act` on a run. The page only knows numbers that [`start`] and [`copy`] have returned.
fn with<R>(run: i32, act: impl FnOnce(&mut Run) -> R) -> R {
    RUNS.with_borrow_mut(|runs| act(runs.get_mut(&run).expect("the page asks for runs that it was given")))
}

/// Keeps a run. Returns its number, perhaps of a run that was forgotten.
fn keep(run: Run) -> i32 {
    RUNS.with_borrow_mut(|runs| {
        let number = runs.last_key_value().map_or(0, |(last, _)| last + 1);
        runs.insert(number, run);
        number
    })
}

/// Leaves a text for the page.
fn say(reason: &str) {
    TEXT.with_borrow_mut(|text| reason.as_bytes().clone_into(text));
}

/// Makes room for a text of this many bytes.
#[unsafe(no_mangle)]
pub extern "C" fn make_room(length: usize) {
    TEXT.set(vec![0; length]);
}

/// Makes room for this many numbers.
#[unsafe(no_mangle)]
pub extern "C" fn make_numbers(count: usize) {
    NUMBERS.set(vec![0.0; count]);
}

/// The place of a slice in memory: its address times 2^32, plus the number of its elements.
fn place<T>(items: &[T]) -> u64 {
    (items.as_ptr() as u64) << 32 | items.len() as u64
}

/// The place of the text that was left or written last, in UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn text() -> u64 {
    TEXT.with_borrow(|text| place(text))
}

/// The place of the numbers that were left or written last.
#[unsafe(no_mangle)]
pub extern "C" fn numbers() -> u64 {
    NUMBERS.with_borrow(|numbers| place(numbers))
}

/// Starts a run at the time 0 from the recipe that was written as text. Returns its number, or -1 if it is refused.
/// Leaves as text the reason, or warnings about the start values, if any. If the engine panics later, the text is the
/// message.
#[unsafe(no_mangle)]
pub extern "C" fn start() -> i32 {
    std::panic::set_hook(Box::new(|panic| say(&panic.to_string())));
    started().unwrap_or_else(|reason| {
        say(&reason);
        -1
    })
}

fn started() -> Result<i32, String> {
    let recipe = TEXT.with_borrow(|text| Recipe::from_json(text));
    let settings = recipe.and_then(|recipe| recipe.settings()).map_err(|refused| refused.to_string())?;
    if settings.parameters.method != SolverMethod::EventDriven {
        return Err("solver.method is refused; allowed: eventDriven".into());
    }
    let warnings = settings.warnings(Some(Kind::CoSimulation)).join(". ");
    let run = Run::new(settings.parameters, settings.inputs, 0.0).map_err(|error| error.to_string())?;
    say(&warnings);
    Ok(keep(run))
}

/// Leaves as text a recipe with the default of each parameter, with vectors for two balls.
#[unsafe(no_mangle)]
pub extern "C" fn defaults() {
    let (settings, mut recipe) = (Settings::default_for(2), Recipe::new(2));
    for variable in variables(2).filter(|variable| variable.row.causality == Causality::Parameter) {
        let text = variable.text(&settings).unwrap_or_default();
        let value = text.parse().map_or_else(|_| StartValue::Item(text), StartValue::Number);
        recipe.start.insert(variable.to_string(), value);
    }
    say(&recipe.to_json());
}

/// Copies a run with its state. Returns the number of the copy.
#[unsafe(no_mangle)]
pub extern "C" fn copy(run: i32) -> i32 {
    keep(with(run, |run| run.clone()))
}

/// Forgets a run.
#[unsafe(no_mangle)]
pub extern "C" fn forget(run: i32) {
    RUNS.with_borrow_mut(|runs| runs.remove(&run));
}

/// Observes a run during a call of [`advance`].
struct Watch {
    pulses: Vec<Pulse>,
    /// Whether the call ends where balls touch or part, and the time (s) at which they have.
    stops: bool,
    stop: Option<f64>,
}

impl Observer for Watch {
    fn pulse(&mut self, pulse: Pulse) {
        self.onset(pulse.contact, pulse.release);
        self.pulses.push(pulse);
    }

    fn onset(&mut self, _contact: usize, time: f64) {
        self.stop = self.stops.then_some(time);
    }

    fn stop(&self) -> Option<f64> {
        self.stop
    }
}

/// Advances a run to `time` (s), or until `effort` (in units of about a tenth of a microsecond) is spent or, if `stops`
/// is not 0, until balls touch or part. Returns the time reached, or NaN if the run cannot go on; the text is then the
/// reason. Leaves the pulses that have finished, six numbers each: contact (from 0), onset (s), release (s), peak (N),
/// time of the peak (s), impulse (N.s).
#[unsafe(no_mangle)]
pub extern "C" fn advance(run: i32, time: f64, effort: f64, stops: i32) -> f64 {
    let mut watch = Watch { pulses: Vec::new(), stops: stops != 0, stop: None };
    let reached =
        with(run, |Run { engine, .. }| engine.advance_within(time, effort as u64, &mut watch).map(|_| engine.time()));
    let each = |Pulse { contact, onset, release, peak, impulse }: Pulse| {
        [contact as f64, onset, release, peak.force, peak.time, impulse]
    };
    NUMBERS.set(watch.pulses.into_iter().flat_map(each).collect());
    reached.unwrap_or_else(|error| {
        say(&error.to_string());
        f64::NAN
    })
}

/// The time of the next onset (s): infinity if there is none; -t if there is none before t.
#[unsafe(no_mangle)]
pub extern "C" fn next_onset(run: i32) -> f64 {
    match with(run, |run| run.engine.next_onset()) {
        Forecast::At(time) => time,
        Forecast::NotBefore(time) => -time,
        Forecast::Never => f64::INFINITY,
    }
}

/// Leaves the values of a run at its time as numbers: of the whole, of each ball, of each contact, in the order in
/// which `web/page/engine/engine.js` reads them.
#[unsafe(no_mangle)]
pub extern "C" fn look(run: i32) {
    with(run, |Run { engine, .. }| {
        let (engine, balls) = (&*engine, engine.cradle().balls.len());
        let whole = [
            engine.time(),
            engine.total_energy(),
            engine.dissipated_energy(),
            engine.external_work(),
            engine.energy_residual(),
            engine.momentum(),
            engine.support_force(),
            engine.work().events as f64,
        ];
        let of_balls: [fn(&Engine, usize) -> f64; 4] =
            [Chain::x, Chain::v, Chain::kinetic_energy, Chain::gravity_energy];
        let of_contacts: [fn(&Engine, usize) -> f64; 4] =
            [Chain::force, Chain::overlap, Chain::contact_energy, |engine, i| {
                f64::from(u8::from(engine.in_contact(i)))
            }];
        let all = of_balls.map(|of| (of, balls)).into_iter().chain(of_contacts.map(|of| (of, balls - 1)));
        let each = all.flat_map(|(of, count)| (0..count).map(move |i| of(engine, i)));
        NUMBERS.set(whole.into_iter().chain(each).collect());
    })
}
