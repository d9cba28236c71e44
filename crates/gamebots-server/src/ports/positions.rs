//! The port of positions, for wireless simulators (ComServerInterface.uc): robots, and the obstacles between them.

use std::time::Duration;

use gamebots_proto::Framing;
use gamebots_proto::ports::{Place, PositionsQuestion};
use served_world::{Inquiry, Question, point_of};

use crate::access::login::Accepted;
use crate::door::lines::Conversation;

/// Answers a client until it leaves, speaks HTTP or does not read.
pub(crate) async fn converse(inquiry: Inquiry, accepted: Accepted, stall_timeout: Duration) {
    let mut client = Conversation::new(accepted.stream, Framing::default(), stall_timeout);
    while let Some(lines) = client.next().await {
        // A line that is too long has no answer.
        for line in lines.into_iter().flatten() {
            let Some(answer) = answer(&line, &inquiry).await else { return };
            if !client.send(answer.as_bytes()).await {
                return;
            }
        }
    }
}

/// Answers a line; with an empty text if it has no answer. `None` if the world has ended.
async fn answer(line: &str, inquiry: &Inquiry) -> Option<String> {
    let between = match PositionsQuestion::read(line) {
        None => return Some(String::new()),
        Some(PositionsQuestion::Nothing) => return Some("\r\n".to_owned()),
        Some(PositionsQuestion::Positions) => return Some(inquiry.ask(Question::Actors).await?.stands().to_owned()),
        Some(PositionsQuestion::Obstacles(between)) => between,
    };
    let actors = inquiry.ask(Question::Actors).await?;
    let point = |place: Place| match place {
        Place::Point(point) => Some(point),
        Place::Robot(name) => actors.robots().find(|robot| robot.called == name).map(|robot| point_of(&robot.pose)),
    };
    let [from, to] = between.places().map(point);
    let count = match from.zip(to) {
        Some((from, to)) => inquiry.ask(|answer| Question::Obstacles([from, to], answer)).await? as f32,
        None => -1.0,
    };
    Some(between.answer(count))
}
