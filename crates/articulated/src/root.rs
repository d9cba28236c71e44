//! Arithmetic on the degrees of freedom of a free root: rotations about the world's axes, then translations along them.
//!
//! They are the first of every chain and the first rows of every matrix. Most of a robot's arithmetic is theirs, as its wheels stand side
//! by side below the root. Loops of constant length take a third of the time of loops over slices.

use nalgebra::Vector3;

/// Number of degrees of freedom.
pub(crate) const DOFS: usize = 6;
/// Number of entries of their rows in a matrix, a lower triangle.
const TRIANGLE: usize = DOFS * (DOFS + 1) / 2;

/// Returns the place of an entry in the triangle.
const fn at(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// Reason of a panic: a chain that ends within the root has to be solved row by row.
const SHORT: &str = "a chain has all degrees of freedom of the root";

fn first<T>(row: &[T]) -> &[T; DOFS] {
    row.first_chunk().expect(SHORT)
}

fn first_mut<T>(row: &mut [T]) -> &mut [T; DOFS] {
    row.first_chunk_mut().expect(SHORT)
}

fn triangle(matrix: &[f64]) -> &[f64; TRIANGLE] {
    matrix.first_chunk().expect(SHORT)
}

fn triangle_mut(matrix: &mut [f64]) -> &mut [f64; TRIANGLE] {
    matrix.first_chunk_mut().expect(SHORT)
}

/// Computes the velocity along a direction that each degree of freedom gives a point at a speed of 1. `arm` is the point from the root's
/// centre of mass, m.
#[inline]
pub(crate) fn along(direction: &Vector3<f64>, arm: &Vector3<f64>) -> [f64; DOFS] {
    twist(&arm.cross(direction), direction)
}

/// Returns an angular and a linear part as entries of a row.
#[inline]
pub(crate) fn twist(angular: &Vector3<f64>, linear: &Vector3<f64>) -> [f64; DOFS] {
    [angular.x, angular.y, angular.z, linear.x, linear.y, linear.z]
}

/// Subtracts from a matrix the products of a row's entries.
#[inline]
pub(crate) fn subtract_products(matrix: &mut [f64], row: &[f64]) {
    let (matrix, row) = (triangle_mut(matrix), first(row));
    for one in 0..DOFS {
        for other in 0..=one {
            matrix[at(one, other)] -= row[one] * row[other];
        }
    }
}

/// Replaces a matrix by its factors L'L. Their diagonal is stored inverted.
#[inline]
pub(crate) fn factorise(matrix: &mut [f64]) {
    let matrix = triangle_mut(matrix);
    for number in (0..DOFS).rev() {
        let inverse = 1.0 / matrix[at(number, number)].sqrt();
        matrix[at(number, number)] = inverse;
        (0..number).for_each(|column| matrix[at(number, column)] *= inverse);
        for row in 0..number {
            for column in 0..=row {
                matrix[at(row, column)] -= matrix[at(number, row)] * matrix[at(number, column)];
            }
        }
    }
}

/// Subtracts from right-hand sides a row times the sides' value below it.
#[inline]
pub(crate) fn subtract_row<const SIDES: usize, const WIDTH: usize>(
    right: &mut [[f64; WIDTH]],
    row: &[f64],
    value: &[f64; SIDES],
) {
    let (right, row) = (first_mut(right), first(row));
    for (right, factor) in right.iter_mut().zip(row) {
        (0..SIDES).for_each(|side| right[side] -= factor * value[side]);
    }
}

/// Solves with L', in place, for the first `SIDES` right-hand sides.
#[inline]
pub(crate) fn solve_upper<const SIDES: usize, const WIDTH: usize>(factors: &[f64], right: &mut [[f64; WIDTH]]) {
    let (factors, right) = (triangle(factors), first_mut(right));
    for number in (0..DOFS).rev() {
        (0..SIDES).for_each(|side| right[number][side] *= factors[at(number, number)]);
        for row in 0..number {
            (0..SIDES).for_each(|side| right[row][side] -= factors[at(number, row)] * right[number][side]);
        }
    }
}

/// Solves with L, in place.
#[inline]
pub(crate) fn solve_lower(factors: &[f64], right: &mut [f64]) {
    let (factors, right) = (triangle(factors), first_mut(right));
    for number in 0..DOFS {
        let known = (0..number).fold(0.0, |sum, column| sum + factors[at(number, column)] * right[column]);
        right[number] = (right[number] - known) * factors[at(number, number)];
    }
}

/// Computes the part of a product that is the root's.
#[inline]
pub(crate) fn dot(one: &[f64], other: &[f64]) -> f64 {
    let (one, other) = (first(one), first(other));
    (0..DOFS).fold(0.0, |sum, dof| sum + one[dof] * other[dof])
}
