//! Closed meshes of shapes that a map has no table for. All are about the z axis, z up, and seen from outside.

use crate::map::height_field::Rows;
use crate::mesh::Piece;

/// Corners around, and rings between the poles.
const AROUND: u32 = 24;
const RINGS: u32 = 12;

/// Returns a cylinder between two half balls; `length` is the cylinder's.
pub(crate) fn capsule(radius: f64, length: f64) -> Piece {
    turned((0..=2 * RINGS + 1).map(|ring| {
        // The ring at the equator is there twice: at both ends of the cylinder.
        let (part, end) = if ring <= RINGS { (ring, -0.5) } else { (ring - 1, 0.5) };
        let angle = std::f64::consts::PI * (f64::from(part) / f64::from(2 * RINGS) - 0.5);
        [radius * angle.cos(), end * length + radius * angle.sin()]
    }))
}

/// Returns a cone with its tip up, with its middle at half its length.
pub(crate) fn cone(radius: f64, length: f64) -> Piece {
    turned([[0.0, -length / 2.0], [radius, -length / 2.0], [0.0, length / 2.0]].into_iter())
}

/// Returns an ellipsoid of three radii.
pub(crate) fn ellipsoid(radii: [f64; 3]) -> Piece {
    let mut ball = turned((0..=2 * RINGS).map(|ring| {
        let angle = std::f64::consts::PI * (f64::from(ring) / f64::from(2 * RINGS) - 0.5);
        [angle.cos(), angle.sin()]
    }));
    for vertex in &mut ball.vertices {
        *vertex = std::array::from_fn(|axis| (f64::from(vertex[axis]) * radii[axis]) as f32);
    }
    ball
}

/// Returns ground of a size along x and y, around its middle. The first row of heights is at its left end, +y, and goes towards +x.
pub(crate) fn ground(Rows { columns, heights }: &Rows, size: [f64; 2]) -> Piece {
    let rows = heights.len() / columns;
    let part = |number: usize, count: usize| number as f64 / (count.max(2) - 1) as f64 - 0.5;
    let vertex = |(number, height): (usize, &f64)| {
        let (row, column) = (number / columns, number % columns);
        [size[0] * part(column, *columns), -size[1] * part(row, rows), *height].map(|it| it as f32)
    };
    let cell = |(row, column): (usize, usize)| {
        let corner = |down: usize, right: usize| ((row + down) * columns + column + right) as u32;
        let [near_left, near_right, far_left, far_right] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
        [[near_left, near_right, far_right], [near_left, far_right, far_left]]
    };
    let cells = (1..rows).flat_map(|row| (1..*columns).map(move |column| (row - 1, column - 1)));
    Piece {
        vertices: heights.iter().enumerate().map(vertex).collect(),
        triangles: cells.flat_map(cell).collect(),
        ..Piece::default()
    }
}

/// Turns an outline of radii and heights, from the lowest point on the axis to the highest, about the axis.
fn turned(outline: impl Iterator<Item = [f64; 2]>) -> Piece {
    let outline: Vec<[f64; 2]> = outline.collect();
    let mut piece = Piece::default();
    let inner = outline.get(1..outline.len().saturating_sub(1)).unwrap_or_default();
    let height = |at: Option<&[f64; 2]>| at.map_or(0.0, |[_, height]| *height as f32);
    piece.vertices.push([0.0, 0.0, height(outline.first())]);
    for [radius, height] in inner {
        for corner in 0..AROUND {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(corner) / f64::from(AROUND)).sin_cos();
            piece.vertices.push([radius * cos, radius * sin, *height].map(|part| part as f32));
        }
    }
    piece.vertices.push([0.0, 0.0, height(outline.last())]);
    let rings = inner.len() as u32;
    let (bottom, top) = (0, 1 + rings * AROUND);
    let at = |ring: u32, corner: u32| 1 + ring * AROUND + corner % AROUND;
    for corner in 0..AROUND {
        piece.triangles.push([bottom, at(0, corner + 1), at(0, corner)]);
        piece.triangles.push([at(rings - 1, corner), at(rings - 1, corner + 1), top]);
        for ring in 1..rings {
            let [a, b] = [at(ring - 1, corner), at(ring - 1, corner + 1)];
            let [c, d] = [at(ring, corner), at(ring, corner + 1)];
            piece.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    piece
}

/// Most corners of a polygon: cutting it takes their cube.
const MOST_CORNERS: usize = 100;

/// Returns a prism over a simple polygon, from z = 0 up; `None` if the polygon crosses itself or has no area.
pub(crate) fn prism(polygon: &[[f64; 2]], height: f64) -> Option<Piece> {
    let mut corners = polygon.to_vec();
    if corners.first() == corners.last() {
        corners.pop();
    }
    if !(3..=MOST_CORNERS).contains(&corners.len()) || height <= 0.0 {
        return None;
    }
    let area = |[a, b, c]: [[f64; 2]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let sum: f64 = (1..corners.len() - 1).map(|number| area([corners[0], corners[number], corners[number + 1]])).sum();
    if sum < 0.0 {
        corners.reverse();
    }
    // Ears are cut off until a triangle is left.
    let mut open: Vec<usize> = (0..corners.len()).collect();
    let mut faces = Vec::new();
    while open.len() > 3 {
        let ear = (0..open.len()).find(|&number| {
            let [before, own, after] = [open.len() - 1, 0, 1].map(|step| open[(number + step) % open.len()]);
            let ear = [before, own, after].map(|it| corners[it]);
            let is_inside = |point: &[f64; 2]| (0..3).all(|side| area([ear[side], ear[(side + 1) % 3], *point]) >= 0.0);
            let mut others = open.iter().filter(|it| ![before, own, after].contains(it)).map(|it| &corners[*it]);
            area(ear) > 0.0 && !others.any(is_inside)
        })?;
        let [before, own, after] = [open.len() - 1, 0, 1].map(|step| open[(ear + step) % open.len()]);
        faces.push([before, own, after].map(|it| it as u32));
        open.remove(ear);
    }
    let last = [open[0], open[1], open[2]];
    if area(last.map(|it| corners[it])) <= 0.0 {
        return None;
    }
    faces.push(last.map(|it| it as u32));
    let count = corners.len() as u32;
    let level = |z: f64| corners.iter().map(move |[x, y]| [*x, *y, z].map(|part| part as f32));
    let mut piece = Piece { vertices: level(0.0).chain(level(height)).collect(), ..Piece::default() };
    piece.triangles.extend(faces.iter().map(|[a, b, c]| [*c, *b, *a]));
    piece.triangles.extend(faces.iter().map(|face| face.map(|it| it + count)));
    for corner in 0..count {
        let next = (corner + 1) % count;
        piece.triangles.extend([[corner, next, next + count], [corner, next + count, corner + count]]);
    }
    Some(piece)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    fn volume(piece: &Piece) -> f64 {
        let corner = |index: u32| Vector3::from(piece.vertices[index as usize].map(f64::from));
        piece.triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0).sum()
    }

    #[test]
    fn shapes_have_nearly_their_volumes() {
        let pi = std::f64::consts::PI;
        let cross = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let mut turned = cross;
        turned.reverse();
        for (piece, expected) in [
            (capsule(0.5, 2.0), pi * 0.25 * 2.0 + pi / 6.0),
            (cone(0.5, 3.0), pi * 0.25),
            (ellipsoid([1.0, 0.5, 0.25]), pi * 4.0 / 3.0 * 0.125),
            (prism(&cross, 2.0).expect("a prism"), 6.0),
            (prism(&turned, 2.0).expect("a prism"), 6.0),
        ] {
            let got = volume(&piece);
            assert!((0.96 * expected..=1.0 * expected + 1e-9).contains(&got), "{got} {expected}");
        }
        assert!(prism(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], 1.0).is_none());
        assert!(prism(&[[0.0, 0.0], [1.0, 0.0]], 1.0).is_none());
    }
}
