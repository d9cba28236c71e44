//! A subscriber: a listener of the world, such as a log or the viewers.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use recorder::{PictureTaken, Record, RecordError};
use scene::{Snapshot, Standings};
use sessions::News;
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

/// Something that subscribers are told.
#[derive(Debug)]
pub(crate) enum Told<'a> {
    /// News of the sessions.
    News(&'a News<'a>),
    /// A warning about the world, in words.
    Warning(&'a str),
    /// A warning for logs alone. Viewers see it in their status.
    Note(&'a str),
    /// The outcome of a request, in words, for viewers alone.
    Notice(&'a str),
    /// Every team's points when a log ends.
    Standings(&'a Standings),
    /// Every team's points at the end of the world.
    Result(&'a Standings),
    /// A picture of a robot's camera and its PNG file.
    Picture(&'a PictureTaken, &'a [u8]),
    /// A change of the status: a client arrived, or the timing changed.
    Changed,
}

impl Told<'_> {
    /// Returns the record of it; `None` if logs have none.
    pub(crate) fn record(&self) -> Option<Record> {
        match self {
            Self::News(news) => logbook::record(news),
            Self::Warning(text) | Self::Note(text) => Some(Record::Warning((*text).to_owned())),
            Self::Standings(standings) | Self::Result(standings) => {
                Some(Record::Standings(Box::new((*standings).clone())))
            }
            Self::Picture(taken, png) => Some(Record::Picture(**taken, png.to_vec())),
            Self::Notice(_) | Self::Changed => None,
        }
    }
}

/// A listener of the world. A new one needs an entry in the list of the world's thread, and nothing else.
pub(crate) trait Subscriber: Send {
    /// Hears of an event.
    fn hear(&mut self, moment: &mut Moment, event: &Told);

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
    pub(crate) png: Vec<u8>,
}
