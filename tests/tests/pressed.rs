//! Robots under load: squeezed, in heaps, fallen, pushed. No body becomes faster than its cause, in any class, at any step.

use scene_loader::robot_names;
use sim_core::{Options, World};
use system_tests::{init, problems};

/// Steps, s, up to the longest that is allowed.
const TIME_STEPS: [f64; 4] = [0.002, 0.004, 0.01, 0.02];

/// Acceleration of gravity, m/s².
const GRAVITY: f64 = 9.81;

/// A world with its fastest motion.
struct Stage {
    world: World,
    time_step: f64,
    robots: usize,
    /// Largest speed of a robot that was seen, m/s, and its class.
    fastest: (f64, String),
}

impl Stage {
    fn new(time_step: f64) -> Self {
        let def = scene_loader::load("smooth", &[]).unwrap_or_else(|error| panic!("{error}"));
        let world = World::new(def, Options { time_step, ..Options::default() });
        Self { world, time_step, robots: 0, fastest: (0.0, String::new()) }
    }

    fn robot(&mut self, class: &str, place: &str) {
        init(&mut self.world, &format!("INIT {{ClassName USARBot.{class}}} {place}"));
        self.robots += 1;
    }

    fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds / self.time_step) as u64 {
            self.world.step();
            for robot in self.world.snapshot().robots {
                let speed = robot.body.linear.norm();
                if speed > self.fastest.0 {
                    self.fastest = (speed, robot.class);
                }
            }
        }
    }

    /// Creates a block of a world controller, 4 m wide and long and 1 m high, that moves between two places at a speed, m/s.
    fn block(&mut self, from: &str, to: &str, speed: f64) {
        let controller = init(&mut self.world, "INIT {ClassName USARBotAPI.WorldController}");
        for order in [
            format!("{{Type Create}} {{ClassName WCCrate}} {{Name block}} {{Location {from}}} {{Scale 8,8,2}}"),
            format!("{{Type SetWP}} {{Name block}} {{Speed {speed}}}"),
            format!("{{Type AddWP}} {{Name block}} {{WP {from};{to}}}"),
        ] {
            assert_eq!(problems(&mut self.world, controller, &format!("CONTROL {order}")), [""; 0], "{order}");
        }
    }

    /// Returns the error if a robot was faster than a cause, m/s, or was removed.
    fn error(&self, what: &str, cause: f64) -> Option<String> {
        let (speed, class) = &self.fastest;
        let left = self.world.snapshot().robots.len();
        let found = format!("{what} at {} s: {class} {speed:.2} of {cause:.2} m/s, {left} left", self.time_step);
        println!("{found}");
        let is_sound = *speed <= cause && left == self.robots;
        (!is_sound).then_some(found)
    }
}

/// Returns all classes, of those that differ in their colour alone the first.
fn classes() -> Vec<String> {
    let is_painted = |class: &String| ["_g", "_r", "_y"].iter().any(|colour| class.ends_with(colour));
    robot_names().into_iter().filter(|class| !is_painted(class)).collect()
}

/// Runs a trial at each step. Panics with all errors.
fn check(trial: impl FnMut(f64) -> Vec<String>) {
    let errors: Vec<String> = TIME_STEPS.into_iter().flat_map(trial).collect();
    assert!(errors.is_empty(), "{errors:#?}");
}

#[test]
fn a_block_that_presses_a_robot_to_the_floor_makes_it_no_faster_than_itself_and_a_fall() {
    // A robot that gives way falls over. A Nao is 0.6 m high.
    let fall = (2.0 * GRAVITY * 0.6).sqrt();
    check(|time_step| {
        let squeezed = classes().into_iter().filter_map(|class| {
            let mut stage = Stage::new(time_step);
            stage.robot(&class, "{Location 0,0,-0.1}");
            stage.run(0.5);
            // Industrial arms are higher than 2 m. They have six joints, as many others, for which it only takes longer.
            let is_tall = stage.world.snapshot().robots.iter().any(|robot| robot.joints.len() > 5);
            let from = if is_tall { 6.0 } else { 2.5 };
            stage.block(&format!("0,0,-{from}"), "0,0,-0.5", 1.0);
            stage.run(from);
            stage.error(&format!("a squeezed {class}"), 1.0 + fall)
        });
        squeezed.collect()
    });
}

#[test]
fn robots_that_fall_on_each_other_are_no_faster_than_their_fall() {
    let heaps = [
        ["Kenaf", "Talon", "TeleMax", "Nao", "KUKA_YouBot", "P3AT", "Soryu"].as_slice(),
        &["Soryu", "P3AT", "KUKA_YouBot", "Nao", "TeleMax", "Talon", "Kenaf"],
        &["Nao", "QRIO", "Nao", "TeleMax", "Talon"],
        &["P3AT", "Nao", "Hummer"],
    ];
    check(|time_step| {
        let heap = |classes: &[&str]| {
            let mut stage = Stage::new(time_step);
            let mut height = 1.0;
            for class in classes {
                stage.robot(class, &format!("{{Location 0,0,-{height}}}"));
                height += 0.6;
            }
            // The last one falls for 1 s.
            stage.run(2.0);
            stage.error(&format!("a heap of {classes:?}"), (2.0 * GRAVITY * height).sqrt())
        };
        let all = classes();
        let of_each = all.iter().map(|class| [class.as_str(), "Nao", class, "QRIO", "P3AT"]);
        let errors = heaps.into_iter().filter_map(heap);
        errors.chain(of_each.filter_map(|classes| heap(&classes))).collect()
    });
}

#[test]
fn a_robot_that_falls_or_is_pushed_is_no_faster_than_its_cause() {
    check(|time_step| {
        let alone = |class: String| {
            let mut stage = Stage::new(time_step);
            stage.robot(&class, "{Location 0,0,-20} {Rotation 0.8,0.5,0}");
            stage.run(2.5);
            let fall = stage.error(&format!("a fallen {class}"), (2.0 * GRAVITY * 20.5).sqrt());
            let mut stage = Stage::new(time_step);
            stage.robot(&class, "{Location 0,0,-0.1}");
            stage.run(0.5);
            stage.block("-5,0,-0.51", "8,0,-0.51", 2.0);
            stage.run(3.0);
            // It bounces off, and an overlap is pushed out at 1 m/s.
            let pushed = stage.error(&format!("a pushed {class}"), 3.0);
            [fall, pushed]
        };
        classes().into_iter().flat_map(alone).flatten().collect()
    });
}
