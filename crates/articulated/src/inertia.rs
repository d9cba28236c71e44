//! The inertia matrix by composite bodies, and the bias forces of gravity and motion (Featherstone 2008, 6.2 and 5.3).

use nalgebra::{Matrix3, Vector3};

use crate::tree::Rotor;
use crate::{Body, Joint, root};

/// A link with all links below it, about the centre of the root.
#[derive(Debug, Clone, Copy, Default)]
struct Composite {
    mass: f64,
    /// Mass times the position of its centre of mass.
    moment: Vector3<f64>,
    inertia: Matrix3<f64>,
    /// Force that its motion needs with no joint accelerated; then the moment of it.
    force: Vector3<f64>,
    turning: Vector3<f64>,
}

/// Acceleration of a link with no joint accelerated: from rotating velocities, and from gravity as an upward acceleration of the world.
#[derive(Debug, Clone, Copy, Default)]
struct Acceleration {
    angular: Vector3<f64>,
    linear: Vector3<f64>,
}

/// Scratch buffers for the links of one body after the other.
#[derive(Default)]
pub(crate) struct Scratch {
    composites: Vec<Composite>,
    accelerations: Vec<Acceleration>,
}

/// Stores the inertia matrix with implicit servos and dampers in `factors`, and the generalised impulse of a step in `free`.
pub(crate) fn assemble(body: &mut Body, time_step: f64, scratch: &mut Scratch) {
    let Body { tree, frames, axes, velocity, gravity, drives, force, factors, free, .. } = body;
    let Scratch { composites, accelerations } = scratch;
    let of_root = tree.dofs_of_free_root();
    composites.resize(tree.links.len(), Composite::default());
    accelerations.resize(tree.links.len(), Acceleration::default());
    for &(number, ref mass) in &tree.carriers {
        let (link, frame) = (&tree.links[number], &frames[number]);
        let acceleration = if number == 0 {
            let from_centre = frame.angular.cross(&frame.angular.cross(&frame.origin));
            Acceleration { angular: Vector3::zeros(), linear: from_centre - *gravity }
        } else {
            let (parent, above) = (&frames[link.parent], accelerations[link.parent]);
            let arm = frame.origin - parent.origin;
            let speed = || velocity[tree.dofs_of[number].0];
            let axis = || &axes[tree.dofs_of[number].0];
            let linear = above.linear + above.angular.cross(&arm) + parent.angular.cross(&parent.angular.cross(&arm));
            match link.joint {
                Joint::Revolute(_) => {
                    let angular = above.angular + parent.angular.cross(&(axis().angular * speed()));
                    Acceleration { angular, linear }
                }
                Joint::Prismatic(_) => {
                    let sliding = parent.angular.cross(&(axis().linear * speed())) * 2.0;
                    Acceleration { angular: above.angular, linear: linear + sliding }
                }
                // The speeds of a ball joint are along axes that do not turn.
                Joint::Ball | Joint::Belt { .. } | Joint::Free | Joint::Fixed => {
                    Acceleration { angular: above.angular, linear }
                }
            }
        };
        accelerations[number] = acceleration;
        let arm = frame.rotation * mass.centre;
        let at = frame.origin + arm;
        let own = frame.rotation * mass.inertia * frame.rotation.transpose();
        let Acceleration { angular, linear } = acceleration;
        let linear = linear + angular.cross(&arm) + frame.angular.cross(&frame.angular.cross(&arm));
        let force = linear * mass.mass;
        let turning = own * angular + frame.angular.cross(&(own * frame.angular)) + at.cross(&force);
        let moment = at * mass.mass;
        let inertia = own + (Matrix3::identity() * at.norm_squared() - at * at.transpose()) * mass.mass;
        composites[number] = Composite { mass: mass.mass, moment, inertia, force, turning };
    }
    let mut finish = |dof: usize, row: &mut [f64], needed: f64| {
        let of = &tree.dofs[dof];
        let gain = drives[dof].gain + of.damping;
        row[of.depth] += of.armature + gain * time_step;
        free[dof] = (force[dof] + drives[dof].at_rest - gain * velocity[dof] - needed) * time_step;
    };
    for &Rotor { parent, dof, inertia } in &tree.rotors {
        // Its momentum at a speed of 1. It turns with the carrier, which bears the gyroscopic moment.
        let angular = axes[dof].angular * inertia;
        let row = &mut factors[tree.dofs[dof].row..];
        row[..of_root].iter_mut().zip(root::twist(&angular, &Vector3::zeros())).for_each(|(to, of)| *to = of);
        for (to, &above) in row.iter_mut().zip(tree.chain(dof)).skip(of_root) {
            *to = axes[above].angular.dot(&angular);
        }
        finish(dof, row, angular.dot(&accelerations[parent].angular));
        composites[parent].turning += frames[parent].angular.cross(&angular) * velocity[dof];
    }
    for &(number, _) in tree.carriers.iter().rev() {
        let own = composites[number];
        if number == 0 && of_root > 0 {
            let Composite { mass, moment, inertia, force, turning } = own;
            for axis in 0..3 {
                let row = &mut factors[tree.dofs[axis].row..];
                (0..=axis).for_each(|above| row[above] = inertia[(above, axis)]);
                finish(axis, row, turning[axis]);
                let row = &mut factors[tree.dofs[3 + axis].row..];
                let linear = Vector3::ith(axis, mass);
                row[..=3 + axis]
                    .copy_from_slice(&root::twist(&moment.cross(&Vector3::ith(axis, 1.0)), &linear)[..=3 + axis]);
                finish(3 + axis, row, force[axis]);
            }
            break;
        }
        let (first, count) = tree.dofs_of[number];
        for dof in first..first + count {
            let axis = &axes[dof];
            // Momentum of the composite at a speed of 1.
            let linear = axis.linear * own.mass + axis.angular.cross(&own.moment);
            let angular = own.inertia * axis.angular + own.moment.cross(&axis.linear);
            let row = &mut factors[tree.dofs[dof].row..];
            row[..of_root].iter_mut().zip(root::twist(&angular, &linear)).for_each(|(to, of)| *to = of);
            for (to, &above) in row.iter_mut().zip(tree.chain(dof)).skip(of_root) {
                *to = axes[above].angular.dot(&angular) + axes[above].linear.dot(&linear);
            }
            finish(dof, row, axis.angular.dot(&own.turning) + axis.linear.dot(&own.force));
        }
        if number > 0 {
            let parent = &mut composites[tree.links[number].parent];
            parent.mass += own.mass;
            parent.moment += own.moment;
            parent.inertia += own.inertia;
            parent.force += own.force;
            parent.turning += own.turning;
        }
    }
}
