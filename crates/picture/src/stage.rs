//! Triangles of a scene, made once and placed for each picture.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use nalgebra::{Point3, UnitQuaternion, Vector3};
use scene::{Drawn, Geometry, Moves, ObjectSnapshot, PawnId, Pose, RobotDef, RobotSnapshot, Snapshot, WorldDef};

use crate::mesh::{Floor, Mesh, Paint, Triangle};

/// A scene prepared for pictures.
pub struct Stage {
    /// Everything fixed, in the world frame.
    fixed: Mesh,
    /// Pieces of each class, made for the first picture with a robot of it.
    classes: BTreeMap<String, OnceLock<Vec<Piece>>>,
}

/// A piece of a robot that moves with a link.
struct Piece {
    /// Number of the link among those of the class.
    link: usize,
    /// Pose in the link's frame.
    pose: Pose,
    /// Motion in the link's frame.
    moves: Moves,
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
        solids.for_each(|solid| fixed.add(&solid.shape, &solid.pose(), Paint::from(&solid.material)));
        let classes = def.robots.keys().map(|name| (name.clone(), OnceLock::new())).collect();
        Self { fixed, classes }
    }

    /// Returns a class of a definition and its pieces.
    fn class<'a>(&'a self, def: &'a WorldDef, name: &str) -> Option<(&'a RobotDef, &'a [Piece])> {
        let (def, pieces_of) = (def.robots.get(name)?, self.classes.get(name)?);
        Some((def, pieces_of.get_or_init(|| pieces(def))))
    }

    /// Returns the corners of everything that is drawn of a robot of a snapshot, in the world frame.
    pub fn corners_of(&self, def: &WorldDef, snapshot: &Snapshot, robot: &RobotSnapshot) -> Vec<Point3<f64>> {
        let mut triangles = Vec::new();
        if let Some((def, pieces)) = self.class(def, &robot.class) {
            place(pieces, def, robot, snapshot.time, None, &mut triangles);
        }
        triangles.iter().flat_map(|triangle| triangle.corners).collect()
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
            moving.add(&def.solid.shape, pose, Paint::from(&def.solid.material));
        }
        let mut triangles = self.fixed.triangles.clone();
        triangles.append(&mut moving.triangles);
        for robot in &snapshot.robots {
            if let Some((def, pieces)) = self.class(def, &robot.class) {
                let eye = own.filter(|(id, _)| *id == robot.id).map(|(_, eye)| eye);
                place(pieces, def, robot, snapshot.time, eye, &mut triangles);
            }
        }
        (triangles, &self.fixed.floors)
    }
}

fn pieces(robot: &RobotDef) -> Vec<Piece> {
    let of_link = |(link, (_, drawn)): (usize, (_, Vec<Drawn>))| {
        let piece = move |Drawn { pose, geometry, colour, moves }: Drawn| {
            let mut mesh = Mesh::default();
            match geometry {
                Geometry::Shape(shape) => mesh.add(&shape, &Pose::identity(), colour.into()),
                Geometry::Revolved(outline) => mesh.add_lathe(&outline, &Pose::identity(), colour.into()),
            }
            Piece { link, pose, moves, bounds: bounds(&mesh.triangles), triangles: mesh.triangles }
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
    time: f64,
    eye: Option<Point3<f64>>,
    triangles: &mut Vec<Triangle>,
) {
    let RobotSnapshot { body, joints, rollers, .. } = robot;
    let links: Vec<Pose> = def.placed_links(joints).into_iter().map(|(_, pose)| body.pose * pose).collect();
    let mut rollers = rollers.iter();
    let [largest, margin] = HOUSING;
    for Piece { link: number, pose, moves, triangles: own, bounds: (middle, radius) } in pieces {
        let turned = |axis, angle| vec![pose * UnitQuaternion::from_axis_angle(&axis, angle)];
        let places = match moves {
            Moves::Still => vec![*pose],
            Moves::Roller => turned(Vector3::x_axis(), rollers.next().copied().unwrap_or_default()),
            Moves::Spin(speed) => turned(Vector3::z_axis(), speed * time),
            Moves::Belt(pads) => {
                let sprocket = def.value_of(*number).and_then(|value| joints.get(value));
                pads.poses(sprocket.map_or(0.0, |sprocket| sprocket.position))
            }
        };
        let Some(link) = links.get(*number) else { continue };
        for place in places {
            let pose = link * place;
            let is_near = |eye: Point3<f64>| (pose * middle - eye).norm() < radius + margin;
            if *radius < largest && eye.is_some_and(is_near) {
                continue;
            }
            triangles.extend(own.iter().map(|triangle| Triangle {
                corners: triangle.corners.map(|corner: Point3<f64>| pose * corner),
                ..triangle.clone()
            }));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use gamebots_proto::command::Init;
    use scene::MountedWheel;
    use sim_core::{Options, World};

    use super::*;

    /// Spawns a robot; returns the definition, the snapshot and the stage.
    fn spawned(class: &str) -> (WorldDef, Snapshot, Stage) {
        let def = scene_loader::load("smooth", &[]).unwrap();
        let mut world = World::new(def.clone(), Options::default());
        world.init(&Init { class_name: class.to_owned(), ..Init::default() }, &mut Vec::new()).unwrap();
        let stage = Stage::new(&def);
        (def, world.snapshot(), stage)
    }

    /// Counts the corners that differ by more than a rounding error.
    fn moved(one: &[Point3<f64>], other: &[Point3<f64>]) -> usize {
        assert_eq!(one.len(), other.len());
        one.iter().zip(other).filter(|(a, b)| (*a - *b).norm() > 1e-9).count()
    }

    #[test]
    fn only_propellers_turn_with_the_time() {
        let (def, mut snapshot, stage) = spawned("AirRobot");
        let spinning = |moves: &Moves| matches!(moves, Moves::Spin(_));
        let (_, pieces) = stage.class(&def, "AirRobot").expect("a class");
        let blades: usize = pieces.iter().filter(|it| spinning(&it.moves)).map(|it| it.triangles.len()).sum();
        let mut at = |time: f64| {
            snapshot.time = time;
            stage.corners_of(&def, &snapshot, &snapshot.robots[0])
        };
        let (begin, later, round) = (at(0.0), at(0.1), at(TAU / 7.0));
        assert!(blades > 0 && begin.len() > 6 * blades, "{blades} of {}", begin.len());
        assert!(moved(&begin, &later).abs_diff(3 * blades) < blades / 10);
        assert_eq!(moved(&begin, &round), 0);
    }

    #[test]
    fn the_pads_of_a_belt_move_with_its_sprocket() {
        let (def, mut snapshot, stage) = spawned("Kenaf");
        let class = &def.robots["Kenaf"];
        let (number, link) = class.links.iter().enumerate().find(|(_, link)| link.name == "RightTrack").unwrap();
        let wheel = MountedWheel::of((number, link)).unwrap();
        let pads = wheel.wheel.belt.as_ref().unwrap().pads(wheel.width);
        let value = class.value_of(number).unwrap();
        let before = stage.corners_of(&def, &snapshot, &snapshot.robots[0]);
        snapshot.robots[0].joints[value].position += 0.1;
        let after = stage.corners_of(&def, &snapshot, &snapshot.robots[0]);
        assert_eq!(moved(&before, &after), pads.count * 12 * 3);
    }
}
