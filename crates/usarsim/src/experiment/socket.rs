//! A run of an experiment through the socket, with a server of its own and a client that uses only the wire.

use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use experiments::plan::{Plan, Run};
use experiments::run::{Outcome, Prepared, RunError, measure, prepare};
use gamebots_client::Client;
use gamebots_proto::message::{Message, Reading, Sen};
use gamebots_proto::{Command, Dialect};
use gamebots_server::{Config, Listener, Ready, Service};
use recorder::Record;
use scene::{JointState, Pose};

/// Longest wait for a line of the server.
const PATIENCE: Duration = Duration::from_secs(30);
/// Tolerance of times on the wire, which have four decimals, s.
const TIME_TOLERANCE: f64 = 1e-4;

/// Executes a run through the socket and logs it. Poses come from the wire, rounded to a millimetre.
///
/// # Errors
/// If something does not load, the server does not start, or the robot does not report its pose.
pub(super) fn run(plan: &Plan, run: &Run, log: &Path, real_time_factor: f64) -> Result<Outcome, RunError> {
    let refuse = |reason: &dyn std::fmt::Display| RunError::Setup { id: run.id.clone(), reason: reason.to_string() };
    let Prepared { world, options, init, lines } = prepare(plan, run)?;
    // UDK's dialect has poses to a millimetre, the other one to a centimetre.
    let listeners = vec![Listener::new(Service::Controllers { dialect: Some(Dialect::Udk) }, 0)];
    let config = Config { options, listeners, real_time_factor, log: Some(log.to_owned()), ..Config::new(world) };
    let (ready, address) = mpsc::channel();
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let server = std::thread::spawn(move || {
        let shutdown = async { drop(stopped.await) };
        let ready = |addresses: Ready| {
            // The receiver waits for it below.
            let _ = ready.send(addresses.controllers());
        };
        gamebots_server::run(config, ready, shutdown)
    });
    let driven = address.recv().ok().flatten().map(|address| {
        let mut client = Client::connect(address).map_err(|error| refuse(&error))?;
        drive(plan, run, &mut client, &Command::Init(init).write().to_string(), &lines)
            .map_err(|reason| refuse(&reason))
    });
    drop(stop);
    let served = server.join().map_err(|_| refuse(&"the server panicked"))?;
    served.map_err(|error| refuse(&error))?;
    let Some(driven) = driven else { return Err(refuse(&"the server did not start")) };
    let Driven { poses, from, to } = driven?;
    let log = recorder::read(log).map_err(|error| refuse(&error))?;
    Ok(Outcome {
        id: run.id.clone(),
        labels: run.labels.clone(),
        seed: options.seed,
        steps: measure(&run.setup, &poses),
        wheels_turned: wheels_turned(&log, from, to),
        digest: log.end.get("digest").cloned().unwrap_or_default(),
        seconds: log.end.get("seconds").and_then(|seconds| seconds.parse().ok()).unwrap_or_default(),
    })
}

struct Driven {
    poses: Vec<Pose>,
    /// Simulated times of the first and the last pose, s.
    from: f64,
    to: f64,
}

/// Drives as Iridium did: lines are sent at their times after the first reading that counts, by the time on the wire.
fn drive(plan: &Plan, run: &Run, client: &mut Client, init: &str, lines: &[(f64, String)]) -> Result<Driven, String> {
    let said = |error: std::io::Error| error.to_string();
    client.send(init).map_err(said)?;
    let mut lines = lines.iter().peekable();
    let wanted = run.setup.steps() as usize + 1;
    let every = run.readings_a_step();
    let (mut poses, mut readings, mut from) = (Vec::new(), 0, None);
    let deadline = plan.settling + run.setup.interval() * f64::from(run.setup.steps()) + 60.0;
    loop {
        let line = client.next_line(PATIENCE).map_err(said)?.ok_or("the server sends nothing any more")?;
        let Some(Message::Sen(Sen { time: Some(time), reading, .. })) = Message::read(&line) else { continue };
        let time = f64::from(time);
        if time > deadline {
            return Err("no ground truth at 10 Hz: expected a robot that has the sensor".to_owned());
        }
        if let Reading::GroundTruth(truth) = reading
            && (from.is_some() || time >= plan.settling - TIME_TOLERANCE)
        {
            from.get_or_insert(time);
            if readings % every == 0 {
                poses.push(scene::pose(truth.location.map(f64::from), truth.orientation.map(f64::from)));
            }
            readings += 1;
        }
        let Some(from) = from else { continue };
        if poses.len() == wanted {
            return Ok(Driven { poses, from, to: time });
        }
        while let Some((_, line)) = lines.next_if(|(at, _)| time - from >= at - TIME_TOLERANCE) {
            client.send(line).map_err(said)?;
        }
    }
}

/// Returns the mean angle that the driven wheels turned between two times, rad. Both directions count as positive.
fn wheels_turned(log: &recorder::Log, from: f64, to: f64) -> f64 {
    let robots = log.scene().map(|scene| scene.robots).unwrap_or_default();
    let states: Vec<Vec<JointState>> = log
        .entries
        .iter()
        .filter_map(|entry| match &entry.record {
            Record::State(state) if (from..=to).contains(&entry.time) => {
                let [wheels, _] = state.wheels_and_others(robots.get(&state.class));
                Some(wheels)
            }
            _ => None,
        })
        .collect();
    let turned = states.windows(2).flat_map(|pair| pair[0].iter().zip(&pair[1]));
    let turned = turned.map(|(from, to)| (to.position - from.position).abs());
    turned.sum::<f64>() / states.first().map_or(1, |wheels| wheels.len().max(1)) as f64
}
