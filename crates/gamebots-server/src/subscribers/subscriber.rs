//! A subscriber: a listener of the world, such as a log or the viewers.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use recorder::{PictureTaken, Record, RecordError};
use scene::Snapshot;
use served_world::Told;
use sim_core::World;

use crate::subscribers::present::Present;

/// The world at a moment.
pub(crate) struct Moment<'a> {
    pub(crate) world: &'a World,
    /// Real time.
    pub(crate) now: Instant,
    /// True if a subscriber keeps records.
    pub(crate) is_recorded: bool,
    pub(crate) present: &'a mut Present,
}

impl Moment<'_> {
    /// Returns the snapshot of the world, which all subscribers share.
    pub(crate) fn snapshot(&mut self) -> Arc<Snapshot> {
        self.present.of(self.world)
    }
}

/// Returns the record of what is told; `None` if logs have none.
pub(crate) fn record_of(told: &Told) -> Option<Record> {
    match told {
        Told::News(news) => logbook::record(news),
        Told::Warning(text) | Told::Note(text) => Some(Record::Warning((*text).to_owned())),
        Told::Standings(standings) | Told::Result(standings) => Some(Record::Standings(Box::new((*standings).clone()))),
        Told::Notice(_) | Told::Changed => None,
    }
}

/// A listener of the world. A new one needs an entry in the list of `run.rs`, and nothing else.
pub(crate) trait Subscriber: Send {
    /// Hears of an event.
    fn hear(&mut self, moment: &mut Moment, event: &Told);

    /// Sees a picture of a robot's camera for logs.
    fn see(&mut self, _: &mut Moment, _: &Shot) {}

    /// True if it keeps records now. Pictures for logs are drawn only if somebody does.
    fn keeps_records(&self) -> bool {
        false
    }

    /// Hears of the end of a step. Returns pictures that all are to hear of.
    fn stepped(&mut self, _: &mut Moment) -> Vec<Shot> {
        Vec::new()
    }

    /// Publishes what is due by the clock; called often. Returns notices for viewers.
    fn publish(&mut self, _: &mut Moment) -> Vec<String> {
        Vec::new()
    }

    /// Follows the world of this moment, which replaces the old one. Returns notices for viewers.
    fn start_over(&mut self, _: &mut Moment, _old: &World) -> Vec<String> {
        Vec::new()
    }

    /// Ends, because the world has ended, by a panic if there is a reason. Returns the report of the panic, if it wrote one.
    fn end(&mut self, _: &mut Moment, _panic: Option<&str>) -> Option<Result<PathBuf, RecordError>> {
        None
    }
}

/// A picture of a robot's camera for logs.
pub(crate) struct Shot {
    pub(crate) taken: PictureTaken,
    /// Its PNG file.
    pub(crate) png: Vec<u8>,
}

impl Shot {
    /// Returns the record of it.
    pub(crate) fn record(&self) -> Record {
        Record::Picture(self.taken, self.png.clone())
    }
}
