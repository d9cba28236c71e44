//! `usarsim teleop`.

use std::io::{IsTerminal, Read, Write};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use crossterm::terminal;
use gamebots_client::Client;
use gamebots_proto::Line;

use crate::{Failure, connect, exit, print};

/// Options of `teleop`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim teleop\n  usarsim teleop 192.168.1.7:3000 --robot P3AT --start RobotStart1\n\n\
    Keys: w s ahead and back, a d aside (Mecanum and aerial robots), q e or the arrows turn or steer, r f up and down (aerial\n\
    robots), space stops, + - change the speed, x or Ctrl-C ends. A terminal does not tell when a key is let go of: the robot stops 0.7 s after the last one."
)]
pub(crate) struct Arguments {
    /// The server.
    #[arg(value_name = "HOST:PORT", default_value = "127.0.0.1:3000")]
    address: String,
    /// Class of the robot that is put on the map.
    #[arg(long, value_name = "CLASS", default_value = "KUKA_YouBot")]
    robot: String,
    /// Start pose by its name on the map.
    #[arg(long, default_value = "PlayerStart_0")]
    start: String,
    /// Name of the robot.
    #[arg(long, default_value = "Teleop")]
    name: String,
}

/// The robot stops so long after the last key: longer than a keyboard takes to repeat the first.
const HOLD: Duration = Duration::from_millis(700);
/// How often the server is listened to.
const POLL: Duration = Duration::from_millis(20);
/// How long a line may take that is already here.
const GLANCE: Duration = Duration::from_millis(1);
/// Longest time for the first answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// Percent of the limits at first, and by which a key changes it.
const SPEED: f64 = 40.0;
const SPEED_STEP: f64 = 10.0;

/// A key that means something.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Key {
    /// Ahead, to the right, clockwise, up: -1, 0 or 1.
    Move([f64; 4]),
    /// Percent more.
    Faster(f64),
    End,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let lost = |error: std::io::Error| Failure::new(exit::UNAVAILABLE, format_args!("the connection is lost: {error}"));
    let mut client = connect::connect(&arguments.address)?;
    let Arguments { robot, start, name, .. } = arguments;
    client.send(&format!("INIT {{ClassName USARBot.{robot}}} {{Name {name}}} {{Start {start}}}")).map_err(lost)?;
    client.send("GETCONF {Type Robot}").map_err(lost)?;
    let steering = steering(&mut client)?;
    let raw = RawTerminal::enter();
    let (sender, keys) = mpsc::channel();
    std::thread::spawn(move || {
        std::io::stdin().lock().bytes().map_while(Result::ok).try_for_each(|byte| sender.send(byte))
    });
    let result = drive(&mut client, &keys, steering).map_err(lost);
    drop(raw);
    print("");
    result
}

/// What a robot takes, by its configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Steering {
    Skid,
    Omni,
    /// With the greatest angles of front and rear, rad.
    Ackermann([f64; 2]),
    Aerial,
}

impl Steering {
    fn of(conf: &Line) -> Self {
        // The range of an axle goes to both sides; one that does not steer says 6.28.
        let most = |key| {
            let range: f64 = conf.get(key).and_then(|range| range.parse().ok()).unwrap_or(0.0);
            if range < 6.0 { range / 2.0 } else { 0.0 }
        };
        match conf.get("SteeringType") {
            Some("OmniDrive") => Self::Omni,
            Some("AckermanSteered") => Self::Ackermann([most("MaxFrontSteer"), most("MaxRearSteer")]),
            None => Self::Aerial,
            Some(_) => Self::Skid,
        }
    }
}

/// How the robot is steered, by its configuration; or why there is no robot.
fn steering(client: &mut Client) -> Result<Steering, Failure> {
    let end = Instant::now() + PATIENCE;
    let mut first_error = None;
    while let Ok(Some(line)) = client.next_line(end.saturating_duration_since(Instant::now())) {
        if line.starts_with("CONF ") {
            return Ok(Steering::of(&Line::parse(&line)));
        }
        if let Some(error) = line.strip_prefix("NFO {Error ").and_then(|error| error.strip_suffix('}')) {
            if error.starts_with("GETCONF ignored") {
                break;
            }
            first_error.get_or_insert_with(|| error.to_owned());
        }
    }
    let reason = first_error.unwrap_or_else(|| "the server does not answer".to_owned());
    let hint = "`usarsim robots` lists the classes";
    Err(Failure::new(exit::FAILURE, format_args!("no robot was made: {reason}; {hint}")))
}

/// Keys to DRIVE lines, until the end.
fn drive(client: &mut Client, keys: &Receiver<u8>, steering: Steering) -> std::io::Result<()> {
    let (mut percent, mut motion, mut since) = (SPEED, [0.0; 4], Instant::now());
    let (mut sent, mut pose, mut pending) = (String::new(), String::from("waiting for GroundTruth"), Vec::new());
    loop {
        match keys.recv_timeout(POLL) {
            Ok(byte) => pending.push(byte),
            Err(RecvTimeoutError::Timeout) => pending.clear(),
            Err(RecvTimeoutError::Disconnected) if motion == [0.0; 4] => return Ok(()),
            // The last key of a file is held as long as any other.
            Err(RecvTimeoutError::Disconnected) => std::thread::sleep(POLL),
        }
        match key(&pending) {
            Some(Key::Move(wanted)) => (motion, since) = (wanted, Instant::now()),
            Some(Key::Faster(more)) => percent = (percent + more).clamp(SPEED_STEP, 100.0),
            Some(Key::End) => return client.send(&command([0.0; 4], 0.0, steering)),
            None => {}
        }
        if key(&pending).is_some() {
            pending.clear();
        }
        if since.elapsed() > HOLD {
            motion = [0.0; 4];
        }
        let line = command(motion, percent, steering);
        if line != sent {
            client.send(&line)?;
            sent = line;
        }
        while let Some(line) = client.next_line(GLANCE)? {
            if line.contains("{Type GroundTruth}") {
                let parsed = Line::parse(&line);
                let [place, turn] =
                    ["Location", "Orientation"].map(|key| parsed.get(key).unwrap_or_default().to_owned());
                pose = format!("x,y,z {place} m   roll,pitch,yaw {turn} rad");
            }
        }
        print!("\r\x1b[2K{percent:3.0} %  {pose}");
        std::io::stdout().flush()?;
    }
}

/// In percent of the limits, so that the unit of wheel speeds does not matter.
fn command([ahead, right, clockwise, up]: [f64; 4], percent: f64, steering: Steering) -> String {
    match steering {
        Steering::Omni | Steering::Aerial => {
            let [ahead, right, clockwise, up] = [ahead, right, clockwise, up].map(|part| part * percent);
            let up = if steering == Steering::Aerial { format!(" {{AltitudeVelocity {up}}}") } else { String::new() };
            format!(
                "DRIVE {{Normalized true}} {{LinearVelocity {ahead}}} {{LateralVelocity {right}}} \
                 {{RotationalVelocity {clockwise}}}{up}"
            )
        }
        Steering::Ackermann([front, rear]) => {
            let (speed, front, rear) = (ahead * percent, clockwise * front, -clockwise * rear);
            format!("DRIVE {{Normalized true}} {{Speed {speed}}} {{FrontSteer {front:.3}}} {{RearSteer {rear:.3}}}")
        }
        Steering::Skid => {
            let [left, right] = [ahead + clockwise, ahead - clockwise].map(|part| part * percent);
            format!("DRIVE {{Normalized true}} {{Left {left}}} {{Right {right}}}")
        }
    }
}

/// What has been pressed; `None` while it may become an arrow, or means nothing.
fn key(bytes: &[u8]) -> Option<Key> {
    Some(match bytes {
        b"w" | b"W" | b"\x1b[A" => Key::Move([1.0, 0.0, 0.0, 0.0]),
        b"s" | b"S" | b"\x1b[B" => Key::Move([-1.0, 0.0, 0.0, 0.0]),
        b"a" | b"A" => Key::Move([0.0, -1.0, 0.0, 0.0]),
        b"d" | b"D" => Key::Move([0.0, 1.0, 0.0, 0.0]),
        b"q" | b"Q" | b"\x1b[D" => Key::Move([0.0, 0.0, -1.0, 0.0]),
        b"e" | b"E" | b"\x1b[C" => Key::Move([0.0, 0.0, 1.0, 0.0]),
        b"r" | b"R" => Key::Move([0.0, 0.0, 0.0, 1.0]),
        b"f" | b"F" => Key::Move([0.0, 0.0, 0.0, -1.0]),
        b"+" | b"=" => Key::Faster(SPEED_STEP),
        b"-" | b"_" => Key::Faster(-SPEED_STEP),
        b"x" | b"X" | b"\x03" | b"\x04" => Key::End,
        b"\x1b" | b"\x1b[" => return None,
        [] => return None,
        _ => Key::Move([0.0; 4]),
    })
}

/// A terminal that gives each key at once, until it is dropped.
struct RawTerminal(bool);

impl RawTerminal {
    fn enter() -> Self {
        Self(std::io::stdin().is_terminal() && terminal::enable_raw_mode().is_ok())
    }
}

impl Drop for RawTerminal {
    fn drop(&mut self) {
        if self.0 {
            // There is nothing else that could be done.
            let _ = terminal::disable_raw_mode();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_told_apart() {
        for (bytes, expected) in [
            (&b"w"[..], Some(Key::Move([1.0, 0.0, 0.0, 0.0]))),
            (b"\x1b[C", Some(Key::Move([0.0, 0.0, 1.0, 0.0]))),
            (b"\x1b", None),
            (b"\x1b[", None),
            (b" ", Some(Key::Move([0.0; 4]))),
            (b"+", Some(Key::Faster(10.0))),
            (b"\x03", Some(Key::End)),
        ] {
            assert_eq!(key(bytes), expected, "{bytes:?}");
        }
    }

    #[test]
    fn commands_are_of_the_robot() {
        let check = |motion, percent, conf: &str, expected: &str| {
            let steering = Steering::of(&Line::parse(conf));
            assert_eq!(command(motion, percent, steering), format!("DRIVE {{Normalized true}} {expected}"), "{conf}");
        };
        let (ahead, aside, turn, up) =
            ([1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
        check(ahead, 40.0, "CONF {SteeringType SkidSteered}", "{Left 40} {Right 40}");
        let velocities = "{LinearVelocity 0} {LateralVelocity 25} {RotationalVelocity 0}";
        check(aside, 25.0, "CONF {SteeringType OmniDrive}", velocities);
        let car = "CONF {SteeringType AckermanSteered} {MaxFrontSteer 1.0000} {MaxRearSteer 6.2800}";
        check(turn, 40.0, car, "{Speed 40} {FrontSteer 0.500} {RearSteer -0.000}");
        let climb = "{LinearVelocity 0} {LateralVelocity 0} {RotationalVelocity 0} {AltitudeVelocity 40}";
        check(up, 40.0, "CONF {Name AirRobot}", climb);
    }
}
