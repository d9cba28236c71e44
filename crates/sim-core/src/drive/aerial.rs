//! A robot in the air: `{LinearVelocity f} {LateralVelocity f} {AltitudeVelocity f}`, m/s, up being positive,
//! `{RotationalVelocity f}`, degrees a second, `{PitchAngle f} {RollAngle f}`, degrees; any of them, each held until it is replaced
//! (AerialVehicle.uc:61-215). `{Normalized true}` makes those of its own line percent of the greatest. Moving ahead or aside leans
//! by the greatest angle, whatever the speed; what the line says of pitch and roll wins.
//!
//! Spins of propellers (`{Spin1 f} {Spin2 f}`) move nothing in USARSim either and are not looked at.

use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use scene::{Aerial, RobotDef};

use crate::flight::Flight;

pub(super) fn apply(flight: &mut Flight, robot: &RobotDef, drive: &Drive, problems: &mut Vec<Problem>) {
    let Some(Aerial { max_velocity, max_turn, max_tilt }) = robot.aerial else { return };
    let normalized = drive.normalized == Some(true);
    let share = |value: f64, limit: f64| if normalized { value / 100.0 * limit } else { value };
    let [linear, lateral, altitude, turn, pitch, roll] = drive.numbers(
        ["LinearVelocity", "LateralVelocity", "AltitudeVelocity", "RotationalVelocity", "PitchAngle", "RollAngle"],
        problems,
    );
    for ((held, given), limit) in flight.velocity.iter_mut().zip([linear, lateral, altitude]).zip(max_velocity) {
        *held = given.map_or(*held, |given| share(given, limit));
    }
    flight.turn = turn.map_or(flight.turn, |turn| if normalized { share(turn, max_turn) } else { turn.to_radians() });
    let lean = |velocity: f64| if velocity == 0.0 { 0.0 } else { max_tilt * velocity.signum() };
    let angle = |degrees: f64| if normalized { share(degrees, max_tilt) } else { degrees.to_radians() };
    let [own_roll, own_pitch] = flight.attitude;
    // Nose down is a negative pitch.
    flight.attitude = [
        roll.map(angle).or(lateral.map(lean)).unwrap_or(own_roll),
        pitch.map(angle).or(linear.map(|it| -lean(it))).unwrap_or(own_pitch),
    ];
}
