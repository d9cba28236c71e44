//! The state of a served world, for viewers and supervisors.

use page_protocol::{ClientStatus, LeagueStatus, RobotStatus, Status};
use scene::PawnId;
use sessions::SessionId;

use crate::audience::Audience;
use crate::client::Client;
use crate::question::Health;
use crate::served::{Circle, ServedWorld};

impl<A: Audience> ServedWorld<A> {
    /// Returns the state in numbers.
    pub(crate) fn health(&self) -> Health {
        let Self { sessions, circle, timing, performance, resets, .. } = self;
        let world = sessions.world();
        Health {
            simulated: world.time(),
            real_time_factor: performance.real_time_factor,
            speed: timing.speed,
            paused: timing.paused,
            steps: performance.steps,
            step_seconds: performance.took.as_secs_f64(),
            solver: world.solver_effort(),
            robots: world.robots().count(),
            clients: circle.clients.len(),
            dropped_lines: performance.dropped + circle.clients.values().map(Client::dropped).sum::<u64>(),
            resets: *resets,
        }
    }

    /// Publishes what is due by the clock.
    pub(crate) fn publish(&mut self) {
        let Self { circle, sessions, timing, performance, resets, saves, .. } = self;
        let (Circle { audience, clients, .. }, world) = (circle, sessions.world());
        let robot = |(id, class, name): (PawnId, &str, &str)| RobotStatus {
            id: id.0,
            class: class.to_owned(),
            name: name.to_owned(),
            connection: sessions.owner(id),
            battery: world.battery(id),
        };
        let client = |(&connection, client): (&SessionId, &Client)| ClientStatus {
            connection,
            peer: client.peer(),
            lines: client.lines(),
            dropped: client.dropped(),
            waiting_bytes: client.waiting_bytes(),
        };
        audience.publish(world, &mut || Status {
            real_time_factor: performance.real_time_factor,
            speed: timing.speed,
            paused: timing.paused,
            scene: 0,
            objects: 0,
            viewers: 0,
            resets: *resets,
            saves: *saves,
            unsettled_steps: world.unsettled_steps(),
            recording: None,
            league: sessions.standings().map(LeagueStatus::new),
            robots: world.robots().map(robot).collect(),
            clients: clients.iter().map(client).collect(),
        });
    }
}
