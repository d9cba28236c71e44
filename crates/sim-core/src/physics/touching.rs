//! Bases whose wheels stand on each other are solved in turn, until what they push on each other agrees.
//!
//! Each base is solved exactly for its own wheels, with the others as they move in this step without its push. So a round
//! over all of them is one of block Gauss-Seidel. Solved only once, with the push of the step before, each robot of a heap
//! answers a load one step late, and a stack of four shakes itself apart.

use super::rigid_base::RigidBase;
use super::traction::Velocity;

/// Most rounds; what has not settled then is taken as it is.
const MAX_ROUNDS: usize = 20;
/// Rounds end when no velocity changes by more than this, m/s.
const TOLERANCE: f64 = 1e-6;

/// A base whose wheels touch another one.
struct Touch {
    upper: usize,
    /// The lower one among what the upper one touches.
    touched: usize,
    lower: usize,
}

/// Solves for bases that have been solved for once, each by itself.
pub(super) fn solve_touching(bases: &mut [&mut RigidBase], time_step: f64) {
    let touches = touches(bases);
    let is_alone = |base: usize| touches.iter().all(|touch| touch.upper != base && touch.lower != base);
    let mut together: Vec<usize> = (0..bases.len()).filter(|&base| !is_alone(base)).collect();
    for _ in 0..MAX_ROUNDS {
        let mut change = 0.0f64;
        for &base in &together {
            for touch in touches.iter().filter(|touch| touch.upper == base) {
                let pushes = pushes(bases, &touches, |peer| peer.lower == touch.lower && peer.upper != base);
                let velocity = sum(bases[touch.lower].solved(), pushes);
                bases[base].set_velocity_of(touch.touched, velocity);
            }
            let pushed = pushes(bases, &touches, |touch| touch.lower == base);
            change = change.max(bases[base].solve_pushed(pushed, time_step));
        }
        if change < TOLERANCE {
            return;
        }
        // There and back, so that none is always the last.
        together.reverse();
    }
}

fn touches(bases: &[&mut RigidBase]) -> Vec<Touch> {
    let mut touches = Vec::new();
    for (upper, base) in bases.iter().enumerate() {
        for (touched, &body) in base.touched().iter().enumerate() {
            let lower = bases.iter().position(|other| other.body() == body);
            touches.extend(lower.map(|lower| Touch { upper, touched, lower }));
        }
    }
    touches
}

/// What some of the touches change of the velocity of the one that is touched.
fn pushes(bases: &[&mut RigidBase], touches: &[Touch], which: impl Fn(&Touch) -> bool) -> Velocity {
    let chosen = touches.iter().filter(|touch| which(touch));
    chosen.map(|touch| bases[touch.upper].change_of(touch.touched)).fold(Velocity::default(), sum)
}

fn sum(a: Velocity, b: Velocity) -> Velocity {
    (a.0 + b.0, a.1 + b.1)
}
