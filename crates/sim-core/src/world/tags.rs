//! RFID tags that robots release and write.

use gamebots_proto::Problem;
use scene::{RfidTag, check};

use crate::physics::Physics;
use crate::sensor::TagOrder;

impl Physics {
    /// Releases a tag, or writes to one. A new tag has the number after the largest.
    pub(super) fn change_tag(&mut self, order: TagOrder, problems: &mut Vec<Problem>) {
        match order {
            TagOrder::Release(position) => {
                let id = self.tags.iter().map(|tag| tag.id).max().map_or(1, |last| last.saturating_add(1));
                let tag = RfidTag { id, position, memory: String::new() };
                if self.tags.len() < check::MAX_TAGS && check::tag(&tag).is_empty() {
                    self.tags.push(tag);
                } else {
                    let why = format!("got {} tags, expected at most {}", self.tags.len() + 1, check::MAX_TAGS);
                    problems.push(Problem::TagRefused { id, why });
                }
            }
            TagOrder::Write { id, memory } => {
                let Some(tag) = self.tags.iter_mut().find(|tag| tag.id == id) else { return };
                let written = RfidTag { memory, ..tag.clone() };
                match check::tag(&written).first() {
                    None => *tag = written,
                    Some(why) => problems.push(Problem::TagRefused { id, why: why.clone() }),
                }
            }
        }
    }
}
