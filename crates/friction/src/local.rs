//! One contact, solved exactly for the impulses of all others.

use nalgebra::{Matrix3, Vector3};

/// Steps of the search for a compliance.
const MAX_STEPS: usize = 80;

/// The impulses of a contact with a response of its own to the velocity that the others leave missing.
///
/// A contact that needs no push has none. One that can hold without passing its cone holds. Otherwise it slides: with a compliance
/// of its tangents at which the push aside is just what friction can give. The more compliance, the smaller that push against the
/// normal impulse, so there is one such value.
///
/// Tangents that the contact does not have respond to their own impulse alone, and miss nothing. A sliding contact's friction is within
/// `accuracy` times the normal impulse.
pub(crate) fn solve(
    response: &Matrix3<f64>,
    missing: &Vector3<f64>,
    friction: f64,
    tangents: usize,
    accuracy: f64,
) -> Vector3<f64> {
    if missing.x <= 0.0 {
        return Vector3::zeros();
    }
    let normal = response[(0, 0)];
    if friction == 0.0 || tangents == 0 {
        return Vector3::x() * (missing.x / normal);
    }
    // Without the normal, and along the directions in which the tangents do not answer each other.
    let [one, other] = [response[(1, 0)], response[(2, 0)]];
    let block = [
        response[(1, 1)] - one * one / normal,
        response[(2, 1)] - one * other / normal,
        response[(2, 2)] - other * other / normal,
    ];
    let left = [missing.y - one * missing.x / normal, missing.z - other * missing.x / normal];
    let ([first, second], [x, y]) = principal(block);
    let turned = [x * left[0] + y * left[1], x * left[1] - y * left[0]];
    let at = |compliance: f64| {
        let [along, across] = [turned[0] / (first + compliance), turned[1] / (second + compliance)];
        let [one_push, other_push] = [x * along - y * across, y * along + x * across];
        let push = (missing.x - one * one_push - other * other_push) / normal;
        Vector3::new(push, one_push, other_push)
    };
    // How far beyond its cone; one that pulls is.
    let beyond = |push: &Vector3<f64>| (push.y * push.y + push.z * push.z).sqrt() - friction * push.x;
    let held = at(0.0);
    if held.x >= 0.0 && beyond(&held) <= 0.0 {
        return held;
    }
    // Eight times as much until it is within, then between the two by false position, each end kept once at most (Illinois).
    let unit = if tangents == 1 { response[(1, 1)] } else { response[(1, 1)].max(response[(2, 2)]) };
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

/// The principal values of a symmetric matrix of two rows, given by its three entries, and the direction of the first.
fn principal([xx, xy, yy]: [f64; 3]) -> ([f64; 2], [f64; 2]) {
    let (mean, half) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
    let spread = (half * half + xy * xy).sqrt();
    let values = [mean + spread, mean - spread];
    // The longer of two ways to write the same direction.
    let (x, y) = if half > 0.0 { (half + spread, xy) } else { (xy, spread - half) };
    let length = (x * x + y * y).sqrt();
    if length == 0.0 { (values, [1.0, 0.0]) } else { (values, [x / length, y / length]) }
}
