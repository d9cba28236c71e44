//! Surfaces of triangles: their winding, and which of them enclose a volume.
//!
//! The engine holds a body on one side of a triangle, or on both. A closed surface is a solid, so its outside holds. Anything else is a sheet,
//! and both sides hold, however its triangles are wound: files have mirrored, inside-out and carelessly wound ones.

use nalgebra::Vector3;

/// The triangles of a surface as the engine takes them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shell {
    /// Triangles, neighbours wound alike, without those that lie on another.
    pub(super) triangles: Vec<[u32; 3]>,
    /// True if all of it encloses volumes, none of them inside another, and faces outward.
    pub(super) is_solid: bool,
}

/// Winds triangles alike, and says if they enclose volumes. The order of those that stay is kept.
pub(super) fn shell(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Shell {
    let places = places(vertices);
    let mut triangles = distinct(triangles, &places);
    let (parts, is_closed) = wind(&mut triangles, &places);
    let count = parts.iter().max().map_or(0, |most| most + 1);
    let corner = |index: u32| Vector3::from(vertices[index as usize]);
    let (mut volumes, mut boxes) = (vec![0.0; count], vec![[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; count]);
    // Volumes are measured from a corner of the surface, so that far places cost no digits.
    let origin = triangles.first().map_or(Vector3::zeros(), |triangle| corner(triangle[0]));
    for (triangle, &part) in triangles.iter().zip(&parts) {
        let [a, b, c] = triangle.map(|index| corner(index) - origin);
        volumes[part] += a.dot(&b.cross(&c)) / 6.0;
        for point in triangle.map(|index| vertices[index as usize]) {
            let [low, high] = &mut boxes[part];
            for axis in 0..3 {
                (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
            }
        }
    }
    let is_solid = is_closed && count > 0 && volumes.iter().all(|volume| *volume != 0.0) && !is_nested(&boxes);
    if is_solid {
        for (triangle, &part) in triangles.iter_mut().zip(&parts) {
            if volumes[part] < 0.0 {
                triangle.swap(1, 2);
            }
        }
    }
    Shell { triangles, is_solid }
}

/// Numbers the places of corners: corners at one place have one number.
fn places(vertices: &[[f64; 3]]) -> Vec<u32> {
    // Zero has no sign here.
    let key = |vertex: usize| vertices[vertex].map(|part| (part + 0.0).to_bits());
    let mut order: Vec<usize> = (0..vertices.len()).collect();
    order.sort_by_key(|&vertex| key(vertex));
    let mut places = vec![0; vertices.len()];
    let mut last = 0;
    for pair in order.windows(2) {
        last += u32::from(key(pair[0]) != key(pair[1]));
        places[pair[1]] = last;
    }
    places
}

/// Returns the triangles with three corners, each once: some files have every triangle again from behind.
fn distinct(triangles: &[[u32; 3]], places: &[u32]) -> Vec<[u32; 3]> {
    let corners = |triangle: &[u32; 3]| {
        let mut corners = triangle.map(|index| places[index as usize]);
        corners.sort_unstable();
        corners
    };
    let mut order: Vec<([u32; 3], usize)> = triangles.iter().map(corners).zip(0..).collect();
    order.sort_unstable();
    let is_flat = |[a, b, c]: [u32; 3]| a == b || b == c;
    let mut stays: Vec<bool> = vec![false; triangles.len()];
    let mut before = None;
    for (corners, number) in order {
        stays[number] = before.replace(corners) != Some(corners) && !is_flat(corners);
    }
    triangles.iter().zip(stays).filter(|(_, stays)| *stays).map(|(triangle, _)| *triangle).collect()
}

/// Winds neighbours alike: each edge between two triangles is passed in opposite directions. Returns the number of the connected part of each
/// triangle, and true if every edge is between two triangles that could be wound so.
fn wind(triangles: &mut [[u32; 3]], places: &[u32]) -> (Vec<usize>, bool) {
    let ends =
        |triangle: &[u32; 3], side: usize| [side, (side + 1) % 3].map(|corner| places[triangle[corner] as usize]);
    let (neighbours, mut is_closed) = neighbours(triangles, ends);
    let unknown = usize::MAX;
    let (mut parts, mut next, mut open) = (vec![unknown; triangles.len()], 0, Vec::new());
    for first in 0..triangles.len() {
        if parts[first] != unknown {
            continue;
        }
        parts[first] = next;
        open.push(first);
        while let Some(number) = open.pop() {
            for other in neighbours[number].into_iter().flatten() {
                // A neighbour is wound alike if it passes no edge in the same direction.
                let is_alike =
                    (0..3).all(|own| (0..3).all(|side| ends(&triangles[other], side) != ends(&triangles[number], own)));
                if parts[other] == unknown {
                    if !is_alike {
                        triangles[other].swap(1, 2);
                    }
                    parts[other] = next;
                    open.push(other);
                } else {
                    // A Möbius strip cannot be wound alike.
                    is_closed &= is_alike;
                }
            }
        }
        next += 1;
    }
    (parts, is_closed)
}

/// Returns the neighbour of each triangle at each edge that it shares with one other, and true if all edges are such.
fn neighbours(triangles: &[[u32; 3]], ends: impl Fn(&[u32; 3], usize) -> [u32; 2]) -> (Vec<[Option<usize>; 3]>, bool) {
    let sides = triangles.iter().enumerate().flat_map(|(number, triangle)| {
        [0, 1, 2].map(|side| {
            let [a, b] = ends(triangle, side);
            ([a.min(b), a.max(b)], number, side)
        })
    });
    let mut sides: Vec<([u32; 2], usize, usize)> = sides.collect();
    sides.sort_unstable();
    let (mut neighbours, mut is_closed) = (vec![[None; 3]; triangles.len()], true);
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        match edge {
            [(_, one, its), (_, other, own)] => {
                neighbours[*one][*its] = Some(*other);
                neighbours[*other][*own] = Some(*one);
            }
            _ => is_closed = false,
        }
    }
    (neighbours, is_closed)
}

/// True if a box is within another: a room in a building is no solid.
fn is_nested(boxes: &[[[f64; 3]; 2]]) -> bool {
    // By size, so that only larger ones are looked at; beyond this many the surface counts as sheets.
    const MOST: usize = 2000;
    let is_within = |[low, high]: &[[f64; 3]; 2], [least, most]: &[[f64; 3]; 2]| {
        (0..3).all(|axis| least[axis] <= low[axis] && high[axis] <= most[axis])
    };
    boxes.len() > MOST
        || boxes.iter().enumerate().any(|(number, inner)| {
            boxes.iter().enumerate().any(|(other, outer)| other != number && is_within(inner, outer))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of a box and its twelve triangles, seen from outside.
    fn cube(size: f64, first: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let corner = |bits: u32| [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { size } else { 0.0 });
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let split = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        let triangles = faces.into_iter().flat_map(split).map(|it| it.map(|index| index + first));
        ((0..8).map(corner).collect(), triangles.collect())
    }

    fn volume(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
        let corner = |index: u32| Vector3::from(vertices[index as usize]);
        triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0).sum()
    }

    #[test]
    fn a_closed_surface_is_a_solid_however_it_is_wound() {
        let (vertices, good) = cube(2.0, 0);
        assert_eq!(shell(&vertices, &good), Shell { triangles: good.clone(), is_solid: true });
        let turned = |which: fn(usize) -> bool| {
            let mut triangles = good.clone();
            triangles.iter_mut().enumerate().filter(|(number, _)| which(*number)).for_each(|(_, it)| it.swap(1, 2));
            triangles
        };
        for triangles in [turned(|_| true), turned(|number| number % 3 == 0), turned(|number| number == 0)] {
            let made = shell(&vertices, &triangles);
            assert!(made.is_solid);
            assert!((volume(&vertices, &made.triangles) - 8.0).abs() < 1e-12);
        }
        // Every triangle twice, seen from both sides.
        let both = shell(&vertices, &[good.clone(), turned(|_| true)].concat());
        assert_eq!(both, Shell { triangles: good.clone(), is_solid: true });
        // Corners of their own for each triangle.
        let loose: Vec<[f64; 3]> = good.iter().flatten().map(|&index| vertices[index as usize]).collect();
        let own: Vec<[u32; 3]> = (0..12).map(|number| [3 * number, 3 * number + 1, 3 * number + 2]).collect();
        assert!(shell(&loose, &own).is_solid);
    }

    #[test]
    fn sheets_and_rooms_are_held_from_both_sides() {
        let (vertices, good) = cube(2.0, 0);
        assert!(!shell(&vertices, &good[1..]).is_solid, "a hole");
        assert!(!shell(&vertices, &good[..2]).is_solid, "a sheet");
        assert!(!shell(&vertices, &[]).is_solid);
        let (inner, inside) = cube(1.0, 8);
        let moved = inner.iter().map(|corner| corner.map(|part| part + 0.5));
        let room: Vec<[f64; 3]> = vertices.iter().copied().chain(moved).collect();
        assert!(!shell(&room, &[good.clone(), inside.clone()].concat()).is_solid, "a room");
        let beside: Vec<[f64; 3]> =
            vertices.iter().copied().chain(inner.iter().map(|corner| corner.map(|it| it + 5.0))).collect();
        assert!(shell(&beside, &[good, inside].concat()).is_solid, "two boxes");
        // Neighbours in a sheet are wound alike.
        let strip = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(shell(&strip, &[[0, 1, 2], [0, 3, 2]]).triangles, [[0, 1, 2], [0, 2, 3]]);
    }
}
