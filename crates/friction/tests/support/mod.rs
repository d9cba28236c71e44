//! Random problems: a body of 1 to 50 kg with contacts anywhere on it, most of them on spinning wheels.

use std::f64::consts::TAU;

use friction::{Constraint, Problem};
use nalgebra::{Matrix3, Unit, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The surfaces that a body touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A floor, with 1 to 4 contacts.
    Wheels,
    /// A floor, with 4 to 12 contacts.
    Floor,
    /// An uneven floor, with normals within 30 degrees of the vertical.
    Uneven,
    /// A floor and walls.
    Walls,
    /// A floor under tyres: tangents that give way, with friction on an ellipse.
    Tyres,
}

impl Kind {
    /// All kinds.
    pub(crate) const ALL: [Self; 5] = [Self::Wheels, Self::Floor, Self::Uneven, Self::Walls, Self::Tyres];

    fn contacts(self) -> std::ops::RangeInclusive<usize> {
        match self {
            Self::Wheels => 1..=4,
            Self::Floor => 4..=12,
            Self::Uneven | Self::Walls | Self::Tyres => 1..=8,
        }
    }

    /// Returns a random contact normal.
    fn normal(self, rng: &mut ChaCha8Rng) -> Vector3<f64> {
        match self {
            Self::Wheels | Self::Floor | Self::Tyres => Vector3::z(),
            Self::Uneven => {
                let (tilt, turn) = (rng.random_range(0.0..0.52_f64), rng.random_range(0.0..TAU));
                Vector3::new(tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos())
            }
            Self::Walls if rng.random_bool(0.6) => Vector3::z(),
            Self::Walls => {
                let turn = rng.random_range(0.0..TAU);
                Vector3::new(turn.cos(), turn.sin(), 0.0)
            }
        }
    }
}

/// Builds a random problem of a kind, with speeds up to 2 m/s and 3 rad/s. Wheels spin at up to 20 rad/s under stiff servos.
pub(crate) fn random(kind: Kind, rng: &mut ChaCha8Rng) -> Problem {
    let count = rng.random_range(kind.contacts());
    let mass: f64 = rng.random_range(1.0..50.0);
    let size = [(); 3].map(|()| rng.random_range(0.1..0.6_f64));
    let [x, y, z] = size.map(|it| it * it * mass / 12.0);
    let inverse_inertia = Matrix3::from_diagonal(&Vector3::new(1.0 / (y + z), 1.0 / (x + z), 1.0 / (x + y)));
    let mut vector = |most: f64| Vector3::from_fn(|_, _| rng.random_range(-most..most));
    let (velocity, turning) = (vector(2.0) - Vector3::z(), vector(3.0));
    let mut rows: Vec<(Vector3<f64>, Vector3<f64>, f64, f64)> = Vec::new();
    let mut constraints = Vec::new();
    for _ in 0..count {
        let normal = kind.normal(rng);
        let position = Vector3::from_fn(|axis, _| {
            let half = size[axis] / 2.0;
            rng.random_range(-half..half)
        }) - Vector3::z() * 0.1;
        let turn = rng.random_range(0.0..TAU);
        let aside = if normal.z.abs() < 0.9 { Vector3::z() } else { Vector3::new(turn.cos(), turn.sin(), 0.0) };
        let first = Unit::new_normalize(normal.cross(&aside)).into_inner();
        let second = normal.cross(&first);
        let wheel = rng.random_bool(0.6);
        let radius = rng.random_range(0.03..0.15_f64);
        let (rim, give) = if wheel {
            let servo = rng.random_range(1e-4..1e-2_f64) + rng.random_range(0.1..100.0_f64) * 0.004;
            (radius * rng.random_range(-20.0..20.0_f64), radius * radius / servo)
        } else {
            (0.0, 0.0)
        };
        let contact = Constraint::Contact {
            friction: rng.random_range(0.05..1.2),
            tangents: if rng.random_bool(0.8) { 2 } else { 1 },
        };
        let mut own = [(normal, 0.0, 0.0), (first, rim, give), (second, 0.0, 0.0)];
        if kind == Kind::Tyres {
            for (axis, target, give) in &mut own[1..] {
                // Friction along a row over that of the pair; compliance of a hard to a very soft tread; its deflection over a step.
                let ratio = rng.random_range(0.3..1.5_f64);
                let soft = 10.0_f64.powf(rng.random_range(-3.0..2.0)) / mass;
                (*axis, *give) = (*axis * ratio, (*give + soft) * ratio * ratio);
                *target = (*target + rng.random_range(-3.0..3.0_f64)) * ratio;
            }
        }
        for (axis, rim, give) in own.into_iter().take(contact.rows()) {
            rows.push((axis, position.cross(&axis), rim, give));
        }
        constraints.push(contact);
    }
    let dot = |a: usize, b: usize| {
        let ((axis, arm, ..), (other, other_arm, ..)) = (&rows[a], &rows[b]);
        axis.dot(other) / mass + arm.dot(&(inverse_inertia * other_arm))
    };
    // A little softness, as a contact's compliance gives: many contacts of one body are nearly equal.
    let softness = 1e-3 / mass;
    let count = rows.len();
    let pairs = (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
    let delassus = pairs.map(|(a, b)| dot(a, b) + if a == b { softness + rows[a].3 } else { 0.0 }).collect();
    let right_side = rows.iter().map(|(axis, arm, rim, _)| rim - axis.dot(&velocity) - arm.dot(&turning)).collect();
    Problem { delassus, right_side, constraints }
}
