//! A symmetric matrix with entries only where one degree of freedom is above another, and its factors L'L (Featherstone 2008, 8.4).
//!
//! The matrix is stored by rows. Each row has an entry for every degree of freedom of its chain, from the root down. The chain of a degree
//! of freedom is a prefix of the chains below it, so all inner loops run along slices.

use crate::{Tree, root};

/// Replaces the matrix by its factors. Their diagonal is stored inverted.
pub(crate) fn factorise(tree: &Tree, matrix: &mut [f64]) {
    let of_root = tree.dofs_of_free_root();
    for (number, dof) in tree.dofs.iter().enumerate().skip(of_root).rev() {
        let (above, row) = matrix.split_at_mut(dof.row);
        let row = &mut row[..=dof.depth];
        let inverse = 1.0 / row[dof.depth].sqrt();
        row[dof.depth] = inverse;
        let row = &mut row[..dof.depth];
        row.iter_mut().for_each(|it| *it *= inverse);
        for (depth, &other) in tree.chain(number)[..dof.depth].iter().enumerate().skip(of_root) {
            let factor = row[depth];
            if factor != 0.0 {
                subtract(&mut above[tree.dofs[other].row..][..=depth], factor, &row[..=depth]);
            }
        }
        if of_root > 0 {
            root::subtract_products(above, row);
        }
    }
    if of_root > 0 {
        root::factorise(matrix);
    }
}

/// Subtracts a multiple of numbers from others. As a function of its own it tells the compiler that they do not overlap.
fn subtract(to: &mut [f64], factor: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to -= factor * from);
}

/// Solves for one right-hand side, in place, with L' and then L.
pub(crate) fn solve(tree: &Tree, factors: &[f64], right: &mut [f64]) {
    let of_root = tree.dofs_of_free_root();
    for (number, dof) in tree.dofs.iter().enumerate().skip(of_root).rev() {
        let row = &factors[dof.row..][..=dof.depth];
        right[number] *= row[dof.depth];
        let value = right[number];
        if of_root > 0 {
            root::subtract_row(right.as_chunks_mut::<1>().0, row, &[value]);
        }
        for (&other, factor) in tree.chain(number)[..dof.depth].iter().zip(row).skip(of_root) {
            right[other] -= factor * value;
        }
    }
    if of_root > 0 {
        root::solve_upper::<1, 1>(factors, right.as_chunks_mut().0);
    }
    solve_lower(tree, factors, right);
}

/// Solves for one right-hand side, in place, with L alone.
pub(crate) fn solve_lower(tree: &Tree, factors: &[f64], right: &mut [f64]) {
    let of_root = tree.dofs_of_free_root();
    if of_root > 0 {
        root::solve_lower(factors, right);
    }
    for (number, dof) in tree.dofs.iter().enumerate().skip(of_root) {
        let row = &factors[dof.row..][..=dof.depth];
        let chain = &tree.chain(number)[..dof.depth];
        let mut known = if of_root > 0 { root::dot(row, right) } else { 0.0 };
        for (&other, factor) in chain.iter().zip(row).skip(of_root) {
            known += factor * right[other];
        }
        right[number] = (right[number] - known) * row[dof.depth];
    }
}

/// Solves with L', in place, for right-hand sides with entries only on the chain of one degree of freedom, from the root down. Only the first
/// `SIDES` of them are solved.
pub(crate) fn solve_chain<const SIDES: usize>(tree: &Tree, factors: &[f64], tip: usize, right: &mut [[f64; 3]]) {
    // The chain of a degree of freedom of the root itself does not have all of them.
    let chain = tree.chain(tip);
    let of_root = if chain.len() < root::DOFS { 0 } else { tree.dofs_of_free_root() };
    for (depth, &number) in chain.iter().enumerate().skip(of_root).rev() {
        let row = &factors[tree.dofs[number].row..][..=depth];
        let (above, own) = right.split_at_mut(depth);
        let sides: [f64; SIDES] = std::array::from_fn(|side| own[0][side] * row[depth]);
        own[0][..SIDES].copy_from_slice(&sides);
        if of_root > 0 {
            root::subtract_row(above, row, &sides);
        }
        for (to, factor) in above.iter_mut().zip(row).skip(of_root) {
            (0..SIDES).for_each(|side| to[side] -= factor * sides[side]);
        }
    }
    if of_root > 0 {
        root::solve_upper::<SIDES, 3>(factors, right);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

    use super::*;
    use crate::{Joint, Link, Mass};

    /// Checks factors and solutions of a tree against dense ones: a root with two wheels and an arm of two links.
    fn check(root: Joint) {
        let mass = Mass { mass: 1.0, centre: Vector3::zeros(), inertia: Matrix3::identity() };
        let link = |parent, joint| Link::new(parent, joint, Vector3::zeros(), mass);
        let turning = Joint::Revolute(Vector3::y());
        let links = [link(0, root), link(0, turning), link(0, Joint::Ball), link(0, turning), link(3, turning)];
        let tree = Tree::new(links.to_vec());
        let count = tree.dof_count();
        let (mut sparse, mut dense) = (vec![0.0; tree.entries], DMatrix::zeros(count, count));
        for (number, dof) in tree.dofs.iter().enumerate() {
            for (depth, &other) in tree.chain(number).iter().enumerate() {
                let entry = if number == other { 10.0 } else { (number * 7 + other * 3) as f64 % 5.0 / 5.0 };
                sparse[dof.row + depth] = entry;
                (dense[(number, other)], dense[(other, number)]) = (entry, entry);
            }
        }
        factorise(&tree, &mut sparse);
        let inverse = dense.try_inverse().expect("it is positive definite");
        let right = DVector::from_fn(count, |dof, _| dof as f64 - 2.5);
        let mut got = right.as_slice().to_vec();
        solve(&tree, &sparse, &mut got);
        assert!((DVector::from_vec(got) - &inverse * right).amax() < 1e-12, "{root:?}");
        // With L' alone, the product of a side with itself is its response.
        for tip in 0..count {
            let chain = tree.chain(tip);
            let mut sides: Vec<[f64; 3]> = chain.iter().map(|&dof| [1.0, dof as f64, 0.5]).collect();
            let dense = |side: usize| {
                let mut dense = DVector::zeros(count);
                chain.iter().zip(&sides).for_each(|(&dof, sides)| dense[dof] = sides[side]);
                dense
            };
            let expected = [0, 1, 2].map(|side| dense(side).dot(&(&inverse * dense(side))));
            solve_chain::<3>(&tree, &sparse, tip, &mut sides);
            for (side, expected) in expected.into_iter().enumerate() {
                let got: f64 = sides.iter().map(|sides| sides[side].powi(2)).sum();
                assert!((got - expected).abs() < 1e-12, "{root:?}, {tip}: {got}, expected {expected}");
            }
        }
    }

    #[test]
    fn factors_solve_every_chain() {
        check(Joint::Free);
        check(Joint::Fixed);
    }
}
