//! Simplification of meshes for drawing: corners that share a grid cell are merged.

use std::collections::{HashMap, HashSet};
use std::hash::Hash;

use scene::Shape;

/// Fewest cells along the longest edge of a mesh; a box keeps its corners with two.
const FEWEST_CELLS: f64 = 2.0;
/// Maximum number of grids tried for a mesh.
const MAX_TRIES: usize = 8;

/// Returns the size of a shape for drawing: its triangles, or its corners if a file repeats them.
pub(crate) fn size(shape: &Shape) -> usize {
    if let Shape::Mesh { vertices, triangles } = shape { triangles.len().max(vertices.len()) } else { 0 }
}

/// Returns a mesh of at most `most` triangles and corners, or the few that the coarsest grid leaves. Other shapes stay unchanged.
pub(crate) fn simplified(shape: Shape, most: usize) -> Shape {
    let Shape::Mesh { vertices, triangles } = shape else { return shape };
    let fits = |shape: &Shape| size(shape) <= most;
    let bits = |vertex: &[f64; 3]| vertex.map(f64::to_bits);
    let mut best = clustered(&vertices, &triangles, bits);
    if fits(&best) {
        return best;
    }
    let (low, high) = bounds(&vertices);
    let edge = [0, 1, 2].map(|axis| high[axis] - low[axis]).into_iter().fold(f64::MIN_POSITIVE, f64::max);
    // A surface of a square metre has n² cells of an edge of 1/n m, and two triangles for each.
    let mut cells = (most as f64).sqrt().max(FEWEST_CELLS);
    for _ in 0..MAX_TRIES {
        let last = cells.ceil() - 1.0;
        let place = |vertex: &[f64; 3]| {
            [0, 1, 2].map(|axis| ((vertex[axis] - low[axis]) / edge * cells).floor().clamp(0.0, last) as u32)
        };
        best = clustered(&vertices, &triangles, place);
        if fits(&best) || cells <= FEWEST_CELLS {
            break;
        }
        cells = (0.95 * cells * (most as f64 / size(&best) as f64).sqrt()).max(FEWEST_CELLS);
    }
    let octant = |vertex: &[f64; 3]| [0, 1, 2].map(|axis| vertex[axis] - low[axis] > high[axis] - vertex[axis]);
    if fits(&best) { best } else { clustered(&vertices, &triangles, octant) }
}

/// Returns the lowest and highest coordinates of points.
fn bounds(points: &[[f64; 3]]) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
    for point in points {
        low = [0, 1, 2].map(|axis| low[axis].min(point[axis]));
        high = [0, 1, 2].map(|axis| high[axis].max(point[axis]));
    }
    (low, high)
}

/// Merges the corners of each cell into the outermost one, so that an outline does not shrink. Leaves out triangles that become
/// lines, and repeated triangles.
fn clustered<C: Eq + Hash>(vertices: &[[f64; 3]], triangles: &[[u32; 3]], cell: impl Fn(&[f64; 3]) -> C) -> Shape {
    let (low, high) = bounds(vertices);
    let distance =
        |vertex: &[f64; 3]| (0..3).map(|axis| (vertex[axis] - (low[axis] + high[axis]) / 2.0).powi(2)).sum::<f64>();
    let (mut cells, mut kept): (HashMap<C, u32>, Vec<[f64; 3]>) = (HashMap::new(), Vec::new());
    let mut number_of = |index: u32| -> Option<u32> {
        let vertex = vertices.get(index as usize)?;
        let number = *cells.entry(cell(vertex)).or_insert(kept.len() as u32);
        match kept.get_mut(number as usize) {
            None => kept.push(*vertex),
            Some(old) if distance(vertex) > distance(old) => *old = *vertex,
            Some(_) => {}
        }
        Some(number)
    };
    let mut seen = HashSet::new();
    let mut left = Vec::new();
    for &[a, b, c] in triangles {
        let (Some(a), Some(b), Some(c)) = (number_of(a), number_of(b), number_of(c)) else { continue };
        // Rotating the least corner to the front keeps the orientation, so the two sides of a plate stay two.
        let turned = if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        };
        if a != b && b != c && c != a && seen.insert(turned) {
            left.push([a, b, c]);
        }
    }
    Shape::Mesh { vertices: kept, triangles: left }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a ball with this number of rings. Each triangle has corners of its own, as in COLLADA.
    fn ball(rings: u32) -> Shape {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        let corner = |ring: u32, part: u32| {
            let [theta, phi] = [ring, 2 * part].map(|it| f64::from(it) / f64::from(rings) * std::f64::consts::PI);
            [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
        };
        for ring in 0..rings {
            for part in 0..rings {
                for corners in [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]] {
                    let first = vertices.len() as u32;
                    vertices.extend(corners.map(|(r, p)| corner(ring + r, (part + p) % rings)));
                    triangles.push([first, first + 1, first + 2]);
                }
            }
        }
        Shape::Mesh { vertices, triangles }
    }

    #[test]
    fn a_simplified_mesh_is_as_large_as_asked_and_keeps_its_outline() {
        for (rings, most) in [(100, 10_000), (100, 2_000), (100, 500), (40, 100), (40, 24), (4, 24)] {
            let made = simplified(ball(rings), most);
            let Shape::Mesh { vertices, triangles } = &made else { panic!("{made:?}") };
            assert!(
                size(&made) <= most.max(56) && triangles.len() >= most.min(56) / 8,
                "{rings} {most}: {}",
                size(&made)
            );
            assert!(triangles.iter().flatten().all(|&index| (index as usize) < vertices.len()));
            let (low, high) = bounds(vertices);
            let is_wide = (0..3).all(|axis| high[axis] - low[axis] > 0.7);
            assert!(is_wide && vertices.iter().flatten().all(|it| it.abs() < 1.01), "{rings} {most}: {low:?} {high:?}");
        }
    }

    #[test]
    fn repeated_corners_alone_are_merged_where_that_is_enough() {
        let repeated = ball(20);
        let made = simplified(repeated.clone(), 800);
        assert_eq!(size(&repeated), 2400);
        let Shape::Mesh { vertices, triangles } = made else { panic!("a mesh") };
        // At a pole a triangle of each pair is a line.
        assert!(
            (760..800).contains(&triangles.len()) && vertices.len() < 420,
            "{} {}",
            triangles.len(),
            vertices.len()
        );
    }

    #[test]
    fn odd_meshes_are_simplified_without_end_or_panic() {
        for (vertices, triangles) in [
            (vec![], vec![]),
            (vec![[0.0; 3]], vec![[0, 0, 0]; 100]),
            (vec![[1e-300; 3], [0.0; 3], [1e300, 0.0, 0.0]], vec![[0, 1, 2]; 100]),
            (vec![[0.0; 3]; 100], vec![[7, 8, 9]]),
            (vec![[0.0; 3]], vec![[0, 1, 2]]),
            (vec![[f64::NAN; 3]; 100], vec![[7, 8, 9]]),
        ] {
            assert!(size(&simplified(Shape::Mesh { vertices, triangles }, 1)) <= 56);
        }
    }
}
