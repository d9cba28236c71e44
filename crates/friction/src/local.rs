//! Exact solution of one contact for the impulses of all others.

use nalgebra::{Matrix3, Vector3};

/// Most steps of the search for a compliance.
const MAX_STEPS: usize = 80;
/// Least share of the normal's own response that must remain when friction helps the normal impulse to push.
const LEAST_SHARE: f64 = 0.1;

/// Solves one contact: `delassus` is its block of the Delassus matrix, and `right_side` its right-hand side with the impulses of the others.
///
/// A contact that needs no push gets none. A contact that can hold within its friction cone holds. Otherwise it slides. Sliding is modelled
/// by a compliance of the tangents at which the tangent impulse equals the limit of friction. That impulse falls with the compliance
/// relative to the normal impulse, so there is one such value.
///
/// Tangents that the contact does not have need a unit response of their own and no right-hand side. A sliding contact's friction is within
/// `accuracy` times the normal impulse.
pub(crate) fn solve(
    delassus: &Matrix3<f64>,
    right_side: &Vector3<f64>,
    friction: f64,
    tangents: usize,
    accuracy: f64,
) -> Vector3<f64> {
    if right_side.x <= 0.0 {
        return Vector3::zeros();
    }
    let normal = delassus[(0, 0)];
    if friction == 0.0 || tangents == 0 {
        return Vector3::x() * (right_side.x / normal);
    }
    // Eliminate the normal, and turn the tangents to the directions that do not couple.
    let [one, other] = [delassus[(1, 0)], delassus[(2, 0)]];
    let (block, left) = tangents_alone(delassus, right_side);
    let ([first, second], [x, y]) = principal(block);
    let turned = [x * left[0] + y * left[1], x * left[1] - y * left[0]];
    let at = |compliance: f64| {
        let [along, across] = [turned[0] / (first + compliance), turned[1] / (second + compliance)];
        let [one_push, other_push] = [x * along - y * across, y * along + x * across];
        let push = (right_side.x - one * one_push - other * other_push) / normal;
        Vector3::new(push, one_push, other_push)
    };
    // Distance beyond the friction cone. A pulling contact is beyond it.
    let beyond = |push: &Vector3<f64>| (push.y * push.y + push.z * push.z).sqrt() - friction * push.x;
    let held = at(0.0);
    if held.x >= 0.0 && beyond(&held) <= 0.0 {
        return held;
    }
    if tangents == 1 {
        // It slides one way or the other, against its slip.
        let friction = friction.copysign(left[0]);
        let push = right_side.x / (normal + friction * one);
        return Vector3::new(push, friction * push, 0.0);
    }
    // Bracket the compliance by factors of eight, then narrow it by false position, keeping each end at most once (Illinois).
    let unit = delassus[(1, 1)].max(delassus[(2, 2)]);
    let (mut least, mut most) = (0.0, unit);
    let (mut off_least, mut push) = (beyond(&held), at(most));
    let mut off_most = beyond(&push);
    while off_most > 0.0 && most < 1e12 * unit {
        (least, off_least) = (most, off_most);
        most *= 8.0;
        push = at(most);
        off_most = beyond(&push);
    }
    for _ in 0..MAX_STEPS {
        if off_most.abs() <= accuracy * push.x.abs() || most - least <= 1e-15 * most {
            break;
        }
        let middle = least + (most - least) * (off_least / (off_least - off_most)).clamp(0.01, 0.99);
        push = at(middle);
        let off = beyond(&push);
        if off.abs() <= accuracy * push.x.abs() {
            break;
        }
        if off > 0.0 {
            (least, off_least) = (middle, off);
            off_most /= 2.0;
        } else {
            (most, off_most) = (middle, off);
            off_least /= 2.0;
        }
    }
    push
}

/// Eliminates the normal. Returns the response of the tangents (first, coupling, second) and their right-hand side.
fn tangents_alone(delassus: &Matrix3<f64>, right_side: &Vector3<f64>) -> ([f64; 3], [f64; 2]) {
    let [normal, one, other] = [delassus[(0, 0)], delassus[(1, 0)], delassus[(2, 0)]];
    let block = [
        delassus[(1, 1)] - one * one / normal,
        delassus[(2, 1)] - one * other / normal,
        delassus[(2, 2)] - other * other / normal,
    ];
    (block, [right_side.y - one * right_side.x / normal, right_side.z - other * right_side.x / normal])
}

/// Solves a contact that holds, or slides along the direction of `holding`. It takes a few products instead of the search of [`solve`],
/// whose other arguments it shares. If friction along that direction would lift the contact, it falls back to [`solve`].
pub(crate) fn approach(
    delassus: &Matrix3<f64>,
    right_side: &Vector3<f64>,
    friction: f64,
    tangents: usize,
    holding: [f64; 2],
    accuracy: f64,
) -> Vector3<f64> {
    if right_side.x <= 0.0 {
        return Vector3::zeros();
    }
    let normal = delassus[(0, 0)];
    if friction == 0.0 || tangents == 0 {
        return Vector3::x() * (right_side.x / normal);
    }
    let [one, other] = [delassus[(1, 0)], delassus[(2, 0)]];
    let ([first, both, second], left) = tangents_alone(delassus, right_side);
    let determinant = first * second - both * both;
    let [along, across] =
        [(second * left[0] - both * left[1]) / determinant, (first * left[1] - both * left[0]) / determinant];
    let push = (right_side.x - one * along - other * across) / normal;
    let length = (holding[0] * holding[0] + holding[1] * holding[1]).sqrt();
    if push >= 0.0 && along * along + across * across <= (friction * push).powi(2) {
        return Vector3::new(push, along, across);
    }
    let share = normal + friction * (one * holding[0] + other * holding[1]) / length;
    if share > LEAST_SHARE * normal {
        let push = right_side.x / share;
        return Vector3::new(push, friction * push * holding[0] / length, friction * push * holding[1] / length);
    }
    solve(delassus, right_side, friction, tangents, accuracy)
}

/// Returns the principal values of a symmetric 2 x 2 matrix, given by its three entries, and the direction of the first.
fn principal([xx, xy, yy]: [f64; 3]) -> ([f64; 2], [f64; 2]) {
    let (mean, half) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
    let spread = (half * half + xy * xy).sqrt();
    let values = [mean + spread, mean - spread];
    // Two expressions give this direction. The longer one is more accurate.
    let (x, y) = if half > 0.0 { (half + spread, xy) } else { (xy, spread - half) };
    let length = (x * x + y * y).sqrt();
    if length == 0.0 { (values, [1.0, 0.0]) } else { (values, [x / length, y / length]) }
}
