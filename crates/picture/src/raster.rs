//! Rasterizer of triangles with a depth buffer.

use nalgebra::{Point3, Vector3};

use crate::Camera;

/// Distance of the near plane from the eye, m.
const NEAR: f64 = 0.02;

/// Projection of points in the world to pixels.
pub(crate) struct Projection {
    eye: Point3<f64>,
    right: Vector3<f64>,
    down: Vector3<f64>,
    ahead: Vector3<f64>,
    /// Pixels per unit.
    scale: f64,
    middle: [f64; 2],
    is_perspective: bool,
}

impl Projection {
    pub(crate) fn perspective(camera: &Camera, width: usize, height: usize) -> Self {
        let scale = height as f64 / 2.0 / libm::tan(camera.field_of_view / 2.0);
        Self::new(camera.eye, axes(camera.target - camera.eye, camera.down), scale, [width, height], true)
    }

    /// Creates the view of a light that shines from a direction.
    pub(crate) fn parallel(target: Point3<f64>, toward: Vector3<f64>, reach: f64, size: usize) -> Self {
        let eye = target + toward.normalize() * (10.0 * reach);
        Self::new(eye, axes(-toward, Vector3::z()), size as f64 / 2.0 / reach, [size, size], false)
    }

    fn new(
        eye: Point3<f64>,
        [right, down, ahead]: [Vector3<f64>; 3],
        scale: f64,
        size: [usize; 2],
        is_perspective: bool,
    ) -> Self {
        Self { eye, right, down, ahead, scale, middle: size.map(|size| size as f64 / 2.0), is_perspective }
    }

    /// Returns the pixels of a length of 1 m at a distance of 1 m.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Returns a view with its first row farther down.
    pub(crate) fn below(&self, row: usize) -> Self {
        Self { middle: [self.middle[0], self.middle[1] - row as f64], ..*self }
    }

    /// Returns the unit vector from the eye through the middle of a pixel.
    pub(crate) fn ray(&self, x: usize, y: usize) -> Vector3<f64> {
        let [x, y] = [(x, 0), (y, 1)].map(|(pixel, axis)| (pixel as f64 + 0.5 - self.middle[axis]) / self.scale);
        (self.ahead + self.right * x + self.down * y).normalize()
    }

    /// Returns the distance from the eye along a ray to a depth.
    pub(crate) fn distance(&self, depth: f64, ray: &Vector3<f64>) -> f64 {
        depth / ray.dot(&self.ahead)
    }

    /// Returns the coordinates right, down and ahead of the eye, m.
    fn local(&self, place: &Point3<f64>) -> Vector3<f64> {
        let from_eye = place - self.eye;
        Vector3::new(from_eye.dot(&self.right), from_eye.dot(&self.down), from_eye.dot(&self.ahead))
    }

    /// Returns the column, the row, and a value that is linear between pixels: the depth, or its inverse in a perspective.
    fn pixel(&self, local: &Vector3<f64>) -> [f64; 3] {
        let shrink = if self.is_perspective { 1.0 / local.z } else { 1.0 };
        let linear = if self.is_perspective { 1.0 / local.z } else { local.z };
        let [x, y] = [local.x, local.y].map(|part| part * shrink * self.scale);
        [x + self.middle[0], y + self.middle[1], linear]
    }

    /// Returns the column and row of a point in front of the eye.
    pub(crate) fn pixel_of(&self, place: &Point3<f64>) -> Option<[f64; 2]> {
        let local = self.local(place);
        let [x, y, _] = self.pixel(&local);
        (local.z > 0.0).then_some([x, y])
    }

    fn depth(&self, linear: f64) -> f64 {
        if self.is_perspective { 1.0 / linear } else { linear }
    }
}

/// Returns the axes right, down and ahead of an eye that looks in a direction. Straight down, x is up in the picture.
pub(crate) fn axes(ahead: Vector3<f64>, down: Vector3<f64>) -> [Vector3<f64>; 3] {
    let ahead = ahead.normalize();
    let right = down.cross(&ahead).try_normalize(1e-6).unwrap_or_else(Vector3::y);
    [right, ahead.cross(&right), ahead]
}

/// Depth buffer with the nearest triangle of each pixel.
pub(crate) struct Depths {
    width: usize,
    height: usize,
    /// Depth and number of the triangle.
    nearest: Vec<(f64, u32)>,
}

impl Depths {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, height, nearest: vec![(f64::INFINITY, u32::MAX); width * height] }
    }

    /// Returns the depth and the triangle number in a pixel.
    pub(crate) fn at(&self, x: usize, y: usize) -> Option<(f64, usize)> {
        let (depth, index) = self.nearest[y * self.width + x];
        (index != u32::MAX).then_some((depth, index as usize))
    }

    /// Draws a triangle with a number.
    pub(crate) fn add(&mut self, projection: &Projection, corners: &[Point3<f64>; 3], index: usize) {
        let local = corners.map(|corner| projection.local(&corner));
        if !projection.is_perspective || local.iter().all(|corner| corner.z >= NEAR) {
            return self.fill(projection, local.map(|corner| projection.pixel(&corner)), index);
        }
        let polygon = in_front(&local);
        for corner in 2..polygon.len() {
            self.fill(projection, [0, corner - 1, corner].map(|corner| projection.pixel(&polygon[corner])), index);
        }
    }

    /// True if something is nearer to the eye than a point, by more than a margin.
    pub(crate) fn hides(&self, projection: &Projection, place: &Point3<f64>, margin: f64) -> bool {
        let local = projection.local(place);
        let [x, y, _] = projection.pixel(&local);
        let inside = (0.0..self.width as f64).contains(&x) && (0.0..self.height as f64).contains(&y);
        inside && self.nearest[y as usize * self.width + x as usize].0 < local.z - margin
    }

    fn fill(&mut self, projection: &Projection, [a, b, c]: [[f64; 3]; 3], index: usize) {
        let area = edge(&a, &b, &c);
        if area == 0.0 {
            return;
        }
        let range = |axis: usize, size: usize| {
            let [low, high] = [f64::min, f64::max].map(|pick| pick(pick(a[axis], b[axis]), c[axis]));
            (low - 0.5).ceil().max(0.0) as usize..((high - 0.5).floor() + 1.0).clamp(0.0, size as f64) as usize
        };
        let (columns, share) = (range(0, self.width), 1.0 / area);
        // A triangle outside the picture, or between the middles of two pixels.
        if columns.is_empty() {
            return;
        }
        // Each corner's part of a pixel changes by the same from column to column.
        let steps = [(b, c), (c, a), (a, b)].map(|(from, to)| (from[1] - to[1]) * share);
        for y in range(1, self.height) {
            let place = [columns.start as f64 + 0.5, y as f64 + 0.5, 0.0];
            let first = [edge(&b, &c, &place), edge(&c, &a, &place), edge(&a, &b, &place)].map(|part| part * share);
            let row = &mut self.nearest[y * self.width..][columns.clone()];
            for (column, nearest) in row.iter_mut().enumerate() {
                let [in_a, in_b, in_c] = [0, 1, 2].map(|corner| first[corner] + column as f64 * steps[corner]);
                if in_a >= 0.0 && in_b >= 0.0 && in_c >= 0.0 {
                    let depth = projection.depth(in_a * a[2] + in_b * b[2] + in_c * c[2]);
                    if depth < nearest.0 {
                        *nearest = (depth, index as u32);
                    }
                }
            }
        }
    }
}

/// Returns twice the signed area of a triangle.
fn edge(a: &[f64; 3], b: &[f64; 3], c: &[f64; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Clips a triangle to the part in front of the eye, as a polygon.
fn in_front(corners: &[Vector3<f64>; 3]) -> Vec<Vector3<f64>> {
    let mut polygon = Vec::with_capacity(4);
    for index in 0..3 {
        let (from, to) = (corners[index], corners[(index + 1) % 3]);
        if from.z >= NEAR {
            polygon.push(from);
        }
        if (from.z >= NEAR) != (to.z >= NEAR) {
            polygon.push(from + (to - from) * ((NEAR - from.z) / (to.z - from.z)));
        }
    }
    polygon
}
