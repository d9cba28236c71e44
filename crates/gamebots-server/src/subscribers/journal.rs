//! A journal of every request to a world since it began, kept only to reproduce a panic.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use recorder::{End, LogWriter, Record, RecordError};
use served_world::Told;
use sessions::News;
use sim_core::World;

use crate::subscribers::subscriber::{Moment, Subscriber, record_of};

/// Most memory of the journal, bytes: hours of a controller that sends fifty lines a second. Beyond it, the oldest entries are
/// lost.
const MAX_BYTES: usize = 16 * 1024 * 1024;

/// Received lines and ended connections, with their simulated times, s.
#[derive(Default)]
pub(crate) struct Journal {
    entries: VecDeque<(f64, Record)>,
    bytes: usize,
    /// Simulated time up to which entries were lost.
    lost_until: Option<f64>,
}

impl Journal {
    /// Creates the journal of a world. What happened to it before is lost.
    pub(crate) fn of(world: &World) -> Self {
        Self { lost_until: (!world.is_untouched()).then(|| world.time()), ..Self::default() }
    }

    pub(crate) fn add(&mut self, time: f64, record: Record) {
        self.bytes += record.size();
        self.entries.push_back((time, record));
        while self.bytes > MAX_BYTES
            && let Some((time, record)) = self.entries.pop_front()
        {
            self.bytes -= record.size();
            self.lost_until = Some(time);
        }
    }

    /// Writes a log in which `usarsim log replay` runs to the same panic. It includes the step that panicked. It has no digest,
    /// because nobody knows the state after that step.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn write(&self, folder: &Path, world: &World, panic: &str) -> Result<PathBuf, RecordError> {
        let name = |number: u32| folder.join(format!("usarsim-panic-{number}.mcap"));
        let path = (1..).map(name).find(|path| !path.exists()).unwrap_or_default();
        let mut description = vec![("panic".to_owned(), panic.to_owned())];
        description.extend(self.lost_until.map(|time| ("began".to_owned(), time.to_string())));
        let mut log = LogWriter::create(&path, world.def(), world.options(), &description)?;
        self.entries.iter().try_for_each(|(time, record)| log.write(*time, record))?;
        let (time, unsettled_steps) = (world.time() + world.time_step(), world.unsettled_steps());
        log.finish(End { time, digest: None, unsettled_steps, dropped: 0 })?;
        Ok(path)
    }
}

impl Subscriber for Journal {
    fn hear(&mut self, moment: &mut Moment, event: &Told) {
        if let Told::News(News::Received { .. } | News::Left(_) | News::Closed(_)) = event {
            record_of(event).into_iter().for_each(|record| self.add(moment.world.time(), record));
        }
    }

    fn start_over(&mut self, moment: &mut Moment, _: &World) -> Vec<String> {
        *self = Self::of(moment.world);
        Vec::new()
    }

    fn end(&mut self, moment: &mut Moment, panic: Option<&str>) -> Option<Result<PathBuf, RecordError>> {
        panic.map(|reason| self.write(Path::new(""), moment.world, reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use recorder::WireLine;

    #[test]
    fn the_oldest_lines_are_lost_and_that_is_known() {
        let mut journal = Journal::default();
        for number in 0..300u32 {
            let line = WireLine { connection: 1, robot: None, line: "x".repeat(64 * 1024) };
            journal.add(f64::from(number), Record::In(line));
        }
        assert!(journal.bytes <= MAX_BYTES && journal.entries.len() > 200);
        assert_eq!(journal.lost_until, Some(299.0 - journal.entries.len() as f64));
    }
}
