//! The loop of a served world, turned by hand: pace, pauses, outboxes, restarts and programs, with a clock of its own and no socket. Time
//! passes only where a test says so, so every number here is exact.

use std::pin::Pin;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use gamebots_proto::Command;
use outbox::{Outbox, Taken};
use page_protocol::{Actor, Control, Status};
use served_world::{
    Audience, Ended, Entrance, Event, Inquiry, Kind, Next, Question, ServedWorld, Session, Settings, Task, Told,
};
use sessions::{Answer, News, Request};
use sim_core::{TIME_STEP, World};
use system_tests::world;

/// Real time, moved by the test and by what takes time.
#[derive(Clone)]
struct Clock(Arc<Mutex<Instant>>);

impl Clock {
    fn now(&self) -> Instant {
        *self.0.lock().expect("the clock")
    }

    fn pass(&self, time: Duration) {
        *self.0.lock().expect("the clock") += time;
    }
}

/// An audience that writes down what it is told, and lets steps and lines take time.
struct Heard {
    clock: Clock,
    step_takes: Duration,
    line_takes: Duration,
    steps: u64,
    /// Received lines with their simulated times, s.
    received: Vec<(f64, String)>,
    sent: usize,
    words: Vec<String>,
    status: Status,
    /// Reason why the world may not start over, if any.
    refusal: Option<String>,
}

impl Audience for Heard {
    fn set_now(&mut self, now: Instant) {
        assert_eq!(now, self.clock.now());
    }

    fn hear(&mut self, world: &World, event: &Told) {
        match event {
            Told::News(News::Received { line, .. }) => {
                self.received.push((world.time(), (*line).to_owned()));
                self.clock.pass(self.line_takes);
            }
            Told::News(News::Sent { .. }) => self.sent += 1,
            Told::Warning(text) | Told::Note(text) | Told::Notice(text) => self.words.push((*text).to_owned()),
            Told::News(_) | Told::Standings(_) | Told::Result(_) | Told::Changed => {}
        }
    }

    fn stepped(&mut self, _: &World) {
        self.steps += 1;
        self.clock.pass(self.step_takes);
    }

    fn publish(&mut self, _: &World, status: &mut dyn FnMut() -> Status) {
        self.status = status();
    }

    fn record(&mut self, _: &World, _: bool) {}

    fn may_start_over(&self) -> Result<(), String> {
        self.refusal.clone().map_or(Ok(()), Err)
    }

    fn start_over(&mut self, _: &World, _: &World) {}
}

/// A served world, and everything around it.
struct Loop {
    served: ServedWorld<Heard>,
    clock: Clock,
    entrance: Entrance,
    events: Receiver<Event>,
    tasks: Vec<Task>,
    viewer: Inquiry,
}

/// A future that is polled by hand.
type Wait<'a, T> = Pin<Box<dyn Future<Output = T> + 'a>>;

fn poll<T>(wait: &mut Wait<'_, T>) -> Option<T> {
    match wait.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}

impl Loop {
    fn new(map: &str, real_time_factor: f64) -> Self {
        let clock = Clock(Arc::new(Mutex::new(Instant::now())));
        let heard = Heard {
            clock: clock.clone(),
            step_takes: Duration::ZERO,
            line_takes: Duration::ZERO,
            steps: 0,
            received: Vec::new(),
            sent: 0,
            words: Vec::new(),
            status: Status::default(),
            refusal: None,
        };
        let settings = Settings { real_time_factor, report_errors: false, budgets: served_world::Budgets::default() };
        let (entrance, events) = Entrance::new();
        let reads = clock.clone();
        let served = ServedWorld::new(world(map, 1), settings, heard, Box::new(move || reads.now()));
        let viewer = entrance.guest(Kind::Page);
        Self { served, clock, entrance, events, tasks: Vec::new(), viewer }
    }

    fn heard(&mut self) -> &mut Heard {
        self.served.audience_mut()
    }

    fn time(&self) -> f64 {
        self.served.world().time()
    }

    /// Takes one turn, and lets time pass until the next one. Returns false when the world is to end.
    fn turn(&mut self) -> bool {
        self.turn_with(None)
    }

    /// Takes one turn that begins with an event.
    fn turn_with(&mut self, event: Option<Event>) -> bool {
        let mut events = event.into_iter().chain(self.events.try_iter());
        let Some(Next { wake, tasks }) = self.served.turn(&mut events) else { return false };
        self.tasks.extend(tasks);
        self.clock.pass(wake.saturating_duration_since(self.clock.now()));
        true
    }

    /// Takes turns for a real time, s.
    fn run(&mut self, seconds: f64) {
        let end = self.clock.now() + Duration::from_secs_f64(seconds);
        while self.clock.now() < end {
            assert!(self.turn());
        }
    }

    /// Takes turns until a future is ready.
    fn wait<T>(&mut self, mut wait: Wait<'_, T>) -> T {
        for _ in 0..10_000 {
            if let Some(value) = poll(&mut wait) {
                return value;
            }
            assert!(self.turn());
        }
        panic!("it never came");
    }

    /// Asks for a control as a viewer does.
    fn control(&mut self, control: Control) {
        let viewer = self.viewer.clone();
        self.wait(Box::pin(viewer.send(Question::Control(control, Actor("page 1".to_owned())))));
        // The turn is free again once the control is executed.
        self.wait(Box::pin(viewer.ask(Question::Standings)));
    }

    /// Opens a session of a client that reads nothing by itself.
    fn client(&mut self) -> (Session, Arc<Outbox>) {
        let outbox = Arc::<Outbox>::default();
        let address = "127.0.0.1:1".parse().expect("an address");
        let session = self.entrance.open(self.entrance.next_session(), address, None, outbox.clone());
        (session.expect("an open world"), outbox)
    }

    fn order(&mut self, program: &Session, line: &str) -> Answer {
        let command = Command::parse(line, &mut Vec::new()).expect("a command");
        self.wait(Box::pin(program.order(command))).expect("an answer")
    }
}

fn requests(lines: &[&str]) -> Vec<Request> {
    lines.iter().map(|line| Request::read(Ok((*line).to_owned()))).collect()
}

/// Takes all lines that wait for a client.
fn read(outbox: &Outbox) -> Vec<Taken> {
    std::iter::from_fn(|| poll(&mut (Box::pin(outbox.take()) as Wait<_>)).flatten()).collect()
}

fn lines(outbox: &Outbox) -> Vec<String> {
    read(outbox).iter().flat_map(|taken| taken.text.lines()).map(str::to_owned).collect()
}

/// True if times, s, differ by less than a step.
fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1.01 * TIME_STEP
}

#[test]
fn simulated_time_follows_the_clock_by_the_factor() {
    for factor in [0.25, 1.0, 3.0] {
        let mut world = Loop::new("rough", factor);
        world.run(4.0);
        assert!(is_near(world.time(), 4.0 * factor), "{factor}: {} s", world.time());
        assert_eq!(world.heard().words, Vec::<String>::new());
    }
}

#[test]
fn as_fast_as_possible_every_turn_is_a_step() {
    let mut world = Loop::new("rough", 0.0);
    let begin = world.clock.now();
    for _ in 0..500 {
        world.turn();
    }
    assert_eq!((world.heard().steps, world.clock.now()), (500, begin));
}

#[test]
fn a_world_that_is_behind_says_so_once_and_never_rushes() {
    let mut world = Loop::new("rough", 1.0);
    world.heard().step_takes = Duration::from_secs_f64(2.0 * TIME_STEP);
    world.run(10.5);
    assert!((world.time() - 5.25).abs() < 0.05, "{} s", world.time());
    let words = std::mem::take(&mut world.heard().words);
    assert!(matches!(&words[..], [text] if text.starts_with("behind real time: real-time factor 0.50 ")), "{words:?}");
    world.heard().step_takes = Duration::ZERO;
    let before = world.time();
    world.run(1.0);
    // At most a tenth of a second is made up for.
    assert!((1.0..1.11).contains(&(world.time() - before)), "{} s", world.time() - before);
}

#[test]
fn the_wait_for_an_event_is_short_however_slow_time_is() {
    let mut world = Loop::new("rough", 0.001);
    world.turn();
    let before = world.clock.now();
    world.turn();
    assert_eq!(world.clock.now() - before, Duration::from_millis(2));
}

#[test]
fn a_pause_stops_time_and_steps_are_counted_exactly() {
    let mut world = Loop::new("rough", 1.0);
    world.run(0.1);
    world.control(Control::Pause(true));
    let (stopped, steps) = (world.time(), world.heard().steps);
    world.run(1.0);
    assert_eq!((world.time(), world.heard().status.paused), (stopped, true));
    world.control(Control::Step(7));
    world.run(0.1);
    assert_eq!(world.heard().steps, steps + 7);
    // A pause forgets the steps that were still to be taken.
    world.control(Control::Step(100_000));
    world.control(Control::Pause(true));
    let left = world.heard().steps;
    world.run(0.5);
    assert_eq!(world.heard().steps, left);
    // The pause is not made up for.
    let before = world.time();
    world.control(Control::Pause(false));
    world.run(0.5);
    assert!((0.49..0.52).contains(&(world.time() - before)), "{} s", world.time() - before);
    let words = ["page 1 paused the world", "page 1 resumed the world"].map(str::to_owned);
    assert!(words.iter().all(|it| world.served.audience().words.contains(it)), "{:?}", world.served.audience().words);
}

#[test]
fn lines_leave_one_by_one_only_while_time_is_real() {
    for (before, speed, is_paced) in [(1.0, 0.5, true), (1.0, 2.0, false), (2.0, 1.0, true), (1.0, 0.0, false)] {
        let mut world = Loop::new("rough", before);
        world.heard().step_takes = Duration::from_micros(100);
        let (session, outbox) = world.client();
        world.turn();
        read(&outbox);
        world.control(Control::Speed(speed));
        world.wait(Box::pin(session.send(requests(&["GETSTARTPOSES", "GETSTARTPOSES"])))).expect("a world");
        world.run(0.01);
        let taken = read(&outbox);
        assert!(taken.iter().all(|taken| taken.is_paced == is_paced), "{before} to {speed}: {taken:?}");
    }
}

#[test]
fn a_client_that_does_not_read_is_asked_no_further_and_loses_no_answer() {
    let mut world = Loop::new("rough", 1.0);
    let ((silent, outbox), (other, others)) = (world.client(), world.client());
    let question = vec!["GETSTARTPOSES"; 256];
    let mut sent = 0;
    // A whole segment waits, and the next one finds no turn.
    while poll(&mut (Box::pin(silent.send(requests(&question))) as Wait<_>)).is_some() {
        sent += question.len();
        world.run(0.1);
        assert!(sent < 100_000, "nothing holds it up");
    }
    let waiting = outbox.waiting_bytes();
    assert!((256 * 1024..258 * 1024).contains(&waiting), "{waiting} bytes");
    read(&others);
    world.wait(Box::pin(other.send(requests(&["GETSTARTPOSES"])))).expect("a world");
    world.run(0.01);
    assert_eq!(lines(&others).len(), 1, "others are answered");
    let mut answers = 0;
    while answers <= sent {
        let read = lines(&outbox).len();
        assert!(read > 0, "{answers} of {sent} answers and a greeting came");
        answers += read;
        world.run(0.1);
    }
    assert_eq!(answers, sent + 1);
}

#[test]
fn a_client_that_does_not_read_loses_its_oldest_sensor_lines_and_that_is_counted() {
    let mut world = Loop::new("rough", 0.0);
    world.heard().step_takes = Duration::from_micros(100);
    let (session, outbox) = world.client();
    let robots: Vec<String> = (0..8).map(|x| format!("INIT {{ClassName USARBot.P3AT}} {{Location {x},0,0}}")).collect();
    let robots: Vec<&str> = robots.iter().map(String::as_str).collect();
    world.wait(Box::pin(session.send(requests(&robots)))).expect("a world");
    for _ in 0..10_000 {
        world.turn();
    }
    assert!(outbox.waiting_bytes() <= 520 * 1024 + 64 * 1024, "{} bytes", outbox.waiting_bytes());
    // What was dropped is counted every five seconds.
    world.control(Control::Pause(true));
    world.clock.pass(Duration::from_secs(6));
    world.turn();
    world.turn();
    let (dropped, sent) = (world.heard().status.clients[0].dropped, world.heard().sent);
    assert_eq!(dropped as usize + lines(&outbox).len(), sent);
    assert!(dropped > 0);
}

#[test]
fn requests_of_a_flood_take_at_most_as_long_as_steps_and_others_come_first() {
    let mut world = Loop::new("rough", 1.0);
    (world.heard().step_takes, world.heard().line_takes) =
        (Duration::from_secs_f64(TIME_STEP), Duration::from_micros(500));
    let floods: Vec<_> = (0..3).map(|_| world.client()).collect();
    let (other, others) = world.client();
    world.turn();
    read(&others);
    let line = vec!["DRIVE {Left 1} {Right 1}"; 256];
    let mut slowest = Duration::ZERO;
    let begin = world.clock.now();
    for round in 0..50 {
        for (flood, _) in &floods {
            // The turn of most is still taken.
            let _ = poll(&mut (Box::pin(flood.send(requests(&line))) as Wait<_>));
        }
        let asked = world.clock.now();
        world.wait(Box::pin(other.send(requests(&["GETSTARTPOSES"])))).expect("a world");
        while lines(&others).is_empty() {
            assert!(world.turn());
        }
        // In the first round nobody has cost anything yet.
        if round > 0 {
            slowest = slowest.max(world.clock.now() - asked);
        }
    }
    let (real, steps) = ((world.clock.now() - begin).as_secs_f64(), world.heard().steps as f64);
    assert!(slowest <= Duration::from_millis(10), "an answer took {slowest:?}");
    assert!((0.45..0.55).contains(&(steps * TIME_STEP / real)), "{steps} steps in {real} s");
}

#[test]
fn a_flood_of_events_does_not_stop_time() {
    let mut world = Loop::new("rough", 0.0);
    for _ in 0..5000 {
        drop(world.client());
    }
    world.turn();
    let clients = world.heard().status.clients.len();
    assert_eq!((world.heard().steps, clients), (1, 0), "1024 events are 512 clients that came and left");
    (0..9).for_each(|_| assert!(world.turn()));
    assert_eq!(world.heard().steps, 10);
}

#[test]
fn guests_get_their_share_while_steps_are_always_due() {
    let mut world = Loop::new("rough", 0.0);
    world.heard().step_takes = Duration::from_millis(1);
    let guests: Vec<Inquiry> = (0..64).map(|_| world.entrance.guest(Kind::Truth)).collect();
    let mut waits: Vec<Wait<_>> = guests.iter().map(|guest| Box::pin(guest.ask(Question::Actors)) as Wait<_>).collect();
    let mut answers = 0;
    for _ in 0..1000 {
        for (wait, guest) in waits.iter_mut().zip(&guests) {
            if poll(wait).is_some() {
                answers += 1;
                *wait = Box::pin(guest.ask(Question::Actors));
                let _ = poll(wait);
            }
        }
        world.turn();
    }
    // An answer costs 0.1 ms beside the world's time, which is nothing here: three hundredths of a second.
    assert!((250..=350).contains(&answers), "{answers} answers in a second");
    assert_eq!(world.heard().steps, 1000);
}

/// Makes the fresh world that was asked for.
fn make(task: Task) -> Event {
    let Task::Make { scene, options, change } = task else { panic!("a save") };
    assert_eq!(change, None);
    Event::Made(Ok(Box::new(World::new(scene, options))))
}

#[test]
fn a_restart_has_one_task_and_puts_every_robot_back() {
    let mut world = Loop::new("rough", 1.0);
    let (session, _outbox) = world.client();
    let init = "INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}";
    world.wait(Box::pin(session.send(requests(&[init])))).expect("a world");
    world.run(0.5);
    // Requests that wait become one.
    (0..3).for_each(|_| world.control(Control::Reset));
    world.run(0.1);
    assert_eq!(world.tasks.len(), 1);
    let made = make(world.tasks.remove(0));
    assert!(world.turn_with(Some(made)));
    assert!(world.time() < 0.01 && world.served.world().robots().count() == 1);
    assert!(world.heard().words.contains(&"page 1 reset the world".to_owned()));
    assert_eq!(world.heard().received.iter().filter(|(_, line)| line == init).count(), 2);
    // The next one waits for a second.
    world.run(0.9);
    assert_eq!(world.tasks.len(), 0);
    world.run(0.2);
    assert_eq!((world.tasks.len(), world.heard().status.resets), (1, 1));
}

#[test]
fn a_restart_that_fails_is_told_and_the_world_goes_on() {
    for refusal in [None, Some("the disk is full".to_owned())] {
        let mut world = Loop::new("rough", 1.0);
        world.heard().refusal = refusal.clone();
        world.run(0.1);
        world.control(Control::Reset);
        world.run(0.1);
        let made = make(world.tasks.remove(0));
        let (made, expected) = match refusal {
            None => (Event::Made(Err("not reset: no thread".to_owned())), "not reset: no thread"),
            Some(_) => (made, "not reset: the disk is full"),
        };
        assert!(world.turn_with(Some(made)));
        assert!(world.heard().words.contains(&expected.to_owned()), "{:?}", world.heard().words);
        let before = world.time();
        world.run(0.5);
        assert!(is_near(world.time(), before + 0.5));
    }
}

#[test]
fn a_save_is_one_task_at_a_time() {
    let mut world = Loop::new("rough", 1.0);
    (0..3).for_each(|_| world.control(Control::Save));
    world.run(3.0);
    let [Task::Save { time, .. }] = &world.tasks[..] else { panic!("{} tasks", world.tasks.len()) };
    assert!(*time < 0.1);
    // Those that waited meanwhile become one.
    assert!(world.turn_with(Some(Event::Saved(Ok("saved".to_owned())))));
    world.run(3.0);
    assert_eq!((world.tasks.len(), world.heard().status.saves), (2, 1));
}

#[test]
fn what_a_client_asked_before_it_left_is_executed_and_its_robots_leave() {
    let mut world = Loop::new("rough", 1.0);
    let (session, outbox) = world.client();
    let asked = requests(&["INIT {ClassName USARBot.P3AT} {Location 0,0,0}", "GETSTARTPOSES"]);
    world.wait(Box::pin(session.send(asked))).expect("a world");
    session.close().expect("a world");
    world.run(0.1);
    assert!(lines(&outbox).iter().any(|line| line.starts_with("NFO {StartPoses 3}")));
    assert_eq!(poll(&mut (Box::pin(outbox.take()) as Wait<_>)), Some(None), "it is closed");
    assert_eq!((world.served.world().robots().count(), world.heard().status.clients.len()), (0, 0));
}

#[test]
fn a_world_that_stops_closes_its_outboxes_and_whoever_comes_later_is_told() {
    let mut world = Loop::new("rough", 1.0);
    let (session, outbox) = world.client();
    world.turn();
    world.entrance.stop();
    assert!(!world.turn());
    let Loop { served, events, entrance, .. } = world;
    served.end();
    drop(events);
    lines(&outbox);
    assert_eq!(poll(&mut (Box::pin(outbox.take()) as Wait<_>)), Some(None), "it is closed");
    assert_eq!(poll(&mut (Box::pin(session.send(requests(&["GETSTARTPOSES"]))) as Wait<_>)), Some(Err(Ended)));
    assert!(entrance.open_program("late").is_err());
}

#[test]
fn a_program_drives_by_commands_and_hears_answers_without_a_line() {
    let mut world = Loop::new("rough", 1.0);
    let program = world.entrance.open_program("autopilot").expect("a world");
    let answer = world.order(&program, "INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}");
    let robot = answer.spawned.expect("a robot");
    assert_eq!(answer.problems, []);
    let answer = world.order(&program, "GETCONF {Type Robot}");
    assert!(matches!(answer.messages[..], [gamebots_proto::message::Message::Conf(_)]), "{answer:?}");
    let answer = world.order(&program, "DRIVE {Left 2} {Right 2} {Wings 1}");
    assert!(matches!(&answer.problems[..], [problem] if problem.to_string().contains("Wings")), "{answer:?}");
    world.run(1.0);
    let x = world.served.world().observe(robot).expect("it is there").body.pose.translation.x;
    assert!(x > 0.1, "{x} m");
    let heard = world.served.audience();
    assert_eq!((heard.sent, heard.received.len()), (0, 3), "logs have its commands, and nothing is formatted for it");
    assert_eq!(heard.status.clients[0].peer, "autopilot");
    drop(program);
    world.run(0.01);
    assert_eq!(world.served.world().robots().count(), 0);
}
