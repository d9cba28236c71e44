//! Maps and robots as Foxglove's primitives.

use std::f64::consts::FRAC_PI_2;

use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, Point3, Pose as FoxPose, Quaternion, SceneEntity, SpherePrimitive,
    TriangleListPrimitive, Vector3,
};
use scene::{Drawn, Geometry, Link, MapDef, Moves, Pose, RobotDef, Shape, Solid};

/// Edge of the square that represents an infinite plane, m.
const PLANE_EDGE: f64 = 100.0;
/// Thickness of that square, m.
const PLANE_THICKNESS: f64 = 0.01;

/// Draws the solids of a map in the world.
pub(crate) fn map(map: &MapDef) -> Vec<SceneEntity> {
    map.solids.iter().chain(&map.markings).map(|fixed| solid("world", fixed, &fixed.pose())).collect()
}

/// Draws an object in its frame.
pub(crate) fn object(number: usize, def: &Solid) -> SceneEntity {
    solid(&object_frame(number), def, &Pose::identity())
}

fn solid(frame: &str, solid: &Solid, pose: &Pose) -> SceneEntity {
    let mut drawn = entity(frame, &solid.name);
    add(&mut drawn, &solid.shape, pose, colour(solid.material.colour));
    drawn
}

pub(crate) fn object_frame(number: usize) -> String {
    format!("object/{number}")
}

/// Draws a robot: its body in its frame, and every other link in the frame of its name below that.
pub(crate) fn robot(frame: &str, def: &RobotDef) -> Vec<SceneEntity> {
    let link = |(number, (link, pieces)): (usize, (&Link, Vec<Drawn>))| {
        let mut drawn = match number {
            0 => entity(frame, "body"),
            _ => entity(&format!("{frame}/{}", link.name), "link"),
        };
        for Drawn { pose, geometry, colour: [r, g, b], moves } in pieces {
            let colour = Color { r, g, b, a: 1.0 };
            // Foxglove moves the frames of links only: belts and propellers stand still in it.
            let places = match moves {
                Moves::Belt(pads) => pads.poses(0.0),
                Moves::Still | Moves::Roller | Moves::Spin(_) => vec![pose],
            };
            for pose in &places {
                match &geometry {
                    Geometry::Shape(shape) => add(&mut drawn, shape, pose, colour),
                    Geometry::Revolved(outline) => drawn.cylinders.extend(cones(outline, pose, colour)),
                }
            }
        }
        drawn
    };
    def.drawn().enumerate().map(link).collect()
}

/// Converts an outline turned about the x axis of a pose to cones.
fn cones(outline: &[[f64; 2]], pose: &Pose, colour: Color) -> impl Iterator<Item = CylinderPrimitive> {
    outline.windows(2).map(move |ends| {
        let ([from, bottom], [to, top]) = (ends[0], ends[1]);
        let widest = bottom.max(top);
        let middle = pose * scene::pose([(from + to) / 2.0, 0.0, 0.0], [0.0, FRAC_PI_2, 0.0]);
        CylinderPrimitive {
            pose: Some(fox_pose(&middle)),
            size: Some(Vector3 { x: 2.0 * widest, y: 2.0 * widest, z: to - from }),
            bottom_scale: bottom / widest,
            top_scale: top / widest,
            color: Some(colour),
        }
    })
}

fn entity(frame: &str, id: &str) -> SceneEntity {
    let (frame_id, id) = (frame.to_owned(), format!("{frame} {id}"));
    SceneEntity { frame_id, id, frame_locked: true, ..SceneEntity::default() }
}

fn add(drawn: &mut SceneEntity, shape: &Shape, pose: &Pose, colour: Color) {
    let (place, color) = (Some(fox_pose(pose)), Some(colour));
    let size = |x, y, z| Some(Vector3 { x, y, z });
    match shape {
        Shape::HalfSpace => {
            let below = pose * scene::pose([0.0, 0.0, PLANE_THICKNESS / 2.0], [0.0; 3]);
            let size = size(PLANE_EDGE, PLANE_EDGE, PLANE_THICKNESS);
            drawn.cubes.push(CubePrimitive { pose: Some(fox_pose(&below)), size, color });
        }
        Shape::Box { size: [x, y, z] } => {
            drawn.cubes.push(CubePrimitive { pose: place, size: size(*x, *y, *z), color })
        }
        Shape::Ball { radius } => {
            let edge = 2.0 * radius;
            drawn.spheres.push(SpherePrimitive { pose: place, size: size(edge, edge, edge), color });
        }
        Shape::Cylinder { radius, length } => drawn.cylinders.push(CylinderPrimitive {
            pose: place,
            size: size(2.0 * radius, 2.0 * radius, *length),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color,
        }),
        Shape::Hull { points } => {
            if let Some(surface) = scene::hull_surface(points) {
                add(drawn, &surface, pose, colour);
            }
        }
        Shape::HeightField(field) => add(drawn, &field.surface(), pose, colour),
        Shape::Mesh { vertices, triangles } => {
            let points = vertices.iter().map(|&[x, y, z]| Point3 { x, y, z }).collect();
            let indices = triangles.iter().flatten().copied().collect();
            drawn.triangles.push(TriangleListPrimitive { pose: place, points, color, colors: Vec::new(), indices });
        }
    }
}

fn colour([r, g, b]: [f64; 3]) -> Color {
    Color { r, g, b, a: 1.0 }
}

/// Converts a pose to Foxglove's form, with the same bits.
pub(crate) fn fox_pose(pose: &Pose) -> FoxPose {
    let [x, y, z] = pose.translation.vector.into();
    let [i, j, k, w] = pose.rotation.coords.into();
    FoxPose { position: Some(Vector3 { x, y, z }), orientation: Some(Quaternion { x: i, y: j, z: k, w }) }
}
