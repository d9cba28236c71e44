//! The work that clients and guests ask for, in the time that steps leave.

use sessions::SessionId;
use web_time::{Duration, Instant};

use crate::audience::{Audience, Told};
use crate::client::Client;
use crate::fit::fit;
use crate::question::Question;
use crate::served::ServedWorld;

/// Requests of one segment that are executed together, if all but the first take less than [`LONG_SLICE`]. A question in the segment of
/// an INIT is then answered before the first reading at any speed.
const REQUESTS_TOGETHER: usize = 16;
/// Time for one client's requests before another client has its turn.
const SLICE: Duration = Duration::from_millis(1);
/// Time for the requests behind the first of a slice, however few they are. Each may have an answer of 256 KiB.
const LONG_SLICE: Duration = Duration::from_millis(4);

impl<A: Audience> ServedWorld<A> {
    /// Executes requests while a step is due, within the time that steps have earned.
    pub(crate) fn work_on_credit(&mut self, now: Instant) {
        if self.credit > 0.0 {
            self.work(now + Duration::from_secs_f64(self.credit));
            self.credit -= ((self.clock)() - now).as_secs_f64();
        }
    }

    /// Executes clients' requests until none is left or the deadline has passed, the cheapest client first. Returns false if
    /// there was nothing to do.
    pub(crate) fn work(&mut self, deadline: Instant) -> bool {
        let mut worked = false;
        while let Some(id) = self.next_client() {
            worked = true;
            self.execute_slice(id);
            if (self.clock)() >= deadline {
                break;
            }
        }
        worked
    }

    /// Returns the cheapest client that has requests and room for the answers.
    fn next_client(&self) -> Option<SessionId> {
        let ready = self.circle.clients.iter().filter(|(_, client)| client.is_ready());
        ready.min_by_key(|(_, client)| client.cost()).map(|(&id, _)| id)
    }

    fn execute_slice(&mut self, id: SessionId) {
        let Self { sessions, circle, restarts, clock, .. } = self;
        let start = clock();
        let mut count = 0;
        let put_back = circle.clients.get_mut(&id).and_then(Client::next_put_back);
        let is_put_back = put_back.is_some();
        if let Some(init) = put_back {
            sessions.take(id, &init, &mut |world, news| circle.hear(world, news));
            restarts.add_cost(clock() - start);
        }
        // An INIT is the first request of its slice. Its time is not that of the requests behind it.
        let mut first_done = start;
        while !is_put_back && {
            let now = clock();
            now - start < SLICE || count < REQUESTS_TOGETHER && now - first_done < LONG_SLICE
        } {
            let Some(client) = circle.clients.get_mut(&id) else { break };
            let Some((request, way)) = client.next_request() else { break };
            client.note_line();
            let answer = sessions.take(id, &request, &mut |world, news| circle.hear(world, news));
            if let Some(way) = way {
                // The program may wait no longer.
                let _ = way.send(answer);
            }
            count += 1;
            if count == 1 {
                first_done = clock();
            }
            // A segment with many robots must not hold up other clients.
            if circle.clients.get(&id).is_some_and(Client::is_next_init) {
                break;
            }
        }
        if let Some(client) = circle.clients.get_mut(&id) {
            client.add_cost(clock() - start);
        }
        self.end_if_done(id);
    }

    /// Ends a session after its last request is executed, if the client has left.
    pub(crate) fn end_if_done(&mut self, id: SessionId) {
        let Self { sessions, circle, performance, .. } = self;
        if !circle.clients.get(&id).is_some_and(Client::is_over) {
            return;
        }
        if let Some(mut client) = circle.clients.remove(&id) {
            let repeated = client.report(circle.now);
            repeated.iter().for_each(|text| circle.audience.hear(sessions.world(), &Told::Warning(text)));
            client.close_outbox();
            performance.dropped += client.dropped();
        }
        sessions.close(id, &mut |world, news| circle.hear(world, news));
    }

    /// Answers guests until none waits, their time is spent or the next step is due. `idle_until` is that moment; without it a step is due
    /// now. Returns false if there was nothing to do.
    pub(crate) fn answer_guests(&mut self, idle_until: Option<Instant>) -> bool {
        let (mut answered, mut may_answer) = (false, true);
        while may_answer && idle_until.is_none_or(|end| (self.clock)() < end) {
            let Some((guest, question, _turn)) = self.guests.next() else { break };
            let start = (self.clock)();
            self.answer(question);
            let took = (self.clock)() - start;
            self.guests.charge(guest, took);
            answered = true;
            let [due, idle] = &mut self.guests_credits;
            may_answer = if idle_until.is_some() { idle } else { due }.spend(took);
        }
        answered
    }

    /// Answers a guest. It may have left.
    fn answer(&mut self, question: Question) {
        let Self { sessions, circle, .. } = self;
        match question {
            Question::Actors(answer) => _ = answer.send(circle.audience.actors(sessions.world())),
            Question::Obstacles([from, to], answer) => _ = answer.send(sessions.world_mut().obstacles(from, to)),
            Question::Health(answer) => _ = answer.send(self.health()),
            Question::Standings(answer) => _ = answer.send(sessions.standings()),
            Question::Fit(wanted, answer) => _ = answer.send(fit(wanted, sessions.world_mut())),
            Question::Control(control, actor) => self.control(control, actor),
        }
    }
}
