//! The publisher of all that happens, to the list of subscribers. Nothing is published elsewhere.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use page_protocol::Status;
use recorder::RecordError;
use served_world::{Actors, Audience, Told};
use sessions::News;
use sim_core::World;

use crate::subscribers::live::Broadcast;
use crate::subscribers::log::Recording;
use crate::subscribers::present::Present;
use crate::subscribers::subscriber::{Moment, Shot, Subscriber};

/// The subscribers. Two of them take requests, too: the log starts and ends, and viewers get the status.
pub(crate) struct Publisher {
    log: Recording,
    live: Broadcast,
    others: Vec<Box<dyn Subscriber>>,
    present: Present,
    /// Real time of the last turn.
    now: Instant,
}

impl Publisher {
    pub(crate) fn new(log: Recording, live: Broadcast, others: Vec<Box<dyn Subscriber>>, now: Instant) -> Self {
        Self { log, live, others, present: Present::default(), now }
    }

    /// Ends all subscribers, because of a panic if there is a reason. Returns the report of the panic, if one was written.
    pub(crate) fn end(mut self, world: &World, panic: Option<&str>) -> Option<Result<PathBuf, RecordError>> {
        let mut report = None;
        self.each(world, |subscriber, moment| report = subscriber.end(moment, panic).or(report.take()));
        report
    }

    /// Tells all of the notices that each subscriber returns.
    fn notices(&mut self, world: &World, mut act: impl FnMut(&mut dyn Subscriber, &mut Moment) -> Vec<String>) {
        let mut notices = Vec::new();
        self.each(world, |subscriber, moment| notices.extend(act(subscriber, moment)));
        notices.iter().for_each(|text| self.hear(world, &Told::Notice(text)));
    }

    /// Does something with each subscriber.
    fn each(&mut self, world: &World, mut act: impl FnMut(&mut dyn Subscriber, &mut Moment)) {
        let Self { log, live, others, present, now } = self;
        let is_recorded = log.keeps_records() || others.iter().any(|other| other.keeps_records());
        let mut moment = Moment { world, now: *now, is_recorded, present };
        act(live, &mut moment);
        act(log, &mut moment);
        others.iter_mut().for_each(|other| act(&mut **other, &mut moment));
    }
}

impl Audience for Publisher {
    fn set_now(&mut self, now: Instant) {
        self.now = now;
    }

    fn hear(&mut self, world: &World, event: &Told) {
        match event {
            Told::News(News::Received { .. } | News::Came(_) | News::Left(_) | News::Lost(_)) | Told::Changed => {
                self.present.forget();
            }
            Told::News(
                News::Wrong { .. }
                | News::Sensed(_)
                | News::Sent { .. }
                | News::Closed(_)
                | News::Restored { .. }
                | News::Scored(_)
                | News::TimeUp(_),
            )
            | Told::Warning(_)
            | Told::Note(_)
            | Told::Notice(_)
            | Told::Standings(_)
            | Told::Result(_) => {}
        }
        self.each(world, |subscriber, moment| subscriber.hear(moment, event));
    }

    fn stepped(&mut self, world: &World) {
        let mut shots: Vec<Shot> = Vec::new();
        self.each(world, |subscriber, moment| shots.extend(subscriber.stepped(moment)));
        shots.iter().for_each(|shot| self.each(world, |subscriber, moment| subscriber.see(moment, shot)));
    }

    fn publish(&mut self, world: &World, status: &mut dyn FnMut() -> Status) {
        if let Some(due) = self.live.due(self.now) {
            let recording = || self.log.path().map(|path| path.display().to_string());
            let status = due.status.then(|| Status { recording: recording(), ..status() });
            self.live.publish(self.now, world.def(), &self.present.of(world), status);
        }
        self.notices(world, |subscriber, moment| subscriber.publish(moment));
    }

    fn record(&mut self, world: &World, on: bool) {
        if !on {
            return self.log.stop(world);
        }
        match self.log.start_unnamed(self.now, world) {
            Ok(()) => {
                let text = self.log.path().map(|path| format!("recording to {}", path.display()));
                text.iter().for_each(|text| self.hear(world, &Told::Notice(text)));
            }
            Err(error) => self.hear(world, &Told::Warning(&error.to_string())),
        }
    }

    fn actors(&mut self, world: &World) -> Arc<Actors> {
        self.present.actors(world)
    }

    fn may_start_over(&self) -> Result<(), String> {
        self.log.may_start_over(self.now).map_err(|error| error.to_string())
    }

    fn start_over(&mut self, old: &World, new: &World) {
        self.present.forget();
        self.notices(new, |subscriber, moment| subscriber.start_over(moment, old));
    }
}
