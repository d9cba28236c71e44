//! The port of truth, for referees (USARTruth.uc): poses of pawns and objects.
//!
//! The rows leave in one write, and the end of them a moment later. MetricTool asks how many bytes are there at the first one and reads so
//! many, again and again, until fewer come. Without a shorter rest it waits for 4 s.

use std::time::Duration;

use gamebots_proto::Framing;
use gamebots_proto::ports::{Row, TRUTH_END, TruthQuestion, rows};
use served_world::{Actors, Inquiry, Question};
use sim_core::Actor;
use tokio::time::sleep;

use crate::access::login::Accepted;
use crate::door::lines::Conversation;

/// Time between the rows of truth and their end.
const BEFORE_END: Duration = Duration::from_millis(20);

/// Answers a client until it leaves, speaks HTTP or does not read.
pub(crate) async fn converse(inquiry: Inquiry, accepted: Accepted, stall_timeout: Duration) {
    let mut client = Conversation::new(accepted.stream, Framing::with_empty_lines(), stall_timeout);
    while let Some(lines) = client.next().await {
        // A line that is too long has no answer.
        for line in lines.into_iter().flatten() {
            let Some(actors) = inquiry.ask(Question::Actors).await else { return };
            let answer = truth(&TruthQuestion::read(&line), &actors);
            let rows = answer.strip_suffix(TRUTH_END).unwrap_or(&answer);
            if !rows.is_empty() {
                if !client.send(rows.as_bytes()).await {
                    return;
                }
                sleep(BEFORE_END).await;
            }
            if !client.send(TRUTH_END.as_bytes()).await {
                return;
            }
        }
    }
}

fn truth(question: &TruthQuestion, actors: &Actors) -> String {
    let TruthQuestion { class, name } = question;
    let is_asked = |actor: &&Actor| actor.is_a(class) && (name.is_empty() || actor.name == *name);
    rows(actors.all().iter().filter(is_asked).map(|actor| {
        let (location, rotation) = scene::position_and_rotation(&actor.pose);
        Row {
            name: &actor.name,
            class: &actor.class,
            time: actors.time() as f32,
            location: location.map(|number| number as f32),
            // The zero of an angle has no sign.
            rotation: rotation.map(|number| (number + 0.0) as f32),
        }
    }))
}
