//! Model exchange on arcs against co-simulation: all positions follow from the first one and the overlaps.

use cradle_host::exchange::rk4;
use cradle_host::fmi3::{self, vr};
use cradle_host::{Host, fmi2OK};
use newtons_cradle::fmi3::fmi3Status::fmi3OK;
use newtons_cradle::fmi3::*;
use proptest::collection::vec;
use proptest::prelude::*;

use super::config;
use super::cradles::decades;

/// The most balls of a row.
const MOST: usize = 4;

/// How long a row is followed at most, and the steps of the host, s.
const LONGEST: f64 = 0.25;
const STEP: f64 = 5e-4;

/// Balls on arcs, at rest, lifted by up to 85 degrees, or touching their left neighbours there.
#[derive(Clone, Debug)]
struct Row {
    radii: Vec<f64>,
    lengths: Vec<f64>,
    gaps: Vec<f64>,
    /// Of all balls or contacts.
    arrays: Vec<(&'static str, Vec<f64>)>,
    scalars: Vec<(&'static str, f64)>,
    items: Vec<(&'static str, u8)>,
}

/// Places in units of the lengths; and directions from one ball to the next.
struct Picture {
    cosines: Vec<f64>,
    /// Parts along the paths of the right balls.
    parts: Vec<f64>,
}

impl Picture {
    fn new(row: &Row, angles: &[f64]) -> Self {
        let parts = (0..row.gaps.len()).map(|j| {
            let [width, height] = row.distances(j, [angles[j], angles[j + 1]]);
            (width * angles[j + 1].cos() + height * angles[j + 1].sin()) / width.hypot(height)
        });
        Self { cosines: angles.iter().map(|angle| angle.cos()).collect(), parts: parts.collect() }
    }

    /// By how much more than the states the places of the last balls may be off, and what follows from them.
    fn amplification(&self) -> f64 {
        let of_parts: f64 = self.parts.iter().map(|part| 1.0 / part.abs()).product();
        of_parts / self.cosines.iter().fold(1.0f64, |least, cos| least.min(*cos)).powi(2)
    }
}

impl Row {
    /// Horizontal and vertical distance of ball `j` and the next one at these angles (rad), m.
    fn distances(&self, j: usize, [left, right]: [f64; 2]) -> [f64; 2] {
        let place = |i: usize, angle: f64| [self.lengths[i] * angle.sin(), self.lengths[i] * (1.0 - angle.cos())];
        let ([x, y], [z, w]) = (place(j, left), place(j + 1, right));
        [self.reach(j) + self.gaps[j] + z - x, w - y]
    }

    /// Sum of the radii of ball `j` and the next one, m.
    fn reach(&self, j: usize) -> f64 {
        self.radii[j] + self.radii[j + 1]
    }

    /// The largest angle (rad) of the ball beside ball `j` at which they overlap by `overlap` (m), if there is one.
    fn beside(&self, j: usize, angle: f64, overlap: f64) -> Option<f64> {
        let apart = |own: f64| {
            let [width, height] = self.distances(j, [angle, own]);
            width.hypot(height) - (self.reach(j) - overlap)
        };
        let mut angles = (0..1700).map(|k| (85.0 - 0.1 * f64::from(k)).to_radians());
        let (mut within, mut beyond) = (angles.find(|own| apart(*own) < 0.0)?, 85f64.to_radians());
        for _ in 0..60 {
            let middle = 0.5 * (within + beyond);
            *if apart(middle) < 0.0 { &mut within } else { &mut beyond } = middle;
        }
        Some(within)
    }

    /// Gives all values to a host of FMI 2.0.
    fn give(&self, host: &Host) {
        let one = |name: &str, value: f64| assert_eq!(host.set(name, value), fmi2OK, "{name} = {value}");
        self.scalars.iter().for_each(|(name, value)| one(name, *value));
        self.items.iter().for_each(|(name, item)| one(name, f64::from(*item)));
        for (name, values) in &self.arrays {
            values.iter().enumerate().for_each(|(i, value)| one(&format!("{name}[{}]", i + 1), *value));
        }
    }

    /// Co-simulation at the start, if it takes this.
    fn stepped(&self) -> Option<Host> {
        let host = Host::with_balls(self.lengths.len());
        self.give(&host);
        assert_eq!([host.set_up(0.0), host.enter()], [fmi2OK; 2]);
        (host.exit() == fmi2OK).then_some(host)
    }

    /// Model exchange by FMI 2.0 and by FMI 3.0 in Initialization Mode.
    fn exchanging(&self) -> (Host, fmi3::Host) {
        let balls = self.lengths.len();
        let (host, other) = (Host::exchanging(balls), fmi3::Host::exchanging());
        self.give(&host);
        assert_eq!([host.set_up(0.0), host.enter()], [fmi2OK; 2]);
        unsafe {
            assert_eq!(fmi3EnterConfigurationMode(other.c), fmi3OK);
            assert_eq!(fmi3SetUInt64(other.c, &vr("n"), 1, &(balls as u64), 1), fmi3OK);
            assert_eq!(fmi3ExitConfigurationMode(other.c), fmi3OK);
            for (name, item) in &self.items {
                assert_eq!(fmi3SetInt64(other.c, &vr(name), 1, &i64::from(*item), 1), fmi3OK, "{name}");
            }
        }
        self.scalars.iter().for_each(|(name, value)| assert_eq!(other.set(name, &[*value]), fmi3OK, "{name}"));
        for (name, values) in &self.arrays {
            let mut values = values.clone();
            values.resize(balls, 0.0);
            assert_eq!(other.set(name, &values), fmi3OK, "{name}: {:?}", other.log());
        }
        assert_eq!(other.enter(), fmi3OK);
        (host, other)
    }
}

fn rows(balls: impl Strategy<Value = usize>) -> impl Strategy<Value = Row> {
    let lengths = prop_oneof![(0.5..2.0).prop_map(|length| vec![length; MOST]), vec(0.5..2.0, MOST)];
    let lifted = prop_oneof![1 => Just(0.0), 2 => -85.0..0.0, 1 => 0.0..85.0].prop_map(f64::to_radians);
    let overlap = prop_oneof![Just(0.0), decades(-8.0, -6.0), decades(-8.0, -6.0).prop_map(|overlap| -overlap)];
    let places = vec((lifted, prop::option::of(overlap)), MOST);
    let or_none = |most: f64| prop_oneof![Just(vec![0.0; MOST]), vec(-most..most, MOST)];
    let spheres = prop_oneof![Just(vec![(1.0, 1.0); MOST]), vec((0.5..2.0, decades(-0.5, 0.5)), MOST)];
    let of_balls = (lengths, vec(0.5..2.0, MOST), vec(0.0..0.01, MOST), places, or_none(1.0), or_none(2.0), spheres);
    let losses = (prop_oneof![Just(0.0), decades(-3.0, 0.0)], prop_oneof![Just(0.0), 0.0..0.5]);
    let balls = (balls, 0.003..0.06, prop_oneof![3 => Just(true), 1 => Just(false)]);
    (balls, of_balls, (1..=2u8, 1..=5u8, 1..=2u8, losses)).prop_map(|((n, radius, side_by_side), of_balls, laws)| {
        let (mut lengths, mut masses, mut gaps, places, mut rates, mut forces, spheres) = of_balls;
        let (radius_ratios, modulus_ratios): (Vec<f64>, Vec<f64>) = spheres[..n].iter().copied().unzip();
        let radii = radius_ratios.iter().map(|ratio| radius * ratio).collect();
        [&mut lengths, &mut masses, &mut rates, &mut forces].into_iter().for_each(|values| values.truncate(n));
        gaps.truncate(n - 1);
        let (model, law, contacts, (loss, drag)) = laws;
        let mut row = Row { radii, lengths, gaps, arrays: vec![], scalars: vec![], items: vec![] };
        let mut angles: Vec<f64> = places[..n].iter().map(|(angle, _)| *angle).collect();
        if side_by_side {
            angles.sort_by(f64::total_cmp);
        }
        for j in 1..n {
            let touching = places[j].1.and_then(|overlap| row.beside(j - 1, angles[j - 1], overlap));
            angles[j] = touching.unwrap_or(angles[j]);
        }
        let of_each = |value: &dyn Fn(usize) -> f64| (0..n).map(value).collect::<Vec<f64>>();
        row.arrays = vec![
            ("x_start", of_each(&|i| row.lengths[i] * angles[i].sin())),
            ("v_start", of_each(&|i| rates[i] * angles[i].cos())),
            ("pendulum.lengthRatio", row.lengths.clone()),
            ("ball.massRatio", masses),
            ("ball.radiusRatio", radius_ratios),
            ("ball.youngModulusRatio", modulus_ratios),
            ("contact.gap", row.gaps.clone()),
            ("F_ext", forces),
        ];
        row.scalars = vec![
            ("ball.radius", radius),
            ("pendulum.length", 1.0),
            ("pendulum.drag", drag),
            ("contact.deadBand", 0.0),
            ("contact.stiffness", 1e7),
            ("contact.damping", 1e3 * loss),
            ("contact.huntCrossley", loss),
            ("contact.relaxationTime", 1e-4 * loss),
            ("contact.restitution", libm::exp(-2.0 * loss)),
        ];
        row.items = vec![
            ("pendulum.model", 2),
            ("contact.model", model),
            ("contact.dampingLaw", law),
            ("exchange.contacts", contacts),
        ];
        row
    })
}

fn close(what: &str, own: &[f64], other: &[f64], allowed: f64) -> Result<(), TestCaseError> {
    for (i, (own, other)) in own.iter().zip(other).enumerate() {
        let off = (own - other).abs();
        prop_assert!(off <= allowed, "{what}[{}] = {own}, not {other}: off by {off:e}, {allowed:e} allowed", i + 1);
    }
    Ok(())
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

/// At the start and, until the first event, on the way: what follows from the states of co-simulation, and where the
/// host gets to from the start.
fn is_that_of_co_simulation(row: &Row) -> Result<(), TestCaseError> {
    let n = row.lengths.len();
    let stepped = row.stepped();
    prop_assume!(stepped.is_some());
    let (Some(stepped), (host, other)) = (stepped, row.exchanging()) else { return Ok(()) };
    let start = Picture::new(row, &stepped.each("angle"));
    // In line with the string of its right neighbour a ball may have any place.
    prop_assume!(start.amplification() < 1e9);
    let accelerations = |host: &Host| (host.each("a"), largest(&host.each("a")).max(10.0) + largest(&host.each("F")));
    let (a, scale) = accelerations(&stepped);
    for name in ["x", "angle", "y", "v", "overlap", "der(overlap)"] {
        close(name, &host.each(name), &stepped.each(name), 4e-14 * start.amplification())?;
    }
    close("F", &host.each("F"), &stepped.each("F"), 1e-13 * scale * start.amplification())?;
    close("a", &host.each("a"), &a, 1e-13 * scale * start.amplification())?;
    for name in ["x", "angle", "y", "v", "a", "E_gravity"] {
        prop_assert_eq!(other.floats(name, n), host.each(name));
    }
    let touching = stepped.each("inContact").contains(&1.0);
    if stepped.step(0.0, STEP) != fmi2OK {
        return Ok(());
    }
    prop_assert_eq!(host.exit(), fmi2OK);
    prop_assert_eq!(unsafe { fmi3ExitInitializationMode(other.c) }, fmi3OK);
    if touching { Ok(()) } else { follow(row, &stepped, &host, &other, &start) }
}

fn follow(row: &Row, stepped: &Host, host: &Host, other: &fmi3::Host, start: &Picture) -> Result<(), TestCaseError> {
    let n = row.lengths.len();
    for k in 1.. {
        let (from, to) = (f64::from(k - 1) * STEP, f64::from(k) * STEP);
        let ends = k > 1 && stepped.step(from, STEP) != fmi2OK || stepped.pulses().iter().any(|pulses| *pulses > 0);
        let picture = Picture::new(row, &stepped.each("angle"));
        let same_side = |(now, first): (&f64, &f64)| now * first.signum() > 0.1;
        let beyond = !picture.parts.iter().zip(&start.parts).all(same_side) || picture.amplification() > 1e6;
        if ends || beyond || to > LONGEST {
            return Ok(());
        }
        if k == 1 {
            host.update();
            prop_assert_eq!(other.update().0, fmi3OK);
            prop_assert_eq!(unsafe { fmi3EnterContinuousTimeMode(other.c) }, fmi3OK);
        }
        host.place(to, &rk4(host, from, to));
        if k % 50 != 1 {
            continue;
        }
        for name in ["x", "overlap", "v"] {
            close(name, &host.each(name), &stepped.each(name), 1e-6 * picture.amplification())?;
        }
        let mut states = vec![stepped.get("x[1]")];
        states.extend(stepped.each("overlap"));
        states.extend(stepped.each("v"));
        states.resize(3 * n + 2, 0.0);
        unsafe {
            prop_assert_eq!(fmi3SetTime(other.c, to), fmi3OK);
            prop_assert_eq!(fmi3SetContinuousStates(other.c, states.as_ptr(), states.len()), fmi3OK);
        }
        for name in ["x", "angle", "y", "a"] {
            let size = largest(&stepped.each(name)).max(1.0);
            close(name, &other.floats(name, n), &stepped.each(name), 1e-13 * size * picture.amplification())?;
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(500))]

    #[test]
    fn exchange_of_random_pairs_on_arcs_is_co_simulation(row in rows(Just(2))) {
        is_that_of_co_simulation(&row)?;
    }
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn exchange_of_random_rows_on_arcs_is_co_simulation(row in rows(3..=MOST)) {
        is_that_of_co_simulation(&row)?;
    }
}
