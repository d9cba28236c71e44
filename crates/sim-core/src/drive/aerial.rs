//! A robot in the air: `{LinearVelocity f} {LateralVelocity f} {AltitudeVelocity f}`, m/s, positive up,
//! `{RotationalVelocity f}`, degrees a second, `{PitchAngle f} {RollAngle f}`, degrees. All keys are optional, and each value is held
//! until it is replaced (AerialVehicle.uc:61-215). `{Normalized true}` makes the values of its own line percent of the limits. Moving
//! ahead or aside leans the robot by the greatest angle at any speed, unless the line sets pitch or roll. Every value is clamped to the
//! class's limit, normalized or not. The original clamps none of them.
//!
//! Propeller spins (`{Spin1 f} {Spin2 f}`) are ignored. They move nothing in USARSim either.

use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use scene::{Aerial, RobotDef};

use super::Order;
use crate::flight::Flight;

/// The last two move nothing.
pub(super) const KEYS: [&str; 8] = [
    "LinearVelocity",
    "LateralVelocity",
    "AltitudeVelocity",
    "RotationalVelocity",
    "PitchAngle",
    "RollAngle",
    "Spin1",
    "Spin2",
];

/// Returns the order of a command: the targets of a flight, of which it changes what it names. [`Flight::within`] applies the limits.
pub(super) fn order(mut flight: Flight, robot: &RobotDef, drive: &Drive, problems: &mut Vec<Problem>) -> Option<Order> {
    let Aerial { max_velocity, max_turn, max_tilt } = robot.footing.aerial()?;
    let normalized = drive.normalized == Some(true);
    let share = |value: f64, limit: f64| if normalized { value / 100.0 * limit } else { value };
    let [linear, lateral, altitude, turn, pitch, roll] = drive.numbers(
        ["LinearVelocity", "LateralVelocity", "AltitudeVelocity", "RotationalVelocity", "PitchAngle", "RollAngle"],
        problems,
    );
    for ((held, given), limit) in flight.velocity.iter_mut().zip([linear, lateral, altitude]).zip(max_velocity) {
        *held = given.map_or(*held, |given| share(given, limit));
    }
    let turned = |value: f64, limit: f64| share(if normalized { value } else { value.to_radians() }, limit);
    flight.turn = turn.map_or(flight.turn, |turn| turned(turn, max_turn));
    let lean = |velocity: f64| if velocity == 0.0 { 0.0 } else { max_tilt * velocity.signum() };
    let angle = |degrees: f64| turned(degrees, max_tilt);
    let [own_roll, own_pitch] = flight.attitude;
    // Moving ahead is nose down, a negative pitch.
    flight.attitude = [
        roll.map(angle).or(lateral.map(lean)).unwrap_or(own_roll),
        pitch.map(angle).or(linear.map(|it| -lean(it))).unwrap_or(own_pitch),
    ];
    Some(Order::Flight(flight))
}
