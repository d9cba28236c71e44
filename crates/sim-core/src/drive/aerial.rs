//! A robot in the air: `{LinearVelocity f} {LateralVelocity f} {AltitudeVelocity f}`, m/s, up being positive,
//! `{RotationalVelocity f}`, degrees a second, `{PitchAngle f} {RollAngle f}`, degrees; any of them, each held until it is replaced
//! (AerialVehicle.uc:61-215). `{Normalized true}` makes those of its own line percent of the greatest. Moving ahead or aside leans
//! by the greatest angle, whatever the speed; what the line says of pitch and roll wins. Every value is held within the class's
//! limit, normalized or not; the original holds none of them.
//!
//! Spins of propellers (`{Spin1 f} {Spin2 f}`) move nothing in USARSim either and are not looked at.

use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use scene::{Aerial, RobotDef};

use crate::flight::Flight;

pub(super) fn apply(flight: &mut Flight, robot: &RobotDef, drive: &Drive, problems: &mut Vec<Problem>) {
    let Some(Aerial { max_velocity, max_turn, max_tilt }) = robot.aerial else { return };
    let normalized = drive.normalized == Some(true);
    let share = |value: f64, limit: f64| {
        let value = if normalized { value / 100.0 * limit } else { value };
        value.clamp(-limit, limit)
    };
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
    // Nose down is a negative pitch.
    flight.attitude = [
        roll.map(angle).or(lateral.map(lean)).unwrap_or(own_roll),
        pitch.map(angle).or(linear.map(|it| -lean(it))).unwrap_or(own_pitch),
    ];
}
