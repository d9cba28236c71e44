//! Triangles of a scene, made once and placed for each picture.

use std::collections::BTreeMap;

use nalgebra::{Point3, UnitQuaternion, Vector3};
use scene::{Drawn, Geometry, Moves, ObjectSnapshot, PawnId, Pose, RobotDef, RobotSnapshot, Snapshot, WorldDef};

use crate::mesh::{Floor, Mesh, Triangle};

/// A scene prepared for pictures.
pub struct Stage {
    /// Everything fixed, in the world frame.
    fixed: Mesh,
    /// Pieces of each class.
    classes: BTreeMap<String, Vec<Piece>>,
}

/// A piece of a robot that moves with a link.
struct Piece {
    /// Number of the link among those of the class.
    link: usize,
    /// Pose in the link's frame.
    pose: Pose,
    /// True if it turns about its own x axis.
    is_roller: bool,
    triangles: Vec<Triangle>,
    /// Middle and radius of a ball around it, in its own frame, m.
    bounds: (Point3<f64>, f64),
}

/// Largest radius of a piece that may be a camera's housing, m, and its largest distance from the eye.
const HOUSING: [f64; 2] = [0.15, 0.05];

impl Stage {
    /// Prepares a scene.
    pub fn new(def: &WorldDef) -> Self {
        let mut fixed = Mesh::default();
        let solids = def.map.solids.iter().chain(&def.map.markings);
        solids.for_each(|solid| fixed.add(&solid.shape, &solid.pose(), solid.material.colour));
        let classes = def.robots.iter().map(|(name, robot)| (name.clone(), pieces(robot))).collect();
        Self { fixed, classes }
    }

    /// Returns the triangles and floors of a snapshot. `own` is the robot that carries the camera at an eye: it does not see its housing.
    pub(crate) fn scene(
        &self,
        def: &WorldDef,
        snapshot: &Snapshot,
        own: Option<(PawnId, Point3<f64>)>,
    ) -> (Vec<Triangle>, &[Floor]) {
        let mut moving = Mesh::default();
        for ObjectSnapshot { def, pose, .. } in &snapshot.objects {
            moving.add(&def.solid.shape, pose, def.solid.material.colour);
        }
        let mut triangles = self.fixed.triangles.clone();
        triangles.append(&mut moving.triangles);
        for robot in &snapshot.robots {
            if let (Some(def), Some(pieces)) = (def.robots.get(&robot.class), self.classes.get(&robot.class)) {
                let eye = own.filter(|(id, _)| *id == robot.id).map(|(_, eye)| eye);
                place(pieces, def, robot, eye, &mut triangles);
            }
        }
        (triangles, &self.fixed.floors)
    }
}

fn pieces(robot: &RobotDef) -> Vec<Piece> {
    let of_link = |(link, (_, drawn)): (usize, (_, Vec<Drawn>))| {
        let piece = move |Drawn { pose, geometry, colour, moves }: Drawn| {
            let is_roller = moves == Moves::Roller;
            let mut mesh = Mesh::default();
            match geometry {
                Geometry::Shape(shape) => mesh.add(&shape, &Pose::identity(), colour),
                Geometry::Revolved(outline) => mesh.add_lathe(&outline, &Pose::identity(), colour),
            }
            Piece { link, pose, is_roller, bounds: bounds(&mesh.triangles), triangles: mesh.triangles }
        };
        drawn.into_iter().map(piece).collect::<Vec<_>>()
    };
    robot.drawn().enumerate().flat_map(of_link).collect()
}

/// Returns the middle and radius of a ball around triangles.
fn bounds(triangles: &[Triangle]) -> (Point3<f64>, f64) {
    let corners = || triangles.iter().flat_map(|triangle| &triangle.corners);
    let least = corners().fold(Vector3::repeat(f64::INFINITY), |least, corner| least.inf(&corner.coords));
    let most = corners().fold(Vector3::repeat(f64::NEG_INFINITY), |most, corner| most.sup(&corner.coords));
    (Point3::from((least + most) / 2.0), (most - least).norm() / 2.0)
}

/// Adds the pieces of a robot at their poses, except those that house a camera at `eye`.
fn place(
    pieces: &[Piece],
    def: &RobotDef,
    robot: &RobotSnapshot,
    eye: Option<Point3<f64>>,
    triangles: &mut Vec<Triangle>,
) {
    let RobotSnapshot { body, joints, rollers, .. } = robot;
    let links: Vec<Pose> = def.placed_links(joints).into_iter().map(|(_, pose)| body.pose * pose).collect();
    let mut spins = rollers.iter();
    let [largest, margin] = HOUSING;
    for Piece { link, pose, is_roller, triangles: own, bounds: (middle, radius) } in pieces {
        let spin = spins.by_ref().take(usize::from(*is_roller)).sum();
        let Some(link) = links.get(*link) else { continue };
        let pose = link * pose * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), spin);
        let is_near = |eye: Point3<f64>| (pose * middle - eye).norm() < radius + margin;
        if *radius < largest && eye.is_some_and(is_near) {
            continue;
        }
        triangles.extend(own.iter().map(|Triangle { corners, colour }| Triangle {
            corners: corners.map(|corner: Point3<f64>| pose * corner),
            colour: *colour,
        }));
    }
}
