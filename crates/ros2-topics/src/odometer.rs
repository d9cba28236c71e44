//! Odometry of a robot, as its controller would compute it from the encoders of its wheels.

use base_motion::{Base, Model};
use kinematics::Twist;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use scene::{JointState, Pose, RobotDef};

use crate::State;
use crate::controller::Controller;

/// Pose and velocity of a robot since it came.
#[derive(Debug)]
pub(crate) struct Odometer {
    /// Kinematics of its wheels; without them the truth counts.
    base: Option<Base>,
    /// Numbers of the driven wheels among the joints that have a value.
    wheels: Vec<usize>,
    /// Steering joints: axle, number among the joints that have a value, and sign of an angle to the right.
    steering: Vec<(usize, usize, f64)>,
    /// Time, ns, and angles of the driven wheels at the last state. Times of logs are whole nanoseconds.
    last: Option<(f64, Vec<f64>)>,
    /// Pose at which the robot came into the world.
    start: Pose,
    /// Forward and to the right of that, m, and clockwise, rad.
    place: [f64; 3],
}

/// A pose in the frame of the start, and velocities in the robot's own frame: m/s and rad/s.
pub(crate) struct Moved {
    pub(crate) pose: Pose,
    pub(crate) linear: Vector3<f64>,
    pub(crate) angular: Vector3<f64>,
}

impl Odometer {
    pub(crate) fn new(def: &RobotDef, controller: Option<&Controller>, start: Pose) -> Self {
        let steering = def.links.iter().enumerate().filter_map(|(number, link)| {
            let axis = link.joint.as_ref()?.axis[2];
            Some((link.steered_axle()?, def.value_of(number)?, axis.signum()))
        });
        Self {
            base: match controller {
                Some(controller) => Some(controller.base(def)),
                None => Base::of(def, Model::True),
            },
            wheels: def.driven().filter_map(|wheel| def.value_of(wheel.link)).collect(),
            steering: steering.collect(),
            last: None,
            start,
            place: [0.0; 3],
        }
    }

    /// Follows the robot to a state at a time, s.
    pub(crate) fn moved(&mut self, time: f64, state: &State) -> Moved {
        let Some(base) = &self.base else {
            let own = state.pose.rotation.inverse();
            let pose = self.start.inverse() * state.pose;
            return Moved { pose, linear: own * state.linear, angular: own * state.angular };
        };
        let position = |joint: &usize| state.joints.get(*joint).map_or(0.0, |joint: &JointState| joint.position);
        let angles: Vec<f64> = self.wheels.iter().map(position).collect();
        let mean = |axle| {
            let on_axle = self.steering.iter().filter(|(of, ..)| *of == axle);
            let angles: Vec<f64> = on_axle.map(|(_, joint, sign)| sign * position(joint)).collect();
            angles.iter().sum::<f64>() / angles.len().max(1) as f64
        };
        let now = (time * 1e9).round();
        let (before, last) = self.last.take().unwrap_or_else(|| (now, angles.clone()));
        let turned: Vec<f64> = angles.iter().zip(&last).map(|(now, before)| now - before).collect();
        let moved = base.displacement(&turned, &angles, [mean(0), mean(1)]);
        self.last = Some((now, angles));
        let [x, y, heading] = &mut self.place;
        // The heading at the middle of the interval.
        let (sin, cos) = (*heading + moved.clockwise / 2.0).sin_cos();
        *x += moved.forward * cos - moved.right * sin;
        *y += moved.forward * sin + moved.right * cos;
        *heading += moved.clockwise;
        let pose = Pose::from_parts(
            Translation3::new(*x, *y, 0.0),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *heading),
        );
        let speed = |Twist { forward, right, clockwise }: Twist, took: f64| {
            if took > 0.0 { [forward, right, clockwise].map(|it| it / took) } else { [0.0; 3] }
        };
        let [forward, right, clockwise] = speed(moved, (now - before) * 1e-9);
        Moved { pose, linear: Vector3::new(forward, right, 0.0), angular: Vector3::new(0.0, 0.0, clockwise) }
    }
}
