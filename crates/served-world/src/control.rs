//! Requests of viewers to the world itself: pause, speed, restart, save.

use page_protocol::{Actor, Control};
use scene::PawnId;
use sim_core::World;
use tracing::info;
use web_time::{Duration, Instant};

use crate::audience::{Audience, Told};
use crate::pace::Pace;
use crate::restart::{Change, Restart, Task};
use crate::served::ServedWorld;

/// Longest time in which robots are put back together after a restart. The rest of them are put back as INIT lines are executed, so that
/// steps go on.
const PUT_BACK_TOGETHER: Duration = Duration::from_millis(20);

impl<A: Audience> ServedWorld<A> {
    /// Executes a viewer's request to the world, and tells everyone who made it.
    pub(crate) fn control(&mut self, control: Control, actor: Actor) {
        let now = (self.clock)();
        let Actor(name) = &actor;
        if self.controls.allow(now, "control") {
            info!(?control, by = name, time = %format_args!("{:.3}", self.sessions.world().time()), "control");
        }
        let before = self.timing;
        let was_paused = before.paused;
        let done = match control {
            Control::Pause(paused) => {
                (self.timing.paused, self.timing.steps) = (paused, 0);
                let done = if paused { "paused the world" } else { "resumed the world" };
                (paused != was_paused).then(|| done.to_owned())
            }
            Control::Step(steps) => {
                self.timing.paused = true;
                self.timing.steps = self.timing.steps.saturating_add(steps);
                (!was_paused).then(|| "paused the world to step".to_owned())
            }
            Control::Speed(speed) => {
                self.timing.speed = speed;
                self.circle.clients.values().for_each(|client| client.set_paced(self.timing.is_real()));
                let speed = if speed == 0.0 { "as fast as possible".to_owned() } else { format!("{speed}") };
                Some(format!("set the real-time factor to {speed}"))
            }
            Control::Map(_) | Control::Scenario(_) if self.sessions.world().def().is_contest() => {
                self.tell(&Told::Notice("not done: a league stays on its map"));
                None
            }
            Control::Save if self.sessions.world().def().league.is_some() => {
                let text = "not done: the points of a league or a scenario cannot be saved";
                self.tell(&Told::Notice(text));
                None
            }
            Control::Remove(robot) => self.remove(PawnId(robot)).map(|name| format!("removed robot {robot} ({name})")),
            Control::Reset => {
                self.restarts.ask(Restart { change: None, actor });
                return;
            }
            Control::Map(name) => {
                self.restarts.ask(Restart { change: Some(Change::Map(name)), actor });
                return;
            }
            Control::Scenario(name) => {
                self.restarts.ask(Restart { change: Some(Change::Scenario(name)), actor });
                return;
            }
            Control::Save => {
                self.saving.ask();
                None
            }
            Control::Record(on) => {
                if !on && let Some(standings) = self.sessions.standings() {
                    self.tell(&Told::Standings(&standings));
                }
                self.circle.audience.record(self.sessions.world(), on);
                None
            }
        };
        if let Some(done) = done {
            self.tell_done(&actor, &done);
        }
        if self.timing != before {
            self.pace = Pace::new(self.timing.speed, now, self.sessions.world().time());
        }
        self.tell(&Told::Changed);
    }

    /// Tells everyone what somebody did.
    fn tell_done(&mut self, Actor(name): &Actor, done: &str) {
        let text = format!("{name} {done}");
        self.tell(&Told::Note(&text));
        self.tell(&Told::Notice(&text));
    }

    /// Removes a robot from the world. Returns its class and name, or `None` if there is no such robot.
    fn remove(&mut self, robot: PawnId) -> Option<String> {
        let Self { sessions, circle, .. } = self;
        let named = sessions.world().robots().find(|(id, ..)| *id == robot);
        let Some(name) = named.map(|(_, class, name)| format!("{class} {name}").trim().to_owned()) else {
            let text = format!("not done: there is no robot {}", robot.0);
            self.tell(&Told::Notice(&text));
            return None;
        };
        sessions.remove(robot, &mut |world, news| circle.hear(world, news));
        Some(name)
    }

    /// Begins a save if one is due.
    pub(crate) fn begin_save(&mut self, now: Instant) {
        if !self.saving.begin(now) {
            return;
        }
        let world = self.sessions.world();
        match world.save() {
            Ok(state) => {
                let (scene, time) = (world.scene().clone(), world.time());
                self.tasks.push(Task::Save { scene, state: Box::new(state), time });
            }
            Err(error) => {
                self.saving.end();
                self.tell(&Told::Notice(&format!("not saved: {error}")));
            }
        }
    }

    /// Tells of a save that has ended.
    pub(crate) fn saved(&mut self, outcome: &Result<String, String>) {
        self.saving.end();
        self.saves += u64::from(outcome.is_ok());
        let (Ok(text) | Err(text)) = outcome;
        self.tell(&Told::Notice(text));
    }

    /// Begins to make a fresh world if a restart is due.
    pub(crate) fn begin_restart(&mut self, now: Instant) {
        if let Some(Restart { change, .. }) = self.restarts.begin(now) {
            let world = self.sessions.world();
            let (scene, options) = (world.scene().clone(), world.options());
            self.tasks.push(Task::Make { scene, options, change: change.clone() });
        }
    }

    /// Restarts with a fresh world.
    pub(crate) fn restart(&mut self, fresh: Result<Box<World>, String>) {
        let now = (self.clock)();
        let Some(Restart { change, actor }) = self.restarts.made(now) else { return };
        match fresh {
            Err(why) => self.tell(&Told::Notice(&why)),
            Ok(fresh) => {
                if !self.start_over(now, *fresh) {
                    return;
                }
                let done = match change {
                    None => "reset the world".to_owned(),
                    Some(Change::Map(name)) => format!("changed the map to {name}"),
                    Some(Change::Scenario(name)) => format!("began the scenario {name}"),
                };
                self.tell_done(&actor, &done);
                self.pace = Pace::new(self.timing.speed, (self.clock)(), self.sessions.world().time());
            }
        }
    }

    /// Replaces the world with a fresh one. Connected clients get their robots back at their first poses, in the same order. Robots that
    /// take long wait for their client's turn. Returns false if a log does not allow it.
    fn start_over(&mut self, now: Instant, fresh: World) -> bool {
        if let Err(error) = self.circle.audience.may_start_over() {
            self.tell(&Told::Warning(&format!("not reset: {error}")));
            return false;
        }
        self.conclude();
        let Self { sessions, circle, clock, .. } = self;
        let (old, inits) = sessions.replace_world(fresh);
        circle.audience.start_over(&old, sessions.world());
        self.resets += 1;
        let start = clock();
        for (id, init) in inits {
            if clock() - start < PUT_BACK_TOGETHER {
                sessions.take(id, &init, &mut |world, news| circle.hear(world, news));
            } else if let Some(client) = circle.clients.get_mut(&id) {
                client.put_back(init);
            }
        }
        drop(old);
        self.restarts.add_cost(clock() - now);
        true
    }
}
