//! The engine in a browser: what the page calls, over the memory that both see.
//!
//! A run is a number. What goes in as text lies in one buffer, that [`text`] makes room in; what comes out as numbers
//! lies where [`look`] and [`pulses`] say, until the next call. The page speaks the language of the FMU: it starts a
//! run from a [`Recipe`], the JSON that an FMU carries in its resources, with the variables' names, units and ranges,
//! and gets the same words when one is refused. Nothing here needs unsafe code: buffers and runs belong to this side.

use std::cell::RefCell;
use std::collections::BTreeMap;

use newtons_cradle::engine::{Engine, Pulse, Results};
use newtons_cradle::model::SolverMethod;
use newtons_cradle::next::Next;
use newtons_cradle::variables::Recipe;

/// A run, the number of its balls, and its pulses that the page has not fetched yet.
struct Run {
    engine: Engine,
    balls: usize,
    pulses: Vec<Pulse>,
}

thread_local! {
    static RUNS: RefCell<BTreeMap<i32, Run>> = RefCell::default();
    static TEXT: RefCell<Vec<u8>> = RefCell::default();
    static NUMBERS: RefCell<Vec<f64>> = RefCell::default();
}

/// What a call answers that was refused; [`text`] then holds the reason.
const REFUSED: i32 = -1;

/// Calls `act` on a run of the page's. It knows only numbers that [`start`] and [`copy`] gave.
fn with<R>(run: i32, act: impl FnOnce(&mut Run) -> R) -> R {
    RUNS.with_borrow_mut(|runs| act(runs.get_mut(&run).expect("the page asks for runs that it was given")))
}

/// Keeps a run: its number, which may be that of a forgotten one.
fn keep(engine: Engine, balls: usize) -> i32 {
    RUNS.with_borrow_mut(|runs| {
        let number = runs.last_key_value().map_or(0, |(last, _)| last + 1);
        runs.insert(number, Run { engine, balls, pulses: Vec::new() });
        number
    })
}

/// Leaves a reason where the page reads it.
fn say(reason: &str) {
    TEXT.with_borrow_mut(|text| reason.as_bytes().clone_into(text));
}

/// Leaves numbers where the page reads them: their address.
fn show(numbers: impl IntoIterator<Item = f64>) -> *const f64 {
    NUMBERS.with_borrow_mut(|shown| {
        shown.clear();
        shown.extend(numbers);
        shown.as_ptr()
    })
}

/// From now on, the reason of a panic is left as text before the engine ends.
#[unsafe(no_mangle)]
pub extern "C" fn prepare() {
    std::panic::set_hook(Box::new(|panic| say(&panic.to_string())));
}

/// Room for a text of this many bytes: where to write it, in UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn text(length: usize) -> *mut u8 {
    TEXT.with_borrow_mut(|text| {
        text.clear();
        text.resize(length, 0);
        text.as_mut_ptr()
    })
}

/// Where the text lies that was left last: see [`text_length`].
#[unsafe(no_mangle)]
pub extern "C" fn text_left() -> *const u8 {
    TEXT.with_borrow(|text| text.as_ptr())
}

/// Its length in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn text_length() -> usize {
    TEXT.with_borrow(Vec::len)
}

/// Starts a run at the time 0 from the recipe that was written as text. -1 if it is refused.
#[unsafe(no_mangle)]
pub extern "C" fn start() -> i32 {
    started().unwrap_or_else(|reason| {
        say(&reason);
        REFUSED
    })
}

fn started() -> Result<i32, String> {
    let recipe = TEXT.with_borrow(|text| Recipe::from_json(text));
    let settings = recipe.and_then(|recipe| recipe.settings()).map_err(|refused| refused.to_string())?;
    if settings.parameters.method != SolverMethod::EventDriven {
        return Err("solver.method is refused; allowed: eventDriven".into());
    }
    let engine = Engine::new(&settings.parameters, &settings.inputs, 0.0).map_err(|error| error.to_string())?;
    Ok(keep(engine, settings.balls()))
}

/// Another run that goes on from where this one is. Its pulses are those that finish from here on.
#[unsafe(no_mangle)]
pub extern "C" fn copy(run: i32) -> i32 {
    let (engine, balls) = with(run, |run| (run.engine.clone(), run.balls));
    keep(engine, balls)
}

/// Forgets a run.
#[unsafe(no_mangle)]
pub extern "C" fn forget(run: i32) {
    RUNS.with_borrow_mut(|runs| runs.remove(&run));
}

/// Moves a run on to `time` (s), or to where `effort` (units of about a tenth of a microsecond) is spent: the time
/// reached. NaN if it cannot go on.
#[unsafe(no_mangle)]
pub extern "C" fn advance(run: i32, time: f64, effort: f64) -> f64 {
    with(run, |Run { engine, pulses, .. }| match engine.advance_within(time, effort as u64, pulses) {
        Ok(_) => engine.time(),
        Err(error) => {
            say(&error.to_string());
            f64::NAN
        }
    })
}

/// The next onset (s): infinity if there is none; negative if there is none before minus this.
#[unsafe(no_mangle)]
pub extern "C" fn next_onset(run: i32) -> f64 {
    match with(run, |run| run.engine.next_onset()) {
        Next::At(time) => time,
        Next::NotBefore(time) => -time,
        Next::Never => f64::INFINITY,
    }
}

/// Where the values of a run at its time lie: those of the whole, of each ball, of each contact, as
/// `web/page/engine/engine.js` reads them.
#[unsafe(no_mangle)]
pub extern "C" fn look(run: i32) -> *const f64 {
    with(run, |&mut Run { ref engine, balls, .. }| {
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
            [Results::x, Results::v, Results::kinetic_energy, Results::gravity_energy];
        let of_contacts: [fn(&Engine, usize) -> f64; 4] =
            [Results::force, Results::overlap, Results::contact_energy, |engine, i| {
                f64::from(u8::from(engine.in_contact(i)))
            }];
        let all = of_balls.map(|of| (of, balls)).into_iter().chain(of_contacts.map(|of| (of, balls - 1)));
        show(whole.into_iter().chain(all.flat_map(|(of, count)| (0..count).map(move |i| of(engine, i)))))
    })
}

/// How many pulses have finished since it was asked last; [`pulses`] says where they lie.
#[unsafe(no_mangle)]
pub extern "C" fn pulse_count(run: i32) -> usize {
    with(run, |run| run.pulses.len())
}

/// Where these pulses lie, five numbers each: contact (from 0), onset (s), release (s), peak (N), impulse (N.s). They
/// are then forgotten.
#[unsafe(no_mangle)]
pub extern "C" fn pulses(run: i32) -> *const f64 {
    with(run, |run| {
        let numbers = |pulse: Pulse| [pulse.contact as f64, pulse.onset, pulse.release, pulse.peak, pulse.impulse];
        show(run.pulses.drain(..).flat_map(numbers))
    })
}
