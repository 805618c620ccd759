//! Hands: they place balls, and take them along while the others swing on.

use newtons_cradle::model::{Parameters, PendulumModel};

use crate::{NUMBERS, Run, say, with};

/// Mass of a ball in a moving hand, relative to its own: other balls bounce off it as off a wall.
const HAND_MASS: f64 = 1e9;
/// Largest speed of a hand, m/s: balls that it strikes fly off at twice this speed or somewhat more.
const FASTEST_HAND: f64 = 8.0;
/// The largest angle of a swing on an arc, rad: below the 90 degrees to which the engine follows it.
const STEEPEST: f64 = 1.4;
/// The largest angle to which a hand takes a ball, rad: what it lets go can be thrown farther.
const HIGHEST: f64 = 1.2;

/// One pendulum, on an arc or a line.
struct Pendulum {
    /// Length, m.
    length: f64,
    /// Gravity, m/s2.
    gravity: f64,
    on_arc: bool,
}

impl Pendulum {
    fn of(parameters: &Parameters, ball: usize) -> Self {
        let Parameters { gravity, length, length_ratio, pendulum, .. } = parameters;
        let on_arc = *pendulum == PendulumModel::Circular;
        Self { length: length * length_ratio[ball], gravity: *gravity, on_arc }
    }

    /// Angle (rad) at the deflection `x` (m).
    fn angle(&self, x: f64) -> f64 {
        if self.on_arc { libm::asin((x / self.length).clamp(-1.0, 1.0)) } else { x / self.length }
    }

    /// The deflection (m) at this angle (rad).
    fn deflection(&self, angle: f64) -> f64 {
        self.length * if self.on_arc { libm::sin(angle) } else { angle }
    }

    /// The part of its speed that is horizontal, at this angle (rad).
    fn level(&self, angle: f64) -> f64 {
        if self.on_arc { libm::cos(angle) } else { 1.0 }
    }

    /// The largest horizontal speed (m/s) at an angle (rad) with which the ball does not swing beyond [`STEEPEST`].
    /// Infinite on a line.
    fn fastest(&self, angle: f64) -> f64 {
        if !self.on_arc {
            return f64::INFINITY;
        }
        let [half, most] = [angle, STEEPEST].map(|angle| libm::sin(0.5 * angle));
        let room = 4.0 * self.gravity * self.length * (most * most - half * half);
        self.level(angle) * room.max(0.0).sqrt()
    }

    /// The angle (rad) to which the ball swings from this deflection (m) and velocity (m/s), by the energy on an arc,
    /// which is close enough for a line.
    fn swing(&self, x: f64, v: f64) -> f64 {
        let angle = self.angle(x);
        let speed = v / self.level(angle) / (4.0 * self.gravity.max(0.1) * self.length).sqrt();
        2.0 * libm::asin(libm::hypot(libm::sin(0.5 * angle), speed).min(1.0))
    }
}

/// Restarts a run at its time with other motions. The numbers that were written are the positions of the balls (m),
/// their velocities (m/s), and, for balls in a hand, the positions (m) to which it takes them in this many `seconds`,
/// else NaN. Nothing stops balls in a hand. Returns 0, or -1 if it is refused; the text is then the reason.
#[unsafe(no_mangle)]
pub extern "C" fn set_motion(run: i32, seconds: f64) -> i32 {
    let numbers = NUMBERS.take();
    let moved = with(run, |run| {
        let mut parameters = run.parameters.clone();
        let balls = parameters.balls();
        parameters.x_start.copy_from_slice(&numbers[..balls]);
        parameters.v_start.copy_from_slice(&numbers[balls..2 * balls]);
        for (ball, target) in numbers[2 * balls..].iter().enumerate().filter(|(_, target)| !target.is_nan()) {
            let pendulum = Pendulum::of(&parameters, ball);
            let from = pendulum.angle(parameters.x_start[ball]);
            let most = FASTEST_HAND.min(0.25 * pendulum.fastest(0.0));
            let speed = pendulum.length * (pendulum.angle(*target) - from) / seconds;
            parameters.v_start[ball] = pendulum.level(from) * speed.clamp(-most, most);
            parameters.mass_ratio[ball] *= HAND_MASS;
        }
        Run::new(parameters, run.inputs.clone(), run.engine.time()).map(|moved| run.engine = moved.engine)
    });
    match moved {
        Ok(()) => 0,
        Err(error) => {
            say(&error.to_string());
            -1
        }
    }
}

/// The largest horizontal speed (m/s) with which a ball (from 0) may leave the deflection `x` (m).
#[unsafe(no_mangle)]
pub extern "C" fn fastest(run: i32, ball: usize, x: f64) -> f64 {
    with(run, |run| {
        let pendulum = Pendulum::of(&run.parameters, ball);
        pendulum.fastest(pendulum.angle(x))
    })
}

/// The largest deflection (m) to which a hand takes the balls of a run: that of the shortest pendulum.
#[unsafe(no_mangle)]
pub extern "C" fn farthest(run: i32) -> f64 {
    with(run, |Run { parameters, .. }| {
        let farthest = |i| Pendulum::of(parameters, i).deflection(HIGHEST);
        (0..parameters.balls()).map(farthest).fold(f64::INFINITY, f64::min)
    })
}

/// The angle (rad) to which the ball that swings farthest does, from the start of a run.
#[unsafe(no_mangle)]
pub extern "C" fn reach(run: i32) -> f64 {
    with(run, |Run { parameters, .. }| {
        let swing = |i| Pendulum::of(parameters, i).swing(parameters.x_start[i], parameters.v_start[i]);
        (0..parameters.balls()).map(swing).fold(0.0, f64::max)
    })
}
