//! Drawable geometry of a robot: one list for the page, pictures, logs and Foxglove.

use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;

use nalgebra::Translation3;
use serde::{Deserialize, Serialize};

use crate::{Link, MountedWheel, Pads, Pose, RobotDef, Shape, pose};

/// Visible geometry of a link, if it differs from the colliding geometry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Visual {
    /// Geometry.
    pub shape: Shape,
    /// Position in the robot frame when every joint is at 0, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw there, rad.
    pub rotation: [f64; 3],
    /// Red, green and blue, 0 to 1, sRGB.
    pub colour: [f64; 3],
    /// Speed about its own z axis, rad/s. It turns with the world's time, for looks only, as a propeller does.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub spin: f64,
}

fn is_zero(spin: &f64) -> bool {
    *spin == 0.0
}

/// One drawn piece of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn<'a> {
    /// Pose in the frame of its link; for a roller or a spinning piece, with its angle at 0.
    pub pose: Pose,
    /// Geometry.
    pub geometry: Geometry<'a>,
    /// Red, green and blue, 0 to 1, sRGB.
    pub colour: [f64; 3],
    /// Motion in the frame of its link.
    pub moves: Moves,
}

/// Motion of a drawn piece in the frame of its link.
#[derive(Debug, Clone, PartialEq)]
pub enum Moves {
    /// No motion.
    Still,
    /// Turns about its own x axis. Rollers follow the order of the robot's rollers.
    Roller,
    /// Turns about its own z axis at a speed, rad/s. At time 0 its angle is 0.
    Spin(f64),
    /// Is drawn at every pad of a belt. The pads move with the sprocket.
    Belt(Pads),
}

/// Geometry of a drawn piece.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry<'a> {
    /// A shape.
    Shape(Cow<'a, Shape>),
    /// An outline revolved about the x axis: positions along it and radii, m.
    Revolved(Vec<[f64; 2]>),
}

/// Number of cone pieces that a roller is drawn with.
const ROLLER_PIECES: u32 = 8;
const BODY: [f64; 3] = [0.93, 0.45, 0.12];
const CORE: [f64; 3] = [0.3, 0.31, 0.33];
const HUB: [f64; 3] = [0.55, 0.57, 0.6];

impl RobotDef {
    /// Returns the drawn pieces of each link, in the order of the links.
    pub fn drawn(&self) -> impl Iterator<Item = (&Link, Vec<Drawn<'_>>)> {
        self.links.iter().enumerate().map(|(number, link)| (link, drawn((number, link))))
    }
}

/// Returns the visuals of a link, or its solids and wheel if it has none. Rollers and belts are always drawn, as they move by themselves.
fn drawn<'a>((number, link): (usize, &'a Link)) -> Vec<Drawn<'a>> {
    let still = |pose, shape, colour| Drawn { pose, geometry: Geometry::Shape(shape), colour, moves: Moves::Still };
    let to_link = Translation3::from(link.origin()).inverse();
    let visual = |it: &'a Visual| Drawn {
        moves: if it.spin == 0.0 { Moves::Still } else { Moves::Spin(it.spin) },
        ..still(to_link * pose(it.position, it.rotation), Cow::Borrowed(&it.shape), it.colour)
    };
    let mut drawn: Vec<Drawn> = link.visuals.iter().map(visual).collect();
    let wheel = MountedWheel::of((number, link));
    let belt = wheel.and_then(|wheel| Some((wheel, wheel.wheel.belt.as_ref()?)));
    if let Some((wheel, belt)) = belt {
        drawn.push(still(Pose::identity(), Cow::Owned(belt.core(wheel.width)), CORE));
        let pads = belt.pads(wheel.width);
        drawn.push(Drawn {
            pose: Pose::identity(),
            geometry: Geometry::Shape(Cow::Owned(Shape::Box { size: pads.size })),
            colour: wheel.material.colour,
            moves: Moves::Belt(pads),
        });
    }
    if drawn.is_empty() {
        drawn.extend(link.solids.iter().map(|it| still(link.pose_of(it), Cow::Borrowed(&it.shape), BODY)));
        drawn.extend(wheel.map(|wheel| {
            let (shape, colour) = outline(&wheel);
            still(pose([0.0; 3], [FRAC_PI_2, 0.0, 0.0]), Cow::Owned(shape), colour)
        }));
    }
    if let Some((wheel, rollers)) = wheel.and_then(|wheel| Some((wheel, wheel.wheel.rollers.as_ref()?))) {
        drawn.extend((0..rollers.count).map(|index| Drawn {
            pose: rollers.pose(index),
            geometry: Geometry::Revolved(rollers.outline(wheel.radius, ROLLER_PIECES)),
            colour: rollers.material.colour,
            moves: Moves::Roller,
        }));
    }
    drawn
}

/// Returns the shape and colour of a wheel without its rollers: a ball for a caster, a disc about z, or the hub between the
/// rollers.
fn outline(wheel: &MountedWheel) -> (Shape, [f64; 3]) {
    let disc = |radius| Shape::Cylinder { radius, length: wheel.width };
    match (wheel.drive, &wheel.rollers) {
        (None, _) => (Shape::Ball { radius: wheel.radius }, wheel.material.colour),
        (Some(_), None) => (disc(wheel.radius), wheel.material.colour),
        (Some(_), Some(rollers)) => (disc(rollers.hub_radius(wheel.radius)), HUB),
    }
}
