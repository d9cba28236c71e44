//! Time of the parts of a step: `cargo bench -p articulated`.

use std::sync::Arc;

use articulated::{Body, Contact, Drive, Joint, Link, Mass, Pose, Side, Tree, Workspace, step};
use divan::Bencher;
use nalgebra::{Matrix3, Vector3};

const TIME_STEP: f64 = 0.004;
const RADIUS: f64 = 0.05;

fn main() {
    divan::main();
}

fn mass(mass: f64, moment: f64) -> Mass {
    Mass { mass, centre: Vector3::zeros(), inertia: Matrix3::from_diagonal_element(moment) }
}

/// Builds a base on four wheels with a number of rollers each.
fn base(rollers: usize) -> Body {
    let mut links = vec![Link::new(0, Joint::Free, Vector3::zeros(), mass(20.0, 0.4))];
    for (x, y) in [(0.2, -0.15), (0.2, 0.15), (-0.2, -0.15), (-0.2, 0.15)] {
        let wheel = links.len();
        let hub = Vector3::new(x, y, 0.0);
        links.push(Link::new(0, Joint::Revolute(-Vector3::y()), hub, mass(0.5, 1e-3)));
        for roller in 0..rollers {
            let (sin, cos) = (std::f64::consts::TAU * roller as f64 / rollers as f64).sin_cos();
            let axis = Vector3::new(-sin, 1.0, cos).normalize();
            let place = Vector3::new(cos, 0.0, sin) * 0.036;
            let link = Link::new(wheel, Joint::Revolute(axis), place, mass(0.1, 1e-5));
            links.push(Link { is_round: true, ..link });
        }
    }
    let mut body = Body::new(Arc::new(Tree::new(links)), Pose::translation(0.0, 0.0, -RADIUS));
    body.set_gravity(Vector3::z() * 9.81);
    body
}

/// Returns contacts of the lowest link of every wheel with the ground.
fn contacts(body: &Body, rollers: usize) -> Vec<Contact> {
    let on_ground = |wheel: usize| {
        let link = 1 + wheel * (rollers + 1) + if rollers > 0 { 1 + rollers / 4 } else { 0 };
        let point = body.centre() + body.frames()[1 + wheel * (rollers + 1)].origin + Vector3::z() * RADIUS;
        Contact {
            point,
            normal: -Vector3::z(),
            tangents: [Some(Vector3::x()), Some(Vector3::y())],
            friction: 0.8,
            target: 0.0,
            compliance: [1e-4, 0.0, 0.0],
            first: Side { body: 0, link },
            drift: Vector3::zeros(),
            second: None,
            impulse: Vector3::zeros(),
            memory: Vector3::zeros(),
        }
    };
    (0..4).map(on_ground).collect()
}

/// The update of the pose, and of frames and axes of all links.
#[divan::bench(args = [0, 6])]
fn advance(bencher: Bencher, rollers: usize) {
    let mut body = base(rollers);
    bencher.bench_local(|| body.advance(TIME_STEP));
}

/// The inertia matrix, its factors, and the free velocity.
#[divan::bench(args = [0, 6])]
fn step_in_the_air(bencher: Bencher, rollers: usize) {
    let (mut body, mut workspace) = (base(rollers), Workspace::default());
    bencher.bench_local(|| step(&mut [&mut body], &mut [], &mut [], TIME_STEP, &mut workspace));
}

/// A step with four contacts under servos, warm-started with the last step's impulses.
#[divan::bench(args = [0, 6])]
fn step_on_the_ground(bencher: Bencher, rollers: usize) {
    let (mut body, mut workspace) = (base(rollers), Workspace::default());
    let mut contacts = contacts(&body, rollers);
    bencher.bench_local(|| {
        for wheel in 0..4 {
            let dof = body.tree().dof_of(1 + wheel * (rollers + 1));
            body.set_drive(dof, Drive { at_rest: 50.0, gain: 50.0, most: 1e9 });
        }
        step(&mut [&mut body], &mut contacts, &mut [], TIME_STEP, &mut workspace)
    });
}
