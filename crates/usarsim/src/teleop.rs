//! `usarsim teleop`.

use std::io::{IsTerminal, Read, Write};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use crossterm::terminal;
use gamebots_client::Client;
use gamebots_proto::Line;
use gamebots_proto::message::{Message, Nfo};

use crate::connect::OwnToken;
use crate::terminal::printable;
use crate::{Failure, connect, exit, print};

/// Options of `teleop`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim teleop\n  usarsim teleop 192.168.1.7:3000 --robot P3AT --start RobotStart1\n\n\
    Keys: w s forward and backward, a d left and right (Mecanum and aerial robots), q e or the arrows turn or steer, r f up and \
    down (aerial robots), space stops, + - change the speed, x or Ctrl-C ends. A terminal does not report \
    released keys, so the robot stops 0.7 s after the last key."
)]
pub(crate) struct Arguments {
    /// The server.
    #[arg(value_name = "HOST:PORT", default_value = "127.0.0.1:3000")]
    address: String,
    /// Class of the robot to spawn.
    #[arg(long, value_name = "CLASS", default_value = "YouBotArm")]
    robot: String,
    /// Start pose by its name on the map; by default the map's first.
    #[arg(long, value_name = "NAME")]
    start: Option<String>,
    /// Name of the robot.
    #[arg(long, default_value = "Teleop")]
    name: String,
    #[command(flatten)]
    token: OwnToken,
}

/// Time after the last key at which the robot stops. A keyboard takes less to repeat the first key.
const HOLD: Duration = Duration::from_millis(700);
/// Interval at which the server is polled.
const POLL: Duration = Duration::from_millis(20);
/// Time to wait for a line that may have arrived already.
const GLANCE: Duration = Duration::from_millis(1);
/// Longest wait for the first answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// Speed at the start, percent of the limits; then the step of a key.
const SPEED: f64 = 40.0;
const SPEED_STEP: f64 = 10.0;

/// A key with a meaning.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Key {
    /// Motion ahead, to the right, clockwise and up: -1, 0 or 1 each.
    Move([f64; 4]),
    /// Change of the speed, percent.
    Faster(f64),
    End,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let lost = |error: std::io::Error| Failure::new(exit::UNAVAILABLE, format_args!("the connection is lost: {error}"));
    let mut client = connect::connect(&arguments.address, &arguments.token)?;
    let Arguments { robot, start, name, .. } = arguments;
    let start = match start {
        Some(start) => start.clone(),
        None => first_start(&mut client).map_err(lost)?,
    };
    client.send(&format!("INIT {{ClassName USARBot.{robot}}} {{Name {name}}} {{Start {start}}}")).map_err(lost)?;
    client.send("GETCONF {Type Robot}").map_err(lost)?;
    let (steering, warnings) = steering(&mut client, robot)?;
    warnings.iter().for_each(|warning| print(format_args!("WARNING {warning}")));
    print(format_args!("driving {robot} {name}\n{}", keys_of(steering)));
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

/// Steering of a robot, from its configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Steering {
    Skid,
    Omni,
    /// Largest angles of front and rear, rad.
    Ackermann([f64; 2]),
    Aerial,
}

impl Steering {
    fn of(conf: &Line) -> Self {
        // The range of an axle covers both sides. An axle that does not steer has 6.28.
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

/// Returns the first start of the map.
fn first_start(client: &mut Client) -> std::io::Result<String> {
    client.send("GETSTARTPOSES")?;
    let end = Instant::now() + PATIENCE;
    while let Some(line) = client.next_line(end.saturating_duration_since(Instant::now()))? {
        if let Some(Message::Nfo(Nfo::StartPoses(poses))) = Message::read(&line) {
            let first = poses.into_iter().next();
            return Ok(first.map_or_else(String::new, |pose| pose.name));
        }
    }
    Ok(String::new())
}

/// Returns the robot's steering, from its configuration, and errors of INIT. Fails with the reason if there is no robot.
fn steering(client: &mut Client, robot: &str) -> Result<(Steering, Vec<String>), Failure> {
    let end = Instant::now() + PATIENCE;
    let mut errors = Vec::new();
    while let Ok(Some(line)) = client.next_line(end.saturating_duration_since(Instant::now())) {
        if line.starts_with("CONF ") {
            return Ok((Steering::of(&Line::parse(&line)), errors));
        }
        if let Some(error) = error_in(&line) {
            if error.starts_with("GETCONF ignored") {
                break;
            }
            errors.push(error.to_owned());
        }
    }
    // USARSim does not answer to a class that it does not know.
    let reason = errors
        .into_iter()
        .next()
        .unwrap_or_else(|| "the server does not answer, as USARSim does for a class that it does not know".to_owned());
    Err(Failure::new(exit::FAILURE, format_args!("{robot} was not spawned: {reason}")))
}

/// Returns the error that our server reports in a line.
fn error_in(line: &str) -> Option<&str> {
    line.strip_prefix("NFO {Error ")?.strip_suffix('}')
}

/// Returns the help line for the keys of this robot.
fn keys_of(steering: Steering) -> String {
    let aside = if matches!(steering, Steering::Omni | Steering::Aerial) { "a d left, right   " } else { "" };
    let turn = if matches!(steering, Steering::Ackermann(_)) { "steer" } else { "turn" };
    let up = if steering == Steering::Aerial { "r f up, down   " } else { "" };
    format!("keys: w s forward, backward   {aside}q e {turn}   {up}space stop   + - speed   x end")
}

/// Converts keys to DRIVE lines, until the end.
fn drive(client: &mut Client, keys: &Receiver<u8>, steering: Steering) -> std::io::Result<()> {
    let (mut percent, mut motion, mut since) = (SPEED, [0.0; 4], Instant::now());
    let (mut sent, mut pose, mut pending) = (String::new(), String::from("waiting for GroundTruth"), Vec::new());
    loop {
        match keys.recv_timeout(POLL) {
            Ok(byte) => pending.push(byte),
            Err(RecvTimeoutError::Timeout) => pending.clear(),
            Err(RecvTimeoutError::Disconnected) if motion == [0.0; 4] => return Ok(()),
            // The last key of an input file is held as long as any other.
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
            if let Some(error) = error_in(&line) {
                print!("\r\x1b[2KWARNING {}\r\n", printable(error));
            } else if line.contains("{Type GroundTruth}") {
                pose = shown_pose(&Line::parse(&line));
            }
        }
        print!("\r\x1b[2Kspeed {percent:3.0} %   {:<10}   {pose}", name_of(motion));
        std::io::stdout().flush()?;
    }
}

/// Returns position and heading of a line of GroundTruth, as text.
fn shown_pose(line: &Line) -> String {
    let numbers = |key| -> Vec<f64> {
        line.get(key).unwrap_or_default().split(',').filter_map(|number| number.trim().parse().ok()).collect()
    };
    match (&numbers("Location")[..], &numbers("Orientation")[..]) {
        ([x, y, z], [_, _, yaw]) => format!("x {x:.2}  y {y:.2}  z {z:.2} m   heading {:.0}°", yaw.to_degrees()),
        _ => String::new(),
    }
}

fn name_of([forward, right, clockwise, up]: [f64; 4]) -> &'static str {
    let named = [
        (forward, ["backward", "forward"]),
        (right, ["left", "right"]),
        (clockwise, ["turn left", "turn right"]),
        (up, ["down", "up"]),
    ];
    let moved = named.into_iter().find(|(part, _)| *part != 0.0);
    moved.map_or("stopped", |(part, names)| names[usize::from(part > 0.0)])
}

/// Returns the DRIVE line, in percent of the limits, so the unit of wheel speeds does not matter.
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

/// Returns the key of the bytes read; `None` for an incomplete arrow key or an unknown key.
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

/// A terminal in raw mode, which gives each key at once. It is restored on drop.
struct RawTerminal(bool);

impl RawTerminal {
    fn enter() -> Self {
        Self(std::io::stdin().is_terminal() && terminal::enable_raw_mode().is_ok())
    }
}

impl Drop for RawTerminal {
    fn drop(&mut self) {
        if self.0 {
            // There is nothing else to do on a failure.
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
    fn what_is_shown_says_what_the_robot_does() {
        let line = Line::parse("SEN {Type GroundTruth} {Location 0.000,0.233,-0.019} {Orientation 0.000,0.000,1.571}");
        assert_eq!(shown_pose(&line), "x 0.00  y 0.23  z -0.02 m   heading 90°");
        assert_eq!(name_of([0.0, 0.0, -1.0, 0.0]), "turn left");
        assert_eq!(name_of([0.0; 4]), "stopped");
        assert!(keys_of(Steering::Omni).contains("a d left, right"));
        assert!(!keys_of(Steering::Skid).contains("a d"));
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
