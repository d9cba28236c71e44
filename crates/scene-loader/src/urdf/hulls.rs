//! Convex hulls with fewer corners, for robots whose meshes have too many together.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use scene::check::MAX_HULL_POINTS;
use scene::{Link, Shape};

/// Thins the hulls with most corners until a robot has no more than it may have. Returns what was thinned, in words.
pub(super) fn thin(links: &mut [Link]) -> Option<String> {
    let counts: Vec<usize> = links.iter().flat_map(|link| &link.solids).map(|solid| corners(&solid.shape)).collect();
    let total: usize = counts.iter().sum();
    let limit = MAX_HULL_POINTS;
    if total <= limit {
        return None;
    }
    let kept = |most: usize| counts.iter().map(|count| count.min(&most)).sum::<usize>();
    let (mut low, mut high) = (1, limit);
    while low < high {
        let middle = (low + high).div_ceil(2);
        if kept(middle) <= limit {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    let mut thinned = Vec::new();
    for link in links {
        for solid in &mut link.solids {
            let before = corners(&solid.shape);
            if let Shape::Hull { points } = &mut solid.shape
                && before > low
            {
                *points = outermost(points, low);
                thinned.push(format!("{} {before} to {}", solid.name, points.len()));
            }
        }
    }
    Some(format!(
        "colliding meshes have {total} corners of hulls, more than {limit}: thinned on links {}",
        names::listed(thinned.iter().map(String::as_str))
    ))
}

fn corners(shape: &Shape) -> usize {
    if let Shape::Hull { points } = shape { points.len() } else { 0 }
}

/// Returns the corners that are outermost in so many directions, which are spread evenly over a sphere (Fibonacci's spiral).
fn outermost(points: &[[f64; 3]], directions: usize) -> Vec<[f64; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let mut kept = BTreeSet::new();
    for number in 0..directions {
        let z = 1.0 - 2.0 * (number as f64 + 0.5) / directions as f64;
        let (sin, cos) = (golden * number as f64).sin_cos();
        let flat = (1.0 - z * z).sqrt();
        let direction = Vector3::new(flat * cos, flat * sin, z);
        let reach = |point: &[f64; 3]| direction.dot(&Vector3::from(*point));
        kept.extend((0..points.len()).max_by(|a, b| reach(&points[*a]).total_cmp(&reach(&points[*b]))));
    }
    kept.into_iter().map(|number| points[number]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_ball_is_still_nearly_round() {
        let ball = |count: usize| outermost_sphere(count);
        let mut link = Link::default();
        let solid = |count| scene::Solid {
            name: "ball".to_owned(),
            shape: Shape::Hull { points: ball(count) },
            position: [0.0; 3],
            rotation: [0.0; 3],
            material: scene::Material::default(),
        };
        link.solids = vec![solid(8000), solid(8000), solid(100)];
        let said = thin(std::slice::from_mut(&mut link)).expect("too many");
        assert!(said.contains("16100 corners of hulls, more than 10000") && said.contains("ball 8000 to"), "{said}");
        let counts: Vec<usize> = link.solids.iter().map(|solid| corners(&solid.shape)).collect();
        assert!(counts.iter().sum::<usize>() <= 10_000 && counts[0] > 3000 && counts[2] == 100, "{counts:?}");
        assert_eq!(thin(std::slice::from_mut(&mut link)), None);
    }

    /// Points on a sphere of radius 1.
    fn outermost_sphere(count: usize) -> Vec<[f64; 3]> {
        let point = |number: usize| {
            let z = 1.0 - 2.0 * (number as f64 + 0.5) / count as f64;
            let (sin, cos) = (2.4 * number as f64).sin_cos();
            let flat = (1.0 - z * z).sqrt();
            [flat * cos, flat * sin, z]
        };
        (0..count).map(point).collect()
    }
}
