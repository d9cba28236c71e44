//! Sliding wheels: the twist of a base with prescribed wheel speeds and Coulomb friction.
//!
//! A base that is slow, or light against its friction, moves so that the friction of all its contacts balances: two forces and one
//! moment. Each contact that slips, however little, pushes against its slip with its full friction. It pushes with less only if it
//! does not slip at all. These are the conditions for the minimum of
//!
//! ```text
//! P(twist) = sum over contacts of friction x |slip(twist)|
//! ```
//!
//! the power that friction dissipates. P is convex: there is one solution, whatever the order of the contacts, and a common factor
//! of all frictions does not change it. A skid-steered base on four equal loads at (+-a, +-b), its sides at +-w R, turns with w R b
//! / (a^2 + b^2). Without slip it would turn with w R / b.

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::Twist;

/// Maximum number of Newton steps per smoothing; a handful is usual.
const MAX_STEPS: usize = 100;
/// Start and end of the smoothing of |slip|, as a fraction of the greatest rim speed.
const SMOOTHINGS: [f64; 2] = [1.0, 1e-10];
/// Ratio of each smoothing to the one before.
const NEXT: f64 = 0.1;

/// A contact of a wheel with the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Position forward and to the right in the frame of the base, m.
    pub position: [f64; 2],
    /// Velocity that the base would have here without slip: forward and to the right, m/s. For a plain wheel that points ahead it
    /// is speed x radius, and 0.
    pub rolling: [f64; 2],
    /// Greatest friction: coefficient x load, N.
    pub friction: f64,
    /// Unit vector of the only direction in which it can push: the axis of a free roller. `None` for a plain wheel, which pushes in
    /// all directions.
    pub along: Option<[f64; 2]>,
}

/// Returns the twist at which the friction of all contacts balances. The base does not make a motion that the contacts leave open
/// (none or one; rollers that are all parallel).
pub fn quasi_static(contacts: &[Contact]) -> Twist {
    let size = contacts.iter().flat_map(|it| it.position).fold(0.0, |most: f64, it| most.max(it.abs()));
    let speed = contacts.iter().flat_map(|it| it.rolling).fold(0.0, |most: f64, it| most.max(it.abs()));
    let strongest = contacts.iter().map(|it| it.friction).fold(0.0, f64::max);
    if speed == 0.0 || size == 0.0 || strongest == 0.0 {
        return Twist::default();
    }
    // Dimensionless: rim speeds and distances are about 1.
    let rows: Vec<Row> = contacts.iter().map(|it| Row::new(it, size, speed, strongest)).collect();
    let mut twist = Vector3::zeros();
    let mut smoothing = SMOOTHINGS[0];
    while smoothing > SMOOTHINGS[1] {
        smoothing *= NEXT;
        twist = least(&rows, twist, smoothing);
    }
    Twist { forward: twist.x * speed, right: twist.y * speed, clockwise: twist.z * speed / size }
}

/// Slip of a contact as a linear function of the twist.
struct Row {
    /// Coefficients of the two components of its slip; the second is 0 for a roller.
    of_twist: [Vector3<f64>; 2],
    rolling: Vector2<f64>,
    friction: f64,
}

impl Row {
    fn new(contact: &Contact, size: f64, speed: f64, strongest: f64) -> Self {
        let [x, y] = contact.position.map(|it| it / size);
        let rolling = Vector2::from(contact.rolling) / speed;
        let friction = contact.friction / strongest;
        // These give the velocity at (x, y) of a base that turns clockwise, with z down.
        let [forward, right] = [Vector3::new(1.0, 0.0, -y), Vector3::new(0.0, 1.0, x)];
        let Some([a, b]) = contact.along else { return Self { of_twist: [forward, right], rolling, friction } };
        let of_twist = [forward * a + right * b, Vector3::zeros()];
        Self { of_twist, rolling: Vector2::new(rolling.x * a + rolling.y * b, 0.0), friction }
    }

    fn slip(&self, twist: &Vector3<f64>) -> Vector2<f64> {
        let [first, second] = &self.of_twist;
        Vector2::new(first.dot(twist), second.dot(twist)) - self.rolling
    }
}

/// Returns the length of a vector, rounded as well as can be: near the minimum the search compares sums of lengths that differ in their last
/// bits, and `libm`'s `hypot` is not exact enough. Fused multiplications have the same bits on every platform (Borges, "An improved
/// algorithm for hypot(a, b)", 2019).
fn length(x: f64, y: f64) -> f64 {
    let (x, y) = (x.abs().max(y.abs()), x.abs().min(y.abs()));
    let length = x.mul_add(x, y * y).sqrt();
    if length == 0.0 {
        return 0.0;
    }
    let (square, of_x) = (length * length, x * x);
    let excess = (-y).mul_add(y, square - of_x) + length.mul_add(length, -square) - x.mul_add(x, -of_x);
    length - excess / (2.0 * length)
}

/// Minimises the smoothed power by damped Newton steps from a twist.
fn least(rows: &[Row], mut twist: Vector3<f64>, smoothing: f64) -> Vector3<f64> {
    let smooth = |slip: &Vector2<f64>| length(slip.norm(), smoothing);
    let power = |twist: &Vector3<f64>| rows.iter().map(|row| row.friction * smooth(&row.slip(twist))).sum::<f64>();
    for _ in 0..MAX_STEPS {
        let (mut gradient, mut hessian) = (Vector3::zeros(), Matrix3::identity() * 1e-12);
        for row in rows {
            let slip = row.slip(&twist);
            let (length, [first, second]) = (smooth(&slip), &row.of_twist);
            let along = (first * slip.x + second * slip.y) / length;
            gradient += along * row.friction;
            let across = first * first.transpose() + second * second.transpose() - along * along.transpose();
            hessian += across * (row.friction / length);
        }
        let Some(step) = hessian.cholesky().map(|it| -it.solve(&gradient)) else { break };
        let (before, slope) = (power(&twist), gradient.dot(&step));
        let falls = |share: &f64| power(&(twist + step * *share)) <= before + 1e-4 * share * slope;
        let shares = std::iter::successors(Some(1.0), |share| Some(share / 2.0)).take(60);
        let Some(share) = shares.into_iter().find(falls) else { break };
        twist += step * share;
        if step.norm() * share < 1e-14 {
            break;
        }
    }
    twist
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Mecanum;

    /// Half the wheel base of a P3AT on its four wheels; then half its track and its wheels' radius.
    const A: f64 = 0.124;
    const B: f64 = 0.18;
    const R: f64 = 0.098;

    /// Returns wheels at (+-A, +-B) with loads, the left ones at one speed and the right ones at another, rad/s.
    fn skid(loads: [f64; 4], [left, right]: [f64; 2]) -> Vec<Contact> {
        let wheels = [([A, -B], left), ([A, B], right), ([-A, -B], left), ([-A, B], right)];
        let contact = |((position, speed), friction): (([f64; 2], f64), f64)| Contact {
            position,
            rolling: [speed * R, 0.0],
            friction,
            along: None,
        };
        wheels.into_iter().zip(loads).map(contact).collect()
    }

    #[track_caller]
    fn check(contacts: &[Contact], expected: [f64; 3]) {
        let Twist { forward, right, clockwise } = quasi_static(contacts);
        for (got, expected) in [forward, right, clockwise].into_iter().zip(expected) {
            assert!((got - expected).abs() < 1e-8, "{forward} {right} {clockwise}, expected {expected:?}");
        }
    }

    #[test]
    fn a_skid_robot_on_the_spot_turns_as_its_moments_balance() {
        let turned = R * B / (A * A + B * B);
        assert!((turned - 0.369).abs() < 1e-3, "of a P3AT: {turned}");
        for (friction, speed) in [(1.0, 1.0), (50.0, 1.0), (0.01, 7.0)] {
            check(&skid([friction; 4], [speed, -speed]), [0.0, 0.0, turned * speed]);
        }
    }

    #[test]
    fn wheels_that_agree_do_not_slide() {
        check(&skid([1.0, 2.0, 3.0, 4.0], [2.0, 2.0]), [2.0 * R, 0.0, 0.0]);
        check(&skid([1.0; 4], [0.0, 0.0]), [0.0; 3]);
        check(&[], [0.0; 3]);
        // Two wheels on one axle and a caster turn as if nothing slid.
        let axle = [[0.0, -B], [0.0, B]];
        let speeds = [1.0, -0.5];
        let contacts: Vec<Contact> = axle
            .into_iter()
            .zip(speeds)
            .map(|(position, speed)| Contact { position, rolling: [speed * R, 0.0], friction: 1.0, along: None })
            .collect();
        check(&contacts, [R * 0.25, 0.0, R * 1.5 / (2.0 * B)]);
    }

    #[test]
    fn rollers_that_push_along_their_axes_alone_are_the_textbook() {
        let youbot = Mecanum { wheel_radius: 0.05, half_wheelbase: 0.228, half_track: 0.158 };
        let wheels = [([0.228, -0.158], 1.0), ([0.228, 0.158], -1.0), ([-0.228, -0.158], -1.0), ([-0.228, 0.158], 1.0)];
        // Wheels that contradict each other slide according to their loads, which the textbook ignores.
        for speeds in [[1.0; 4], [1.0, -1.0, -1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [2.0, 0.5, 1.0, -0.5]] {
            let contact = |((position, side), speed): (([f64; 2], f64), f64)| {
                let along = Some([std::f64::consts::FRAC_1_SQRT_2, side * std::f64::consts::FRAC_1_SQRT_2]);
                Contact { position, rolling: [speed * 0.05, 0.0], friction: 1.0, along }
            };
            let contacts: Vec<Contact> = wheels.into_iter().zip(speeds).map(contact).collect();
            let Twist { forward, right, clockwise } = youbot.forward(speeds);
            check(&contacts, [forward, right, clockwise]);
        }
    }

    fn contact() -> impl Strategy<Value = Contact> {
        let position = [-0.5..0.5, -0.5..0.5];
        (position, -1.0..1.0, 0.1..10.0).prop_map(|(position, speed, friction)| Contact {
            position,
            rolling: [speed, 0.0],
            friction,
            along: None,
        })
    }

    proptest! {
        /// Sliding contacts push with their full friction. The contacts that hold can balance the rest within theirs.
        #[test]
        fn forces_and_moment_balance(contacts in proptest::collection::vec(contact(), 2..9)) {
            let Twist { forward, right, clockwise } = quasi_static(&contacts);
            let (mut rest, mut held) = ([0.0; 3], 0.0);
            for Contact { position: [x, y], rolling, friction, .. } in &contacts {
                let slip = [forward - clockwise * y - rolling[0], right + clockwise * x - rolling[1]];
                let size = slip[0].hypot(slip[1]);
                if size < 1e-6 {
                    held += friction;
                    continue;
                }
                let [f, r] = slip.map(|part| friction * part / size);
                rest[0] += f;
                rest[1] += r;
                rest[2] += x * r - y * f;
            }
            prop_assert!(rest[0].hypot(rest[1]) <= held + 1e-3, "{rest:?}, {held} hold");
            prop_assert!(rest[2].abs() <= 0.75 * held + 1e-3, "{rest:?}, {held} hold");
        }

        /// Scaling speeds scales the twist; scaling friction changes nothing.
        #[test]
        fn it_has_no_scale(contacts in proptest::collection::vec(contact(), 2..9), speed in 0.01..100.0_f64, grip in 0.01..100.0_f64) {
            let scaled = |it: &Contact| Contact { rolling: it.rolling.map(|it| it * speed), friction: it.friction * grip, ..*it };
            let other = quasi_static(&contacts.iter().map(scaled).collect::<Vec<_>>());
            let one = quasi_static(&contacts);
            for (a, b) in [(one.forward, other.forward), (one.right, other.right), (one.clockwise, other.clockwise)] {
                prop_assert!((a * speed - b).abs() < 1e-5 * speed, "{one:?} {other:?}");
            }
        }
    }
}
