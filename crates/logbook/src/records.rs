//! Records of news: what a log says of the sessions.

use recorder::{Record, WireLine};
use scene::PawnId;
use sessions::{News, SessionId};

/// Returns the record of news; `None` for arrivals, which an INIT line records, and for problems, of which [`sessions::Mistakes`] has the
/// warnings.
pub fn record(news: &News) -> Option<Record> {
    let line = |connection: SessionId, pawn: Option<PawnId>, line: &str| WireLine {
        connection,
        robot: pawn.map(|pawn| pawn.0),
        line: line.to_owned(),
    };
    match news {
        News::Received { session, pawn, line: text } => Some(Record::In(line(*session, *pawn, text))),
        News::Sent { session, pawn, line: text, .. } => Some(Record::Out(line(*session, *pawn, text))),
        News::Sensed(sensed) => Some(Record::Sensed((*sensed).clone())),
        News::Left(pawn) => Some(Record::Left(pawn.0)),
        News::Closed(session) => Some(Record::Closed(line(*session, None, ""))),
        News::Lost(_) | News::Restored { .. } => news.warning().map(Record::Warning),
        News::Scored(score) => Some(Record::Scored((*score).clone())),
        News::TimeUp(standings) => Some(Record::Standings(Box::new((*standings).clone()))),
        News::Wrong { .. } | News::Came(_) => None,
    }
}
