//! Shapes of plain wheels and of rollers.

use rapier3d::math::Pose as EnginePose;
use rapier3d::prelude::*;
use scene::Rollers;

use super::super::roller::RollerShape;

/// Width of the crown of a plain wheel, m.
const CROWN_WIDTH: f64 = 0.004;
/// Height of the crown over the rest of the wheel, m.
const CROWN_HEIGHT: f64 = 0.002;

/// Builds a plain wheel about the robot's y axis. A narrow crown carries the load, so the robot stands on the middle of the wheel and not
/// on an edge. The full width is a little below the crown, for walls and kerbs.
pub(super) fn tread(radius: f64, width: f64) -> SharedShape {
    let cylinder = |radius: f64, width: f64| (EnginePose::IDENTITY, SharedShape::cylinder(width / 2.0, radius));
    SharedShape::compound(vec![cylinder(radius, CROWN_WIDTH.min(width)), cylinder(radius - CROWN_HEIGHT, width)])
}

/// Builds a roller along the x axis.
pub(super) fn roller(rollers: &Rollers, wheel_radius: f64) -> SharedShape {
    SharedShape::new(RollerShape::new(rollers, wheel_radius))
}
