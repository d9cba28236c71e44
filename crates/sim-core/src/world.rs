//! The world: robots on a map, advanced step by step.

mod actors;
mod answer;
mod avatar;
mod controller;
mod held;
mod item;
mod pull;
mod report;
mod robot;
mod saved;
mod seed;
mod tags;
mod tiles;
mod tools;
mod vacuum;
mod victims;

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use gamebots_proto::command::{Act, Command, Init, MisPkg};
use gamebots_proto::message::{Greeting, Message, NamedPose as WirePose, Nfo, PathNode};
use gamebots_proto::{Problem, shown};

use crate::CompiledScene;
use crate::drive::Order;
use crate::physics::{CompiledRobot, Fault, Identity, Physics, Placement, SolverEffort};
use crate::sensor::floats;
use crate::threads::{OneThread, Threads, in_parts};
use actors::EngineNames;
pub use actors::{Actor, ActorKind};
use avatar::Avatar;
use controller::{Controller, Created};
use held::{Attachments, Hand};
use item::Motion;
use pull::Pull;
pub use report::Report;
use robot::Robot;
pub use saved::{LoadError, SaveError, SavedWorld};
use scene::{
    BodyState, JointState, NamedPose, ObjectId, ObjectSnapshot, Options, PawnId, Pose, RobotDef, RobotSnapshot,
    Snapshot, WheelState, WorldDef, check,
};
pub use tiles::{TILES, Tiles};

/// Maximum length of a robot's name, characters. Longer names are truncated.
const MAX_NAME_CHARS: usize = 256;

/// Maximum number of robots in a world. Further ones are refused.
const MAX_ROBOTS: usize = 256;

/// Name of the class of world controllers, without its package.
const CONTROLLER: &str = Init::CONTROLLER[1];

/// A simulated world: a deterministic function of definition, options and commands by step. A copy is independent and continues as the
/// original would.
#[derive(Clone)]
pub struct World {
    scene: CompiledScene,
    options: Options,
    physics: Physics,
    /// True if the engine took part in the last step.
    is_engine_running: bool,
    steps: u64,
    robots: BTreeMap<PawnId, Robot>,
    next_id: u64,
    controllers: BTreeMap<PawnId, Controller>,
    avatars: BTreeMap<PawnId, Avatar>,
    /// Objects that controllers created, by their ids.
    created: Vec<Created>,
    next_object: u64,
    /// Springs by which controllers pull things.
    pulls: Vec<Pull>,
    /// Objects that robots hold, and tools that they have dropped.
    attached: Attachments,
    /// Numbers of pawns within their classes.
    engine_names: EngineNames,
    /// Cameras that the image server shows.
    tiles: Tiles,
    /// The robot that asked for a single view.
    single_view: Option<PawnId>,
    lost: Vec<LostRobot>,
    /// Names and faults of restored objects, until [`World::take_restored`].
    restored: Vec<(String, Fault)>,
    threads: Arc<dyn Threads>,
}

/// The result of a command.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Executed {
    /// Reports to the client, in order.
    pub answers: Vec<Report>,
    /// True if the robot has the item that a SET, GETCONF or GETGEO names.
    pub found: bool,
    /// The spawned robot. From now on the client's commands go to it (BotConnection.uc:37-47).
    pub spawned: Option<PawnId>,
}

/// A free place for a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct FreePlace {
    /// Pose of the robot frame.
    pub pose: Pose,
    /// The obstacle at the wanted place, in words, if the robot is put beside it.
    pub beside: Option<String>,
}

/// A robot that was removed because of its state.
#[derive(Debug, Clone, PartialEq)]
pub struct LostRobot {
    /// Its number.
    pub id: PawnId,
    /// Its class.
    pub class: String,
    /// Its name from INIT.
    pub name: String,
    /// The fault of its state.
    pub fault: Fault,
}

impl fmt::Display for LostRobot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { id, class, name, fault } = self;
        write!(f, "robot {} ({class} {name}) is removed: {fault}", id.0)
    }
}

impl World {
    /// Returns a world at time zero without robots.
    pub fn new(scene: impl Into<CompiledScene>, options: Options) -> Self {
        let scene = scene.into();
        let physics = Physics::new(scene.map(), scene.materials().clone(), options.time_step);
        let next_object = scene.def().map.objects.len() as u64;
        Self {
            scene,
            options,
            physics,
            is_engine_running: false,
            steps: 0,
            robots: BTreeMap::new(),
            next_id: 0,
            controllers: BTreeMap::new(),
            avatars: BTreeMap::new(),
            created: Vec::new(),
            next_object,
            pulls: Vec::new(),
            attached: Attachments::default(),
            engine_names: EngineNames::default(),
            tiles: Tiles::default(),
            single_view: None,
            lost: Vec::new(),
            restored: Vec::new(),
            threads: Arc::new(OneThread),
        }
    }

    /// Runs the steps on these threads.
    #[must_use]
    pub fn on_threads(self, threads: Arc<dyn Threads>) -> Self {
        Self { threads, ..self }
    }

    /// Returns the simulated time, s.
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.options.time_step
    }

    /// True if no step was taken and no robot was ever spawned.
    pub fn is_untouched(&self) -> bool {
        self.steps == 0 && self.next_id == 0
    }

    /// Returns the length of a step, s.
    pub fn time_step(&self) -> f64 {
        self.options.time_step
    }

    /// Returns the options that it runs with.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Returns the definition of the world.
    pub fn def(&self) -> &WorldDef {
        self.scene.def()
    }

    /// Returns the compiled scene, which other worlds can share.
    pub fn scene(&self) -> &CompiledScene {
        &self.scene
    }

    /// Returns the greeting of a new connection.
    pub fn greeting(&self) -> Message {
        let map = &self.def().map;
        Message::Nfo(Nfo::Greeting(Greeting { level: map.name.clone(), time_limit: map.time_limit }))
    }

    /// Spawns a robot, a world controller or an avatar. `None`, with the reason in `problems`, if the class is unknown, the world is full or
    /// there is no free place.
    ///
    /// A pose inside or below the ground is lifted onto it; a robot above the ground falls. If the place is occupied, the robot is put beside
    /// the obstacle, and `problems` reports it. An unknown start means the origin, as in USARSim (BotConnection.uc:452-473).
    pub fn init(&mut self, init: &Init, problems: &mut Vec<Problem>) -> Option<PawnId> {
        if self.robots.len() + self.controllers.len() + self.avatars.len() >= MAX_ROBOTS {
            problems.push(Problem::TooManyRobots { limit: MAX_ROBOTS });
            return None;
        }
        if init.is_controller() {
            let (id, name) = (self.number(), pawn_name(init, problems));
            let pose = scene::pose(init.location, init.rotation);
            self.controllers.insert(id, Controller { name, pose });
            self.engine_names.add(id, CONTROLLER);
            return Some(id);
        }
        if let Some(class) = init.avatar() {
            let (wanted, name) = (self.start_pose(init, problems), pawn_name(init, problems));
            let refuse = |why| problems.push(Problem::NoRoom { wanted: wire_place(init), why });
            return self.spawn_avatar(class, name, &wanted).map_err(refuse).ok();
        }
        let class = self.class(init, problems)?;
        let (tools, class) = match self.outfit(&class) {
            Ok(outfit) => outfit,
            Err(why) => {
                problems.push(Problem::NoRoom { wanted: wire_place(init), why });
                return None;
            }
        };
        let wanted = self.start_pose(init, problems);
        self.enter_shapes();
        let pose = match self.find_place(&class, &wanted, None) {
            Ok(FreePlace { pose, beside: None }) => pose,
            Ok(FreePlace { pose, beside: Some(why) }) => {
                problems.push(Problem::Beside { wanted: wire_place(init), why, got: numbers(&pose) });
                pose
            }
            Err(why) => {
                problems.push(Problem::NoRoom { wanted: wire_place(init), why });
                return None;
            }
        };
        let (id, name) = (self.number(), pawn_name(init, problems));
        if !name.is_empty() && self.robots.values().any(|robot| robot.name().eq_ignore_ascii_case(&name)) {
            problems.push(Problem::NameTaken { got: shown(&name) });
        }
        self.engine_names.add(id, &class.def.class);
        let robot = Robot::spawn(&mut self.physics, class, name, &pose, id, self.steps, self.options);
        self.robots.insert(id, robot);
        self.give_tiles(id);
        self.next_object += tools.len() as u64;
        self.attached.append(tools);
        Some(id)
    }

    /// Returns a new number for a pawn.
    fn number(&mut self) -> PawnId {
        let id = PawnId(self.next_id);
        self.next_id += 1;
        id
    }

    /// Puts a robot at a pose, at rest, or beside what is there. Its joints stay as they are, except those of a robot of the engine.
    fn put_robot(&mut self, id: PawnId, wanted: &Pose, problems: &mut Vec<Problem>) -> Result<(), String> {
        self.enter_shapes();
        let robot = self.robots.get(&id).ok_or("it is gone")?;
        let class = robot.bodies().robot().clone();
        let FreePlace { pose, beside } = self.find_place(&class, wanted, Some(id))?;
        if let Some(why) = beside {
            problems.push(Problem::Beside {
                wanted: format!("{{Location {}}}", numbers(wanted)),
                why,
                got: numbers(&pose),
            });
        }
        if let Some(robot) = self.robots.get_mut(&id) {
            self.physics.put_robot(robot.bodies_mut(), id, &pose);
        }
        Ok(())
    }

    /// Sets a robot upright where it is, with its heading.
    fn set_upright(&mut self, id: PawnId, problems: &mut Vec<Problem>) -> Result<(), String> {
        let now = self.observe(id).ok_or("it is gone")?.body.pose;
        let (position, [.., yaw]) = scene::position_and_rotation(&now);
        self.put_robot(id, &scene::pose(position, [0.0, 0.0, yaw]), problems)
    }

    /// Finds the place that a robot of a class would get. `location` and `rotation` are those of INIT. `None` if the class is unknown.
    ///
    /// # Errors
    /// If there is no free place, with the reason in words.
    pub fn fit(&mut self, class: &str, location: [f64; 3], rotation: [f64; 3]) -> Option<Result<FreePlace, String>> {
        let class = self.compiled(class)?;
        let class = match self.outfit(&class) {
            Ok((_, class)) => class,
            Err(why) => return Some(Err(why)),
        };
        self.enter_shapes_for_question();
        Some(self.find_place(&class, &scene::pose(location, rotation), None))
    }

    /// Returns the pose of a robot of a class that is put at a place, if that is free. Unlike [`World::fit`] it searches no place beside,
    /// which takes far longer. `None` if it is not free or the class is unknown.
    pub fn free_pose(&mut self, class: &str, location: [f64; 3], rotation: [f64; 3]) -> Option<Pose> {
        let class = self.compiled(class)?;
        let (_, class) = self.outfit(&class).ok()?;
        self.enter_shapes_for_question();
        self.physics.place_here(&class, &scene::pose(location, rotation))
    }

    /// Finds the place for a robot that is wanted at a pose. `moved` is the robot, if it is in the world. Fails with the reason in words.
    fn find_place(&self, class: &CompiledRobot, wanted: &Pose, moved: Option<PawnId>) -> Result<FreePlace, String> {
        if let Some(number) = wanted.translation.vector.iter().find(|&&number| !check::MAP_REACH.holds(number)) {
            return Err(format!("it is outside the map: got {number}, expected {}", check::MAP_REACH));
        }
        let takes_it = |obstacle: Identity| format!("{} takes it", self.describe(obstacle));
        let Placement { pose, obstacle } = self.physics.place(class, wanted, moved).map_err(takes_it)?;
        Ok(FreePlace { pose, beside: obstacle.map(takes_it) })
    }

    /// Describes a body in words, for an error message.
    fn describe(&self, identity: Identity) -> String {
        let map = &self.def().map;
        match identity {
            Identity::Solid(number) => {
                let name = map.solids.get(number as usize).map_or("", |solid| solid.name.as_str());
                format!("the solid `{name}`")
            }
            Identity::Object(id) => {
                let met = self.physics.objects().find(|object| object.id == id);
                format!("the object `{}`", met.map_or(String::new(), |object| object.def.solid.name.clone()))
            }
            Identity::Link { robot, .. } => {
                let met = self.robots.get(&robot);
                match met.map_or("", Robot::name) {
                    "" => format!("robot {} ({})", robot.0, met.map_or("", |it| it.def().class.as_str())),
                    name => format!("robot {} `{name}`", robot.0),
                }
            }
        }
    }

    /// Removes a robot, a world controller or an avatar from the world.
    pub fn remove(&mut self, id: PawnId) {
        self.engine_names.remove(id);
        self.tiles.free(id);
        self.remove_controller(id);
        self.remove_avatar(id);
        self.put_all_down(id);
        if let Some(robot) = self.robots.remove(&id) {
            self.physics.remove(robot.bodies());
            self.remove_tools(id);
        }
    }

    /// Executes a command and adds its errors to `problems`. A command for a robot goes to `pawn`, the newest robot of the client that sent
    /// it. A robot with a flat battery ignores everything.
    pub fn execute(&mut self, pawn: Option<PawnId>, command: &Command, problems: &mut Vec<Problem>) -> Executed {
        if let Command::Control(order) = command {
            let answers = self.control(pawn, order, problems).into_iter().map(Report::Message).collect();
            return Executed { answers, ..Executed::default() };
        }
        let time = self.time();
        if let (Command::Set(set), Some(pawn)) = (command, pawn)
            && self.robots.get(&pawn).is_some_and(|robot| robot.battery_left(time) > 0)
            && let Some(executed) = self.set_tiles(pawn, set)
        {
            if !executed.found
                && let Some(robot) = self.robots.get(&pawn)
            {
                problems.push(robot.nothing_to_set(set));
            }
            return executed;
        }
        if let Command::Set(_) = command {
            self.enter_shapes();
        }
        let (mut found, mut hands, mut flips) = (false, Vec::new(), false);
        let answers = match (command, pawn.and_then(|pawn| self.robots.get_mut(&pawn))) {
            (Command::Init(init), _) => {
                return Executed { spawned: self.init(init, problems), ..Executed::default() };
            }
            (Command::GetStartPoses(_), _) => {
                vec![Message::Nfo(Nfo::StartPoses(self.def().map.starts.iter().map(wire_pose).collect())).into()]
            }
            (Command::GetClasses(_), _) => {
                vec![Message::Nfo(Nfo::Classes(self.def().robots.keys().cloned().collect())).into()]
            }
            (Command::GetPathNodes(_), _) => {
                vec![Message::Nfo(Nfo::PathNodes(self.def().map.path_nodes.iter().map(wire_pose).collect())).into()]
            }
            (Command::GetClosestPathNode(ask), _) => {
                let nodes = &self.def().map.path_nodes;
                ask.location.map(|position| Message::Nfo(closest(nodes, position)).into()).into_iter().collect()
            }
            (Command::Walk(order), _) => {
                self.walk(pawn, order, problems);
                Vec::new()
            }
            (Command::GoTo(order), _) => {
                self.go_to(pawn, order, problems);
                Vec::new()
            }
            // The server executes it, as it concerns the connection.
            (Command::Report(_) | Command::Control(_), _) => Vec::new(),
            (_, None) => {
                problems.push(Problem::NoRobot { verb: command.verb() });
                Vec::new()
            }
            (_, Some(robot)) if robot.battery_left(time) <= 0 => {
                problems.push(Problem::FlatBattery { verb: command.verb() });
                Vec::new()
            }
            (Command::Drive(drive), Some(robot)) => {
                robot.drive(drive, problems);
                flips = drive.flip == Some(true);
                Vec::new()
            }
            (Command::MultiDrive(drive), Some(robot)) => {
                robot.multi_drive(drive, problems);
                Vec::new()
            }
            (
                Command::Act(Act { name, targets, gripper }) | Command::MisPkg(MisPkg { name, targets, gripper }),
                Some(robot),
            ) => {
                let first = usize::from(matches!(command, Command::MisPkg(_)));
                let closed = gripper.map(|gripper| gripper != 0.0);
                hands = robot.act(&Motion { name, first, targets, closed }, problems).hands;
                Vec::new()
            }
            (Command::Set(set), Some(robot)) => {
                let outcome = robot.set(set, &self.physics, time);
                (found, hands) = (outcome.found, outcome.hands);
                outcome.tags.into_iter().for_each(|order| self.physics.change_tag(order, problems));
                if !found {
                    problems.push(robot.nothing_to_set(set));
                }
                outcome.reports
            }
            (Command::GetConf(ask), Some(robot)) => {
                let conf = answer::conf(robot, ask);
                found = conf.is_some();
                if !found {
                    problems.push(robot.nothing_to_tell(command.verb(), &ask.type_name, &ask.name));
                }
                conf.map(|conf| Message::Conf(conf).into()).into_iter().collect()
            }
            (Command::GetGeo(ask), Some(robot)) => {
                let geo = answer::geo(robot, ask);
                found = geo.is_some();
                if !found {
                    problems.push(robot.nothing_to_tell(command.verb(), &ask.type_name, &ask.name));
                }
                geo.map(|geo| Message::Geo(geo).into()).into_iter().collect()
            }
        };
        if let Some(pawn) = pawn.filter(|_| flips)
            && let Err(why) = self.set_upright(pawn, problems)
        {
            problems.push(Problem::Ignored { what: "{Flip True}".to_owned(), why });
        }
        if let Some(pawn) = pawn {
            hands.into_iter().for_each(|(hand, closed)| match hand {
                Hand::Changer(number) => self.change_tool(pawn, number, closed, problems),
                Hand::Vacuum(number) => self.suck(pawn, number, closed, problems),
            });
        }
        Executed { answers, found, spawned: None }
    }

    /// Gives a robot an order, as a command of its client would. Returns false, and changes nothing, if there is no such robot, its battery
    /// is flat, a number is not finite, or robots of its kind do not follow such orders.
    pub fn order(&mut self, id: PawnId, order: &Order) -> bool {
        let time = self.time();
        let robot = self.robots.get_mut(&id).filter(|robot| robot.battery_left(time) > 0);
        robot.is_some_and(|robot| robot.follow(order))
    }

    /// Advances the world by one time step. Returns the reports that are due after it, robot by robot.
    pub fn step(&mut self) -> Vec<(PawnId, Report)> {
        let mut led = self.lead_objects();
        led.extend(self.lead_avatars());
        self.physics.lead_objects(&led);
        self.robots.values_mut().for_each(|robot| robot.before_step(&mut self.physics));
        self.apply_pulls();
        let is_engine_needed = self.physics.is_engine_needed();
        if is_engine_needed && !self.is_engine_running {
            // The engine's shapes are still where they were in its last step.
            self.enter_shapes();
        }
        self.physics.solve_articulated(self.robots.values_mut().map(Robot::bodies_mut), &*self.threads);
        if is_engine_needed {
            self.physics.lead_engine(self.robots.values().map(Robot::bodies));
            self.physics.step();
        }
        led.iter().for_each(|(id, pose)| self.physics.arrive(*id, pose));
        self.is_engine_running = is_engine_needed;
        self.steps += 1;
        let (time, steps) = (self.time(), self.steps);
        self.remove_faulty();
        let do_avatars_look = self.do_avatars_look(steps);
        if !do_avatars_look && !self.robots.values().any(|robot| robot.is_about_to_report(steps)) {
            return Vec::new();
        }
        // In reports, only rays query the engine's shapes of robots in reduced coordinates.
        let does_robot_look = || self.robots.values().any(|robot| robot.is_about_to_look(steps));
        if !is_engine_needed && (do_avatars_look || does_robot_look()) {
            self.enter_shapes();
        }
        let of_avatars = if do_avatars_look { self.look_ahead() } else { Vec::new() };
        let (physics, threads) = (&self.physics, &*self.threads);
        let held = &self.attached;
        let due = self.robots.iter_mut().filter(|(_, robot)| robot.is_about_to_report(steps));
        let mut reports: Vec<_> = due.map(|(&id, robot)| (id, robot, Vec::new())).collect();
        in_parts(threads, 1, &mut reports, &|reports| {
            for (_, robot, own) in reports {
                robot.report(physics, held, time, steps, |report| own.push(report));
            }
        });
        let of_robot =
            |(id, _, own): (PawnId, &mut Robot, Vec<Report>)| own.into_iter().map(move |report| (id, report));
        reports.into_iter().flat_map(of_robot).chain(of_avatars).collect()
    }

    /// Enters shapes for a question, which must not change the next step. A running engine keeps its shapes in place.
    fn enter_shapes_for_question(&mut self) {
        if !self.is_engine_running {
            self.enter_shapes();
        }
    }

    fn enter_shapes(&mut self) {
        self.physics.enter_shapes(self.robots.values().map(Robot::bodies));
    }

    /// Removes robots and restores objects whose state is a fault, before any of it is sent. So one broken robot does not break the others.
    fn remove_faulty(&mut self) {
        let faulty = self.robots.iter().filter_map(|(&id, robot)| Some((id, self.physics.fault(robot.bodies())?)));
        for (id, fault) in faulty.collect::<Vec<_>>() {
            if let Some(robot) = self.robots.get(&id) {
                let (class, name) = (robot.def().class.clone(), robot.name().to_owned());
                self.lost.push(LostRobot { id, class, name, fault });
            }
            self.remove(id);
        }
        self.restored.extend(self.physics.restore_objects());
    }

    /// Lets the robots report from the next step on, or not at all. Robots that do not report move with the same bits, but their sensors do
    /// not measure, which is a tenth of the time of a step. Robots that come later report.
    pub fn set_reporting(&mut self, is_reporting: bool) {
        let steps = self.steps;
        self.robots.values_mut().for_each(|robot| robot.set_reporting(is_reporting, steps));
    }

    /// Takes the robots that were removed because of a fault since the last call.
    pub fn take_lost(&mut self) -> Vec<LostRobot> {
        std::mem::take(&mut self.lost)
    }

    /// Takes the names and faults of the objects that were restored since the last call.
    pub fn take_restored(&mut self) -> Vec<(String, Fault)> {
        std::mem::take(&mut self.restored)
    }

    /// Returns the robots with class and name, in the order of their arrival.
    pub fn robots(&self) -> impl Iterator<Item = (PawnId, &str, &str)> {
        self.robots.iter().map(|(&id, robot)| (id, robot.def().class.as_str(), robot.name()))
    }

    /// Returns robots, world controllers and avatars with class and name, in this order.
    pub fn pawns(&self) -> impl Iterator<Item = (PawnId, &str, &str)> {
        let controllers = self.controllers.iter().map(|(&id, controller)| (id, CONTROLLER, controller.name.as_str()));
        let avatars = self.avatars.iter().map(|(&id, avatar)| (id, avatar.class_name(), avatar.name()));
        self.robots().chain(controllers).chain(avatars)
    }

    /// Returns the state of a robot's body and of its driven wheels.
    pub fn state(&self, id: PawnId) -> Option<(BodyState, Vec<WheelState>)> {
        let robot = self.robots.get(&id)?;
        Some((self.physics.body(robot.bodies()), self.physics.wheels(robot.bodies())))
    }

    /// Returns position and speed of every joint of a robot that has a value, wheels included, in the order of the links.
    pub fn joints(&self, id: PawnId) -> Option<Vec<JointState>> {
        self.robots.get(&id).map(|robot| self.physics.joints(robot.bodies()))
    }

    /// Returns the pose of a movable object that no robot holds.
    pub fn object(&self, id: ObjectId) -> Option<Pose> {
        self.physics.object(id)
    }

    /// Puts a movable object at a pose, at rest. Returns false if there is none with this id, or a number is not finite or off the map.
    pub fn put_object(&mut self, id: ObjectId, pose: &Pose) -> bool {
        let is_on_map = pose.translation.vector.iter().all(|&number| check::MAP_REACH.holds(number));
        let is_there =
            is_on_map && pose.rotation.coords.iter().all(|it| it.is_finite()) && self.physics.object(id).is_some();
        if is_there {
            self.physics.put_object(id, pose);
        }
        is_there
    }

    /// Returns the number of systems, over all steps, whose contact solver did not converge. A system is a robot, or several that touch each
    /// other. Its step uses the solver's answer anyway. See [`friction::Outcome::is_settled`].
    pub fn unsettled_steps(&self) -> u64 {
        self.physics.effort().unsettled
    }

    /// Returns the effort of the contact solver over all steps. A saved world goes on with the number of its unsettled systems alone.
    pub fn solver_effort(&self) -> SolverEffort {
        self.physics.effort()
    }

    /// Returns the approximate number of multiplications for touching bodies in the last step. Its limit is a constant plus a share for each
    /// body.
    pub fn work(&self) -> u64 {
        self.physics.work()
    }

    /// Returns a snapshot of all robots and objects.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            time: self.time(),
            robots: self.robots.values().map(|robot| robot.snapshot(&self.physics)).collect(),
            objects: self.objects().collect(),
            pulls: self.pull_snapshots().collect(),
        }
    }

    /// Returns a snapshot of one robot.
    pub fn observe(&self, id: PawnId) -> Option<RobotSnapshot> {
        self.robots.get(&id).map(|robot| robot.snapshot(&self.physics))
    }

    /// Returns the definition of a robot.
    pub fn robot(&self, id: PawnId) -> Option<&RobotDef> {
        self.robots.get(&id).map(Robot::def)
    }

    /// Returns the whole seconds that a robot's battery still lasts. `None` without a battery.
    pub fn battery(&self, id: PawnId) -> Option<i32> {
        let robot = self.robots.get(&id).filter(|robot| robot.def().battery.is_some())?;
        Some(robot.battery_left(self.time()))
    }

    /// Returns every movable object, by their ids, and those that robots hold.
    pub fn objects(&self) -> impl Iterator<Item = ObjectSnapshot> {
        let mut objects: Vec<ObjectSnapshot> = self.physics.objects().chain(self.attached_objects()).collect();
        objects.sort_by_key(|object| object.id);
        objects.into_iter()
    }

    /// Returns a hash of the number of steps and of the bits of every body. Worlds with different digests differ.
    pub fn digest(&self) -> u64 {
        let mut hash = scene::Fnv::default();
        hash.mix(&self.steps.to_le_bytes());
        let mut mix = |number: f64| hash.mix(&number.to_bits().to_le_bytes());
        self.physics.digest(&mut mix);
        for robot in self.robots.values() {
            let joints = self.physics.joints(robot.bodies());
            joints.iter().flat_map(|joint| [joint.position, joint.speed]).for_each(&mut mix);
            self.physics.numbers(robot.bodies()).into_iter().for_each(&mut mix);
        }
        self.attached.numbers().for_each(|number| mix(number as f64));
        hash.value()
    }

    /// Returns a class for the engine, which is compiled when a world of the scene first asks for it. `None` if there is none of that name, or
    /// it cannot be read.
    fn compiled(&mut self, class: &str) -> Option<Arc<CompiledRobot>> {
        let class = self.scene.class(class)?;
        self.physics.update_materials();
        Some(class)
    }

    /// Finds the class that INIT names, in any case. Its package is USARBot and may be left out.
    fn class(&mut self, init: &Init, problems: &mut Vec<Problem>) -> Option<Arc<CompiledRobot>> {
        if init.class_name.is_empty() {
            problems.push(Problem::MissingKey { verb: "INIT", key: "ClassName" });
            return None;
        }
        let package = init.class_name.rsplit_once('.').map_or("USARBot", |(package, _)| package);
        let known = self.def().robots.find(init.class());
        if let Some(class) = known.filter(|_| package.eq_ignore_ascii_case("USARBot")).cloned() {
            let compiled = self.compiled(&class);
            let why = self.def().robots.problem(&class).map(|why| format!("the class cannot be read: {why}"));
            problems.extend(why.map(|why| Problem::Ignored { what: format!("{{ClassName {class}}}"), why }));
            return compiled;
        }
        let of_referees = Init::CONTROLLER[..1].iter().map(|class| (*class).to_owned());
        let avatars = Init::AVATARS.iter().map(|class| format!("USARAvatar.{class}"));
        let robots = self.def().robots.keys().map(|class| format!("USARBot.{class}"));
        let classes: Vec<String> = robots.chain(of_referees).chain(avatars).collect();
        // Compared without the package, which is the same in all names and would make any two of them similar.
        let meant = names::nearest(init.class(), self.def().robots.keys().map(String::as_str));
        let (meant, expected) = match meant {
            Some(class) => (format!(" (did you mean `USARBot.{class}`?)"), "`usarsim robots` lists all".to_owned()),
            None => (String::new(), format!("expected one of {}", classes.join(", "))),
        };
        problems.push(Problem::UnknownName {
            key: "ClassName",
            got: shown(&init.class_name),
            meant,
            expected,
            instead: "no robot is spawned",
        });
        None
    }

    fn start_pose(&self, init: &Init, problems: &mut Vec<Problem>) -> Pose {
        if init.start.is_empty() {
            return scene::pose(init.location, init.rotation);
        }
        if let Some(start) = self.def().map.start(&init.start) {
            return scene::pose(start.position, start.rotation);
        }
        let known = self.def().map.starts.iter().map(|start| start.name.as_str());
        problems.push(Problem::unknown_name("Start", &init.start, known, "this map", "the origin is used"));
        Pose::identity()
    }
}

/// Returns the name that an INIT asks for, truncated.
fn pawn_name(init: &Init, problems: &mut Vec<Problem>) -> String {
    let name: String = init.name.chars().take(MAX_NAME_CHARS).collect();
    if name.len() < init.name.len() {
        let got = init.name.chars().count();
        problems.push(Problem::NameTooLong { key: "Name", got, limit: MAX_NAME_CHARS });
    }
    name
}

/// Returns the place that an INIT asks for, as written in its line.
fn wire_place(init: &Init) -> String {
    if !init.start.is_empty() {
        return format!("{{Start {}}}", shown(&init.start));
    }
    let [x, y, z] = init.location;
    format!("{{Location {x},{y},{z}}}")
}

/// Formats a position with two decimals, for people.
fn numbers(pose: &Pose) -> String {
    let [x, y, z] = pose.translation.vector.into();
    format!("{x:.2},{y:.2},{z:.2}")
}

fn wire_pose(pose: &NamedPose) -> WirePose {
    WirePose { name: pose.name.clone(), location: floats(pose.position), rotation: floats(pose.rotation) }
}

/// Finds the path node that is nearest in the horizontal plane (BotConnection.uc:394-432).
fn closest(nodes: &[NamedPose], position: [f64; 3]) -> Nfo {
    let distance = |node: &NamedPose| libm::hypot(node.position[0] - position[0], node.position[1] - position[1]);
    let nearest = nodes.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.map_or(Nfo::PathNode(PathNode { name: "None".to_owned(), location: [0.0; 3] }), |node| {
        let WirePose { name, location, .. } = wire_pose(node);
        Nfo::PathNode(PathNode { name, location })
    })
}
