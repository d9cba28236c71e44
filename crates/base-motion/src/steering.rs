//! Steering of cars: each wheel is perpendicular to the line from it to the turning centre (Ackermann), and turns as fast as it is far from it,
//! as with differentials.

use scene::RobotDef;

/// Returns the turning centre for the angles of the middles of front and rear axle, rad, positive to the right: x and y in the robot frame,
/// m. `None` if both are parallel, or so steep that the centre would be between left and right wheels.
fn turning_centre(robot: &RobotDef, steer: [f64; 2]) -> Option<[f64; 2]> {
    let geometry = robot.wheel_geometry();
    let front_x = robot.driven().map(|wheel| wheel.position[0]).reduce(f64::max)?;
    let [x, aside] = centre(geometry.wheel_base, front_x, steer);
    let is_outside = aside.is_finite() && aside.abs() > geometry.track / 2.0;
    is_outside.then_some([x, aside])
}

/// Returns the turning centre of axles that are `wheel_base` apart, the front one at `front_x`, m. It is infinite if both are parallel.
pub(crate) fn centre(wheel_base: f64, front_x: f64, steer: [f64; 2]) -> [f64; 2] {
    let [front, rear] = steer.map(libm::tan);
    let aside = wheel_base / (front - rear);
    [front_x - aside * front, aside]
}

/// Returns the angles of the joints that steer, rad, each with the number of its link.
pub fn joint_angles(robot: &RobotDef, steer: [f64; 2]) -> Vec<(usize, f64)> {
    let centre = turning_centre(robot, steer);
    let angle = |(number, link): (usize, &scene::Link)| {
        let angle = steer[link.steered_axle()?];
        let [x, y, _] = link.origin();
        // The turning centre is `aside` to the right of the wheel and `behind` behind it.
        let angle = centre.map_or(angle, |[centre_x, centre_y]| {
            let (behind, aside) = (x - centre_x, centre_y - y);
            libm::atan(behind / aside)
        });
        // A joint whose axis points up turns the other way.
        let axis = link.joint.as_ref()?.axis[2];
        Some((number, angle * axis.signum()))
    };
    robot.links.iter().enumerate().filter_map(angle).collect()
}

/// Returns the speed of each driven wheel over the mean of all.
pub fn speed_shares(robot: &RobotDef, steer: [f64; 2]) -> Vec<f64> {
    let distances: Vec<f64> = match turning_centre(robot, steer) {
        None => robot.driven().map(|_| 1.0).collect(),
        Some([x, y]) => robot.driven().map(|wheel| libm::hypot(wheel.position[0] - x, wheel.position[1] - y)).collect(),
    };
    let mean = distances.iter().sum::<f64>() / distances.len().max(1) as f64;
    distances.into_iter().map(|distance| distance / mean).collect()
}

/// Returns the limits that the joints that steer need, rad, each with the number of its link: those of a definition are those of the middle
/// of the axle, and the inner wheel turns farther.
pub fn joint_limits(robot: &RobotDef) -> Vec<(usize, [f64; 2])> {
    let of_axle = |axle: usize| robot.steering_limits(axle).reduce(|[a, b], [c, d]| [a.max(c), b.min(d)]);
    let ends = [0, 1].map(|axle| of_axle(axle).unwrap_or_default());
    let own = robot.links.iter().enumerate().filter(|(_, link)| link.steered_axle().is_some());
    let mut limits: Vec<(usize, [f64; 2])> =
        own.filter_map(|(number, link)| Some((number, link.joint.as_ref()?.limits?))).collect();
    for front in [ends[0][0], 0.0, ends[0][1]] {
        for rear in [ends[1][0], 0.0, ends[1][1]] {
            let angles = joint_angles(robot, [front, rear]);
            for (number, [least, most]) in &mut limits {
                let needed = angles.iter().find(|(link, _)| link == number).map_or(0.0, |(_, angle)| *angle);
                (*least, *most) = (least.min(needed), most.max(needed));
            }
        }
    }
    limits
}
