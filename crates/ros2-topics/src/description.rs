//! A class of robots as a URDF, for `robot_description`: links, joints, masses and simple shapes. Meshes are drawn as boxes around them, as
//! their files need not be where the reader is.

use std::fmt::Write;

use nalgebra::Vector3;
use scene::{JointKind, Link, Part, Pose, RobotDef, Shape, Wheel};

use crate::convert;
use crate::names::Space;

/// Speed and effort of a joint's limits, which the format wants and the definition does not have, rad/s or m/s, N m or N.
const NO_LIMIT: f64 = 1000.0;

/// Returns the URDF. Links are named as their frames are.
pub(crate) fn urdf(def: &RobotDef, space: &Space) -> String {
    let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", convert::name(&def.class));
    let frames: Vec<String> = (0..def.links.len()).map(|number| frame(def, number, space)).collect();
    for (link, frame) in def.links.iter().zip(&frames) {
        // Writing to a text does not fail.
        let _ = write_link(&mut text, link, frame);
        let Some(joint) = &link.joint else { continue };
        let parent = def.links.get(joint.parent).map_or([0.0; 3], Link::origin);
        let offset = Vector3::from(joint.anchor) - Vector3::from(parent);
        let parent = frames.get(joint.parent).map_or("", String::as_str);
        let _ = write_joint(&mut text, link, frame, parent, offset);
    }
    text.push_str("</robot>\n");
    text
}

/// Returns the frame of a link.
pub(crate) fn frame(def: &RobotDef, number: usize, space: &Space) -> String {
    match def.links.get(number) {
        Some(link) if number > 0 => format!("{}{}", space.prefix, convert::name(&link.name)),
        _ => space.base.clone(),
    }
}

fn write_link(text: &mut String, link: &Link, frame: &str) -> std::fmt::Result {
    writeln!(text, "  <link name=\"{frame}\">")?;
    let mass: f64 =
        link.parts.iter().map(|part| part.mass).sum::<f64>() + link.wheel.as_ref().map_or(0.0, |it| it.mass);
    if mass > 0.0 {
        let moment: f64 = link.parts.iter().map(|part: &Part| part.inertia.trace() / 3.0).sum();
        // A wheel about its axis; readers refuse a moment of 0.
        let of_wheel = link.wheel.as_ref().map_or(0.0, |wheel| wheel.mass * wheel.radius * wheel.radius / 2.0);
        let moment = (moment + of_wheel).max(1e-6);
        let middle: Vector3<f64> = link.parts.iter().map(|part| part.centre * part.mass).sum::<Vector3<f64>>() / mass;
        let [x, y, z] = if link.parts.is_empty() { [0.0; 3] } else { (middle - Vector3::from(link.origin())).into() };
        writeln!(
            text,
            "    <inertial><origin xyz=\"{x} {} {}\"/><mass value=\"{mass}\"/><inertia ixx=\"{moment}\" ixy=\"0\" \
             ixz=\"0\" iyy=\"{moment}\" iyz=\"0\" izz=\"{moment}\"/></inertial>",
            -y, -z
        )?;
    }
    for solid in &link.solids {
        write_shape(text, &link.pose_of(solid), &solid.shape)?;
    }
    if let Some(Wheel { radius, width, .. }) = &link.wheel {
        // A cylinder of URDF stands along z, and a wheel's axis is y.
        let pose = scene::pose([0.0; 3], [std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
        write_shape(text, &pose, &Shape::Cylinder { radius: *radius, length: *width })?;
    }
    writeln!(text, "  </link>")
}

fn write_shape(text: &mut String, pose: &Pose, shape: &Shape) -> std::fmt::Result {
    let (middle, geometry) = match shape {
        Shape::Box { size: [x, y, z] } => ([0.0; 3], format!("<box size=\"{x} {y} {z}\"/>")),
        Shape::Cylinder { radius, length } => {
            ([0.0; 3], format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>"))
        }
        Shape::Ball { radius } => ([0.0; 3], format!("<sphere radius=\"{radius}\"/>")),
        Shape::Hull { points } => around(points),
        Shape::Mesh { vertices, .. } => around(vertices),
        Shape::HalfSpace | Shape::HeightField(_) => return Ok(()),
    };
    let placed = convert::pose(&(pose * nalgebra::Translation3::from(middle)));
    let turn = placed.orientation;
    let turn = nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(turn.w, turn.x, turn.y, turn.z));
    let (roll, pitch, yaw) = turn.euler_angles();
    let at = placed.position;
    let origin = format!("<origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/>", at.x, at.y, at.z);
    for tag in ["visual", "collision"] {
        writeln!(text, "    <{tag}>{origin}<geometry>{geometry}</geometry></{tag}>")?;
    }
    Ok(())
}

/// Returns the middle of points and the box around them.
fn around(points: &[[f64; 3]]) -> ([f64; 3], String) {
    let side = |axis: usize| {
        let numbers = || points.iter().map(move |point| point.get(axis).copied().unwrap_or(0.0));
        let (least, most) = (numbers().fold(f64::INFINITY, f64::min), numbers().fold(f64::NEG_INFINITY, f64::max));
        if least <= most { ((least + most) / 2.0, most - least) } else { (0.0, 0.0) }
    };
    let [x, y, z] = [0, 1, 2].map(side);
    ([x.0, y.0, z.0], format!("<box size=\"{} {} {}\"/>", x.1, y.1, z.1))
}

fn write_joint(text: &mut String, link: &Link, frame: &str, parent: &str, offset: Vector3<f64>) -> std::fmt::Result {
    let Some(joint) = &link.joint else { return Ok(()) };
    let kind = match joint.kind {
        JointKind::Revolute => "revolute",
        JointKind::Prismatic => "prismatic",
        JointKind::Continuous => "continuous",
        JointKind::Fixed | JointKind::Ball | JointKind::Belt => "fixed",
    };
    let [x, y, z] = joint.axis;
    writeln!(text, "  <joint name=\"{}\" type=\"{kind}\">", convert::name(&link.name))?;
    writeln!(text, "    <parent link=\"{parent}\"/><child link=\"{frame}\"/>")?;
    writeln!(text, "    <origin xyz=\"{} {} {}\"/><axis xyz=\"{x} {} {}\"/>", offset.x, -offset.y, -offset.z, -y, -z)?;
    if matches!(joint.kind, JointKind::Revolute | JointKind::Prismatic) {
        let [least, most] = joint.limits.unwrap_or([-NO_LIMIT, NO_LIMIT]);
        writeln!(
            text,
            "    <limit lower=\"{least}\" upper=\"{most}\" effort=\"{NO_LIMIT}\" velocity=\"{NO_LIMIT}\"/>"
        )?;
    }
    writeln!(text, "  </joint>")
}
