//! A symmetric matrix with entries only where one degree of freedom is above another, and its factors L'L (Featherstone 2008, 8.4).
//!
//! The matrix is stored by rows. Each row has an entry for every degree of freedom of its chain, from the root down. The chain of a degree
//! of freedom is a prefix of the chains below it, so all inner loops run along slices.

use crate::Tree;

/// Replaces the matrix by its factors. Their diagonal is stored inverted.
pub(crate) fn factorise(tree: &Tree, matrix: &mut [f64]) {
    for (number, dof) in tree.dofs.iter().enumerate().rev() {
        let (above, row) = matrix.split_at_mut(dof.row);
        let row = &mut row[..=dof.depth];
        let inverse = 1.0 / row[dof.depth].sqrt();
        row[dof.depth] = inverse;
        let row = &mut row[..dof.depth];
        row.iter_mut().for_each(|it| *it *= inverse);
        for (depth, &other) in tree.chain(number)[..dof.depth].iter().enumerate() {
            let factor = row[depth];
            if factor != 0.0 {
                subtract(&mut above[tree.dofs[other].row..][..=depth], factor, &row[..=depth]);
            }
        }
    }
}

/// Subtracts a multiple of numbers from others. As a function of its own it tells the compiler that they do not overlap.
fn subtract(to: &mut [f64], factor: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to -= factor * from);
}

/// Solves for one right-hand side, in place, with L' and then L.
pub(crate) fn solve(tree: &Tree, factors: &[f64], right: &mut [f64]) {
    for (number, dof) in tree.dofs.iter().enumerate().rev() {
        let row = &factors[dof.row..][..=dof.depth];
        right[number] *= row[dof.depth];
        let value = right[number];
        for (&other, factor) in tree.chain(number)[..dof.depth].iter().zip(row) {
            right[other] -= factor * value;
        }
    }
    solve_lower(tree, factors, right);
}

/// Solves for one right-hand side, in place, with L alone.
pub(crate) fn solve_lower(tree: &Tree, factors: &[f64], right: &mut [f64]) {
    for (number, dof) in tree.dofs.iter().enumerate() {
        let row = &factors[dof.row..][..=dof.depth];
        let chain = &tree.chain(number)[..dof.depth];
        let known: f64 = chain.iter().zip(row).map(|(&other, factor)| factor * right[other]).sum();
        right[number] = (right[number] - known) * row[dof.depth];
    }
}

/// Solves with L', in place, for right-hand sides with entries only on the chain of one degree of freedom, from the root down. Only the first
/// `SIDES` of them are solved.
pub(crate) fn solve_chain<const SIDES: usize>(tree: &Tree, factors: &[f64], tip: usize, right: &mut [[f64; 3]]) {
    for (depth, &number) in tree.chain(tip).iter().enumerate().rev() {
        let row = &factors[tree.dofs[number].row..][..=depth];
        let (above, own) = right.split_at_mut(depth);
        let sides: [f64; SIDES] = std::array::from_fn(|side| own[0][side] * row[depth]);
        own[0][..SIDES].copy_from_slice(&sides);
        for (to, factor) in above.iter_mut().zip(row) {
            (0..SIDES).for_each(|side| to[side] -= factor * sides[side]);
        }
    }
}
