//! Bodies with analytic solutions of their motion.

use std::sync::Arc;

use articulated::{Body, Contact, Drive, Joint, JointRow, Link, Mass, Pose, Side, Tree, Workspace, step};
use friction::Constraint;
use nalgebra::{Matrix3, Vector3};

const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, 9.81);

fn mass(mass: f64, moments: [f64; 3]) -> Mass {
    Mass { mass, centre: Vector3::zeros(), inertia: Matrix3::from_diagonal(&moments.into()) }
}

fn run(body: &mut Body, time_step: f64, seconds: f64) {
    for _ in 0..(seconds / time_step).round() as usize {
        step(&mut [&mut *body], &mut [], &mut [], time_step, &mut Workspace::default());
        body.advance(time_step);
    }
}

/// Creates a tree with each kind of joint, in motion.
fn flying() -> Body {
    let mut chassis = mass(5.0, [0.1, 0.2, 0.25]);
    chassis.centre = Vector3::new(0.02, -0.01, 0.03);
    let mut arm = mass(1.0, [0.01, 0.02, 0.02]);
    arm.centre = Vector3::new(0.1, 0.0, 0.05);
    let tree = Tree::new(vec![
        Link::new(0, Joint::Free, Vector3::zeros(), chassis),
        Link::new(0, Joint::Revolute(Vector3::y()), Vector3::new(0.2, 0.0, 0.0), arm),
        Link::new(1, Joint::Revolute(Vector3::x()), Vector3::new(0.2, 0.0, 0.0), arm),
        Link::new(1, Joint::Prismatic(Vector3::z()), Vector3::new(0.0, 0.1, 0.0), arm),
        Link::new(0, Joint::Ball, Vector3::new(-0.2, 0.0, 0.0), arm),
    ]);
    let mut body = Body::new(Arc::new(tree), Pose::translation(1.0, 2.0, 3.0));
    let speeds = [0.3, -0.5, 0.7, 1.0, -2.0, 0.5, 1.5, -2.0, 0.3, 0.4, -0.6, 0.8];
    body.velocity_mut().copy_from_slice(&speeds);
    body.place();
    body
}

/// Returns the momentum and the angular momentum.
fn momentum(body: &Body) -> (Vector3<f64>, Vector3<f64>) {
    let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
    for (link, frame) in body.tree().links().iter().zip(body.frames()) {
        let arm = frame.rotation * link.mass.centre;
        let along = (frame.linear + frame.angular.cross(&arm)) * link.mass.mass;
        linear += along;
        angular += (body.centre() + frame.origin + arm).cross(&along);
        angular += frame.rotation * link.mass.inertia * (frame.rotation.transpose() * frame.angular);
    }
    (linear, angular)
}

/// The energy about the centre of mass falls with the square of the share.
#[test]
fn scaled_motion_keeps_its_momentum_and_loses_energy() {
    let mut body = flying();
    let mass: f64 = body.tree().links().iter().map(|link| link.mass.mass).sum();
    let (energy, (linear, _)) = (body.kinetic_energy(), momentum(&body));
    let of_centre = linear.norm_squared() / mass / 2.0;
    body.scale_motion(0.5);
    let expected = of_centre + (energy - of_centre) / 4.0;
    assert!((momentum(&body).0 - linear).norm() < 1e-12, "{linear} became {}", momentum(&body).0);
    assert!((body.kinetic_energy() - expected).abs() < 1e-12 * energy, "{energy} became {}", body.kinetic_energy());
}

/// A body in free flight has no external force, so its momentum is constant. With small steps its energy is, too.
#[test]
fn a_tree_in_flight_keeps_momentum_and_energy() {
    let mut body = flying();
    let (energy, (linear, angular)) = (body.kinetic_energy(), momentum(&body));
    run(&mut body, 1e-5, 0.5);
    let (linear_after, angular_after) = momentum(&body);
    assert!((linear_after - linear).norm() < 1e-3 * linear.norm(), "{linear} became {linear_after}");
    assert!((angular_after - angular).norm() < 1e-3 * angular.norm(), "{angular} became {angular_after}");
    assert!((body.kinetic_energy() / energy - 1.0).abs() < 1e-3, "{energy} became {}", body.kinetic_energy());
    assert!((body.position(1) - 0.75).abs() > 1e-3, "the joints are not alone in the world");
}

/// A wheel that is marked as round moves as one that is computed as any other link.
#[test]
fn a_round_wheel_moves_as_any_other_link() {
    let run = |is_round: bool| {
        let mut chassis = mass(5.0, [0.1, 0.2, 0.25]);
        chassis.centre = Vector3::new(0.02, -0.01, 0.03);
        let axis = Vector3::new(0.0, 0.6, 0.8);
        let round = Matrix3::identity() * 0.02 + axis * axis.transpose() * 0.03;
        let wheel = Mass { mass: 1.0, centre: Vector3::zeros(), inertia: round };
        let mut wheel = Link::new(1, Joint::Revolute(axis), Vector3::new(0.1, 0.2, 0.3), wheel);
        wheel.is_round = is_round;
        wheel.damping = 0.01;
        let arm =
            Link::new(0, Joint::Revolute(Vector3::x()), Vector3::new(0.2, 0.0, 0.1), mass(1.0, [0.01, 0.02, 0.02]));
        let mut other = Link { parent: 0, anchor: Vector3::new(-0.3, 0.0, 0.1), ..wheel.clone() };
        other.armature = 0.01;
        let tree = Tree::new(vec![Link::new(0, Joint::Free, Vector3::zeros(), chassis), arm, wheel, other]);
        let mut body = Body::new(Arc::new(tree), Pose::translation(1.0, 2.0, 3.0));
        body.velocity_mut().copy_from_slice(&[0.3, -0.5, 0.7, 1.0, -2.0, 0.5, 1.5, -20.0, 30.0]);
        body.place();
        for _ in 0..500 {
            body.set_gravity(GRAVITY);
            body.set_drive(7, Drive { at_rest: 0.5, gain: 0.1, most: 1.0 });
            step(&mut [&mut body], &mut [], &mut [], 0.002, &mut Workspace::default());
            body.advance(0.002);
        }
        body.velocity().to_vec()
    };
    for (number, (round, other)) in run(true).into_iter().zip(run(false)).enumerate() {
        assert!((round - other).abs() < 1e-9, "{number}: {round} or {other}");
    }
}

/// A bar that swings about its end: T = 2 pi sqrt(I / m g l) for small angles.
#[test]
fn a_pendulum_swings_in_its_time() {
    let (length, weight) = (0.5, 2.0);
    let mut bar = mass(weight, [weight * length * length / 12.0; 3]);
    bar.centre = Vector3::z() * (length / 2.0);
    let links = vec![
        Link::new(0, Joint::Fixed, Vector3::zeros(), mass(1.0, [1.0; 3])),
        Link::new(0, Joint::Revolute(Vector3::y()), Vector3::zeros(), bar),
    ];
    let mut body = Body::new(Arc::new(Tree::new(links)), Pose::identity());
    body.set_gravity(GRAVITY);
    body.velocity_mut()[0] = 0.1;
    let (time_step, mut crossings) = (1e-4, Vec::new());
    for number in 0..30_000 {
        let before = body.position(1);
        run(&mut body, time_step, time_step);
        if before < 0.0 && body.position(1) >= 0.0 {
            crossings.push(f64::from(number) * time_step);
        }
    }
    let inertia = weight * length * length / 3.0;
    let expected = std::f64::consts::TAU * (inertia / (weight * 9.81 * length / 2.0)).sqrt();
    let found = crossings[1] - crossings[0];
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} s, expected {expected}");
}

/// A servo of any stiffness is stable at any step, and stays within its limit.
#[test]
fn a_stiff_servo_reaches_its_speed_and_a_weak_one_does_what_it_can() {
    let links = vec![
        Link::new(0, Joint::Fixed, Vector3::zeros(), mass(1.0, [1.0; 3])),
        Link::new(0, Joint::Revolute(Vector3::y()), Vector3::zeros(), mass(1.0, [0.1, 0.2, 0.1])),
    ];
    let mut body = Body::new(Arc::new(Tree::new(links)), Pose::identity());
    body.set_drive(0, Drive { at_rest: 1e9 * 3.0, gain: 1e9, most: f64::INFINITY });
    run(&mut body, 0.016, 0.016);
    assert!((body.velocity()[0] - 3.0).abs() < 1e-6);
    body.velocity_mut()[0] = 0.0;
    body.set_drive(0, Drive { at_rest: 1e9 * 3.0, gain: 1e9, most: 0.5 });
    run(&mut body, 0.016, 0.016);
    assert!((body.velocity()[0] - 0.5 * 0.016 / 0.2).abs() < 1e-9);
}

/// An end stops a joint, dry friction brakes it, and a coupling moves another joint.
#[test]
fn joints_have_ends_friction_and_couplings() {
    let links = vec![
        Link::new(0, Joint::Fixed, Vector3::zeros(), mass(1.0, [1.0; 3])),
        Link::new(0, Joint::Revolute(Vector3::y()), Vector3::zeros(), mass(1.0, [0.1; 3])),
        Link::new(0, Joint::Revolute(Vector3::z()), Vector3::x(), mass(1.0, [0.1; 3])),
    ];
    let row = |terms, constraint| JointRow {
        body: 0,
        terms,
        root: [0.0; 6],
        constraint,
        target: 0.0,
        compliance: 0.0,
        impulse: 0.0,
    };
    let start = || {
        let mut body = Body::new(Arc::new(Tree::new(links.clone())), Pose::identity());
        body.velocity_mut()[0] = 1.0;
        body
    };
    for (joint, expected) in [
        (row([Some((0, -1.0)), None], Constraint::Contact { friction: 0.0, tangents: 0 }), [0.0, 0.0]),
        (row([Some((0, 1.0)), None], Constraint::Contact { friction: 0.0, tangents: 0 }), [1.0, 0.0]),
        (row([Some((0, 1.0)), None], Constraint::Within(0.03)), [0.7, 0.0]),
        (row([Some((0, 1.0)), Some((1, -0.5))], Constraint::Within(f64::INFINITY)), [0.2, 0.4]),
    ] {
        let mut body = start();
        let outcome = step(&mut [&mut body], &mut [], &mut [joint], 0.01, &mut Workspace::default());
        let off = body.velocity().iter().zip(expected).map(|(found, expected)| (found - expected).abs());
        assert!(outcome.is_settled && off.fold(0.0, f64::max) < 1e-5, "{joint:?}: {:?}", body.velocity());
    }
}

/// A base on four wheels under stiff servos turns on the spot as Coulomb friction predicts: w R b / (a² + b²), whatever the step
/// (exact-wheels, "The reference").
#[test]
fn a_skid_robot_turns_on_the_spot_by_coulombs_friction() {
    let (half_base, half_track, radius, speed) = (0.124, 0.18, 0.098, 2.0);
    let disc = mass(0.1, [0.1 * radius * radius / 4.0, 0.1 * radius * radius / 2.0, 0.1 * radius * radius / 4.0]);
    let hubs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let mut links = vec![Link::new(0, Joint::Free, Vector3::zeros(), mass(11.5, [0.15, 0.3, 0.4]))];
    for (ahead, right) in hubs {
        let hub = Vector3::new(half_base * ahead, half_track * right, 0.0);
        links.push(Link { is_round: true, ..Link::new(0, Joint::Revolute(-Vector3::y()), hub, disc) });
    }
    let tree = Arc::new(Tree::new(links));
    // Turn rate of the base, as a share of the wheels'.
    let coulomb = radius * half_track / (half_base * half_base + half_track * half_track);
    for time_step in [0.001, 0.002, 0.004, 0.008, 0.016] {
        let mut body = Body::new(tree.clone(), Pose::translation(0.0, 0.0, -radius));
        body.set_gravity(GRAVITY);
        let mut impulses = [Vector3::zeros(); 4];
        let (mut turned, mut rolled, mut rounds) = (0.0, 0.0, 0);
        let steps = (2.0_f64 / time_step) as usize;
        for number in 0..steps {
            let mut contacts: Vec<Contact> = Vec::new();
            for (wheel, (_, right)) in hubs.iter().enumerate() {
                body.set_drive(6 + wheel, Drive { at_rest: -50.0 * speed * right, gain: 50.0, most: 1e9 });
                let point = body.centre() + body.frames()[1 + wheel].origin + Vector3::z() * radius;
                contacts.push(Contact {
                    point,
                    normal: -Vector3::z(),
                    tangents: [Some(Vector3::x()), Some(Vector3::y())],
                    friction: 0.8,
                    target: point.z / (time_step + 0.02),
                    compliance: [1.0 / (time_step * 1e6 * (time_step + 0.02)), 0.0, 0.0],
                    first: Side { body: 0, link: 1 + wheel },
                    second: None,
                    drift: Vector3::zeros(),
                    impulse: impulses[wheel],
                    memory: Vector3::zeros(),
                });
            }
            let outcome = step(&mut [&mut body], &mut contacts, &mut [], time_step, &mut Workspace::default());
            assert!(outcome.is_settled, "step {number} of {time_step} s: {outcome:?}");
            impulses = std::array::from_fn(|wheel| contacts[wheel].impulse);
            body.advance(time_step);
            rounds += outcome.newton_steps;
            if 2 * number >= steps {
                turned += body.velocity()[2] * time_step;
                rolled += (body.velocity()[7] - body.velocity()[6]) / 2.0 * time_step;
            }
        }
        let share = turned / rolled / coulomb;
        println!("{time_step} s: {share:.6} of Coulomb's, {} Newton steps a step", rounds as f64 / steps as f64);
        assert!((share - 1.0).abs() < 1e-3, "{share} of Coulomb's at {time_step} s");
    }
}
