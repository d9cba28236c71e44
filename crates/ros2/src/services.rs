//! Services: control of the world by std_srvs, and simulation_interfaces, the standard that simulators share.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use gamebots_proto::Command;
use gamebots_proto::command::{self, Init, Move};
use page_protocol::{Actor, Control};
use ros2_topics::{cdr, from_pose, header, interfaces as ros, json, name, pose, vector};
use scene::Snapshot;
use serde::Serialize;
use served_world::{Entrance, Health, Inquiry, Kind, Question, Session};
use sessions::Answer;
use sim_core::CompiledScene;
use tokio::sync::mpsc::UnboundedSender;
use tokio::time::{Instant, sleep};

use crate::interfaces::{self as srv, Request, category, code, scope, state};
use crate::node::{Caller, Node, ReadJson, Reply, cdr_of};
use crate::pipe::Order;
use crate::{Options, ReadRobot};

/// Longest wait for a reset, and for each step, real time.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time between two looks if the world has done what was asked.
const TICK: Duration = Duration::from_millis(2);
/// Longest time for news of the world, twice that of one that stands still.
const NEWS: Duration = Duration::from_millis(400);
/// Most steps of one call.
const MOST_STEPS: u64 = 100_000;
/// Most robots of one call.
const MOST_SPAWNED: usize = 256;
/// Ways to name a robot that is to come.
const SPAWNED_BY: &str =
    "expected the name of a class as the URI, which GetSpawnables lists, or a URDF or SDF as resource_string";
/// Largest compiled regular expression of a filter, bytes.
const FILTER_BYTES: usize = 1 << 16;

/// The way of replies to the node.
pub(crate) type Replies = UnboundedSender<Reply>;

/// The newest scene and snapshot.
pub(crate) type Latest = Arc<Mutex<Option<(CompiledScene, Arc<Snapshot>)>>>;

/// A session that opens when it is needed.
type Slot = tokio::sync::Mutex<Option<Session>>;

/// State that the services share.
#[derive(Clone)]
pub(crate) struct Desk {
    inquiry: Inquiry,
    entrance: Entrance,
    /// Session of the robots that were spawned here, and of the controller that moves things; each opens when it is needed.
    spawner: Arc<Slot>,
    mover: Arc<Slot>,
    latest: Latest,
    /// Maps that the world can change to, with a sentence about each.
    maps: Arc<[(String, String)]>,
    read_robot: Option<ReadRobot>,
}

/// A robot or an object by its name.
struct Entity {
    name: String,
    robot: Option<u64>,
    category: u8,
    description: String,
    state: srv::EntityState,
}

impl Desk {
    pub(crate) fn new(entrance: &Entrance, latest: Latest, options: &Options) -> Self {
        Self {
            inquiry: entrance.guest(Kind::Ros2),
            entrance: entrance.clone(),
            spawner: Arc::default(),
            mover: Arc::default(),
            latest,
            maps: options.maps.clone().into(),
            read_robot: options.read_robot.clone(),
        }
    }

    /// Offers all services. Each call is answered before the next of that service. Their replies go to `replies`.
    pub(crate) fn open(&self, node: &mut Node, replies: &Replies) -> Vec<tokio::task::JoinHandle<()>> {
        let mut offer = Offer { node, desk: self, replies, tasks: Vec::new() };
        offer.add("pause", "std_srvs/Trigger", async |desk: &Desk, _: srv::Empty| {
            desk.trigger(Control::Pause(true)).await
        });
        offer.add("resume", "std_srvs/Trigger", async |desk: &Desk, _: srv::Empty| {
            desk.trigger(Control::Pause(false)).await
        });
        offer.add("step", "std_srvs/Trigger", async |desk: &Desk, _: srv::Empty| triggered(desk.step(1).await));
        offer.add("reset", "std_srvs/Trigger", async |desk: &Desk, _: srv::Empty| triggered(desk.reset().await));
        offer.add("save", "std_srvs/Trigger", async |desk: &Desk, _: srv::Empty| desk.trigger(Control::Save).await);
        offer.standard("GetSimulatorFeatures", async |desk: &Desk, _: srv::Empty| srv::Features {
            features: srv::SimulatorFeatures {
                features: srv::FEATURES.to_vec(),
                spawn_formats: desk.read_robot.iter().flat_map(|_| ["urdf", "sdf"]).map(str::to_owned).collect(),
                custom_info: SPAWNED_BY.to_owned(),
            },
        });
        offer.standard("GetSimulationState", async |desk: &Desk, _: srv::Empty| desk.state().await);
        offer.standard("SetSimulationState", async |desk: &Desk, wanted: srv::SetState| {
            desk.set_state(wanted.state.state).await
        });
        offer.standard("StepSimulation", async |desk: &Desk, wanted: srv::Steps| desk.step_paused(wanted.steps).await);
        offer.standard("ResetSimulation", async |desk: &Desk, wanted: srv::Scope| desk.reset_scope(wanted.scope).await);
        offer.standard("GetEntities", async |desk: &Desk, srv::Filters { filters }: srv::Filters| {
            let (result, found) = desk.find(&filters);
            srv::Entities { result, entities: found.into_iter().map(|entity| entity.name).collect() }
        });
        offer.standard("GetEntitiesStates", async |desk: &Desk, srv::Filters { filters }: srv::Filters| {
            let (result, found) = desk.find(&filters);
            let (entities, states) = found.into_iter().map(|entity| (entity.name, entity.state)).unzip();
            srv::EntitiesStates { result, entities, states }
        });
        offer.standard("GetEntityState", async |desk: &Desk, asked: srv::Named| match desk.entity(&asked.entity) {
            Ok(entity) => srv::OneState { result: srv::Result::ok(), state: entity.state },
            Err(result) => srv::OneState { result, ..srv::OneState::default() },
        });
        offer.standard("GetEntityInfo", async |desk: &Desk, asked: srv::Named| match desk.entity(&asked.entity) {
            Ok(Entity { category, description, .. }) => {
                let category = srv::EntityCategory { category };
                let info = srv::EntityInfo { category, description, tags: Vec::new() };
                srv::Info { result: srv::Result::ok(), info }
            }
            Err(result) => srv::Info { result, ..srv::Info::default() },
        });
        offer.set_entity_state();
        offer.standard("GetSpawnables", async |desk: &Desk, _: srv::Sources| desk.spawnables());
        offer.standard("SpawnEntity", async |desk: &Desk, wanted: srv::SpawnEntity| desk.spawn(wanted).await);
        offer.standard("SpawnEntities", async |desk: &Desk, wanted: srv::SpawnRequests| desk.spawn_all(wanted).await);
        offer.standard("DeleteEntity", async |desk: &Desk, asked: srv::Named| desk.delete(&asked.entity).await);
        offer.standard("GetNamedPoses", async |desk: &Desk, asked: srv::Tags| desk.named_poses(&asked));
        offer.standard("GetCurrentWorld", async |desk: &Desk, _: srv::Empty| desk.current_world());
        offer.standard("GetAvailableWorlds", async |desk: &Desk, _: srv::Sources| srv::Worlds {
            result: srv::Result::ok(),
            worlds: desk.maps.iter().map(|(name, about)| world(name, about)).collect(),
        });
        offer.standard("LoadWorld", async |desk: &Desk, wanted: srv::LoadWorld| desk.load(wanted.world_resource).await);
        offer.tasks
    }

    fn latest(&self) -> Option<(CompiledScene, Arc<Snapshot>)> {
        self.latest.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    async fn health(&self) -> Result<Health, String> {
        self.inquiry.ask(Question::Health).await.ok_or_else(stops)
    }

    async fn control(&self, control: Control) -> Result<(), String> {
        let control = control.checked()?;
        let sent = self.inquiry.send(Question::Control(control, Actor("ROS 2".to_owned()))).await;
        sent.ok_or_else(stops)
    }

    async fn trigger(&self, control: Control) -> srv::Triggered {
        triggered(self.control(control).await)
    }

    /// Waits until the world is as wanted.
    async fn wait(&self, is_done: impl Fn(&Health) -> bool) -> Result<(), String> {
        let (mut progress, mut steps) = (Instant::now(), 0);
        loop {
            let health = self.health().await?;
            if is_done(&health) {
                return Ok(());
            }
            if std::mem::replace(&mut steps, health.steps) != health.steps {
                progress = Instant::now();
            }
            if progress.elapsed() > PATIENCE {
                return Err(format!("not done within {} s", PATIENCE.as_secs()));
            }
            sleep(TICK).await;
        }
    }

    /// Steps, and returns when the world has.
    async fn step(&self, steps: u64) -> Result<(), String> {
        let before = self.health().await?.steps;
        self.control(Control::Step(u32::try_from(steps).unwrap_or(u32::MAX))).await?;
        self.wait(|health| health.steps >= before + steps).await
    }

    async fn step_paused(&self, steps: u64) -> srv::Done {
        let is_paused = self.health().await.is_ok_and(|health| health.paused);
        let result = if !is_paused {
            srv::Result::failed(code::INCORRECT_STATE, "the world is not paused: SetSimulationState pauses it")
        } else if !(1..=MOST_STEPS).contains(&steps) {
            srv::Result::failed(code::OPERATION_FAILED, format!("{steps} steps: expected 1 to {MOST_STEPS}"))
        } else {
            outcome(self.step(steps).await)
        };
        srv::Done { result }
    }

    /// Asks for a fresh world, and returns when it is there.
    async fn restart(&self, control: Control) -> Result<(), String> {
        let before = self.health().await?.resets;
        self.control(control).await?;
        self.wait(|health| health.resets > before).await
    }

    async fn reset(&self) -> Result<(), String> {
        self.restart(Control::Reset).await
    }

    /// Gives a command by a session of these services, which opens when it is needed, with an INIT if there is one.
    async fn order(&self, slot: &Slot, init: Option<Init>, command: Command) -> Result<Answer, String> {
        let mut slot = slot.lock().await;
        if slot.is_none() {
            let session = self.entrance.open_program("ROS 2 services").map_err(|_| stops())?;
            if let Some(init) = init {
                session.order(Command::Init(init)).await.map_err(|_| stops())?;
            }
            *slot = Some(session);
        }
        let session = slot.as_ref().ok_or_else(stops)?;
        session.order(command).await.map_err(|_| stops())
    }

    async fn reset_scope(&self, asked: u8) -> srv::Done {
        let with_spawned = asked & scope::SPAWNED != 0 || asked == scope::DEFAULT;
        let with_world =
            matches!(asked, scope::DEFAULT | scope::ALL | scope::TIME_AND_STATE | scope::TIME_STATE_AND_SPAWNED);
        if !with_world && asked != scope::SPAWNED {
            let why = "time and state are reset together: expected scope 0, 3, 4, 7 or 255";
            return srv::Done { result: srv::Result::failed(code::FEATURE_UNSUPPORTED, why) };
        }
        if with_spawned {
            // The session's robots leave with it.
            *self.spawner.lock().await = None;
        }
        let reset = if with_world { self.reset().await } else { Ok(()) };
        srv::Done { result: outcome(reset) }
    }

    async fn state(&self) -> srv::StateIs {
        match self.health().await {
            Ok(Health { paused, .. }) => {
                let state = if paused { state::PAUSED } else { state::PLAYING };
                srv::StateIs { state: srv::SimulationState { state }, result: srv::Result::ok() }
            }
            Err(why) => srv::StateIs { result: outcome(Err(why)), ..srv::StateIs::default() },
        }
    }

    async fn set_state(&self, wanted: u8) -> srv::Done {
        let is_paused = self.health().await.is_ok_and(|health| health.paused);
        let result = match wanted {
            state::PLAYING if !is_paused => srv::Result::failed(code::ALREADY_IN_TARGET_STATE, "it is playing"),
            state::PAUSED if is_paused => srv::Result::failed(code::ALREADY_IN_TARGET_STATE, "it is paused"),
            state::PLAYING => outcome(self.control(Control::Pause(false)).await),
            state::PAUSED => outcome(self.control(Control::Pause(true)).await),
            state::STOPPED => outcome(match self.control(Control::Pause(true)).await {
                Ok(()) => self.reset().await,
                Err(why) => Err(why),
            }),
            _ => srv::Result::failed(code::FEATURE_UNSUPPORTED, "whoever started the server stops it"),
        };
        srv::Done { result }
    }

    /// Lists robots and movable objects.
    fn entities(&self) -> Vec<Entity> {
        let Some((_, snapshot)) = self.latest() else { return Vec::new() };
        let robots = snapshot.robots.iter().map(|robot| {
            let own = robot.body.pose.rotation;
            let [linear, angular] = [robot.body.linear, robot.body.angular].map(|it| own.inverse() * it);
            Entity {
                name: if robot.name.is_empty() { format!("robot_{}", robot.id.0) } else { robot.name.clone() },
                robot: Some(robot.id.0),
                category: category::ROBOT,
                description: robot.class.clone(),
                state: srv::EntityState {
                    header: header(snapshot.time, ros2_topics::MAP),
                    pose: pose(&robot.body.pose),
                    twist: ros::Twist { linear: vector(linear), angular: vector(angular) },
                    acceleration: srv::Accel::default(),
                },
            }
        });
        let objects = snapshot.objects.iter().map(|object| Entity {
            name: object.def.solid.name.clone(),
            robot: None,
            category: category::DYNAMIC_OBJECT,
            description: object.def.solid.material.name.clone(),
            state: srv::EntityState {
                header: header(snapshot.time, ros2_topics::MAP),
                pose: pose(&object.pose),
                ..srv::EntityState::default()
            },
        });
        robots.chain(objects).collect()
    }

    fn entity(&self, wanted: &str) -> Result<Entity, srv::Result> {
        let found = self.entities().into_iter().find(|entity| entity.name == wanted);
        found.ok_or_else(|| srv::Result::failed(code::NOT_FOUND, format!("no entity `{wanted}`")))
    }

    /// Finds entities: by a regular expression that matches the whole name, categories, and a box.
    fn find(&self, filters: &srv::EntityFilters) -> (srv::Result, Vec<Entity>) {
        let srv::EntityFilters { filter, categories, tags, bounds } = filters;
        if !tags.tags.is_empty() {
            return (srv::Result::failed(code::FEATURE_UNSUPPORTED, "entities have no tags"), Vec::new());
        }
        let corners = match (bounds.kind, bounds.points.as_slice()) {
            (0, _) => None,
            (srv::BOX, [one, other]) => Some([one, other].map(|it| [it.x, it.y, it.z])),
            _ => {
                let why = "expected no bounds, or a box by two corners";
                return (srv::Result::failed(code::FEATURE_UNSUPPORTED, why), Vec::new());
            }
        };
        let whole = regex::RegexBuilder::new(&format!("^(?:{filter})$")).size_limit(FILTER_BYTES).build();
        let whole = match whole {
            Ok(whole) => whole,
            Err(error) => return (srv::Result::failed(code::OPERATION_FAILED, error.to_string()), Vec::new()),
        };
        let is_within = |entity: &Entity| {
            let at = &entity.state.pose.position;
            corners.is_none_or(|[one, other]| {
                let sides = [at.x, at.y, at.z].into_iter().zip(one).zip(other);
                sides.into_iter().all(|((at, one), other)| (one.min(other)..=one.max(other)).contains(&at))
            })
        };
        let is_meant = |entity: &Entity| {
            (filter.is_empty() || whole.is_match(&entity.name))
                && (categories.is_empty() || categories.iter().any(|it| it.category == entity.category))
                && is_within(entity)
        };
        (srv::Result::ok(), self.entities().into_iter().filter(is_meant).collect())
    }

    async fn set_entity_state(&self, wanted: srv::SetEntityState) -> srv::Done {
        srv::Done { result: self.put(wanted).await.err().unwrap_or_else(srv::Result::ok) }
    }

    /// Puts a robot, or an object that a world controller made here, at a pose.
    async fn put(&self, wanted: srv::SetEntityState) -> Result<(), srv::Result> {
        let srv::SetEntityState { entity, state, set_pose, set_twist } = wanted;
        if set_twist && state.twist != ros::Twist::default() {
            let why = "entities are put at rest: expected a twist of 0";
            return Err(srv::Result::failed(code::FEATURE_UNSUPPORTED, why));
        }
        self.entity(&entity)?;
        if !set_pose {
            return Ok(());
        }
        let placed = placed(&state.header.frame_id, &state.pose);
        let (location, rotation) = placed.ok_or_else(|| srv::Result::failed(code::INVALID_STATE_POSE, POSE_RULE))?;
        let failed = |why: String| srv::Result::failed(code::OPERATION_FAILED, why);
        if self.latest().is_some_and(|(scene, _)| scene.def().is_contest()) {
            return Err(failed("a league moves no robots".to_owned()));
        }
        let init = Init { class_name: Init::CONTROLLER[0].to_owned(), name: "ROS 2".to_owned(), ..Init::default() };
        let order = command::Control::Move(Move { name: entity, is_relative: false, location, rotation });
        let answer = self.order(&self.mover, Some(init), Command::Control(order)).await.map_err(failed)?;
        answer.problems.first().map_or(Ok(()), |problem| Err(failed(problem.to_string())))
    }

    fn spawnables(&self) -> srv::Spawnables {
        let classes = self.latest().map(|(scene, _)| scene.def().robots.keys().cloned().collect::<Vec<_>>());
        let spawnable = |class: String| srv::Spawnable {
            entity_resource: srv::Resource { uri: class, resource_string: String::new() },
            ..srv::Spawnable::default()
        };
        let spawnables = classes.unwrap_or_default().into_iter().map(spawnable).collect();
        srv::Spawnables { result: srv::Result::ok(), spawnables }
    }

    async fn spawn_all(&self, wanted: srv::SpawnRequests) -> srv::SpawnResults {
        let mut results = Vec::new();
        if wanted.spawn_requests.len() > MOST_SPAWNED {
            let why = format!("{} robots: expected at most {MOST_SPAWNED}", wanted.spawn_requests.len());
            return srv::SpawnResults { result: srv::Result::failed(code::OPERATION_FAILED, why), results };
        }
        for request in wanted.spawn_requests {
            results.push(self.spawn(request).await);
        }
        let failed = results.iter().filter(|it: &&srv::SpawnResult| it.result.result != code::OK).count();
        let result = if failed == 0 {
            srv::Result::ok()
        } else {
            srv::Result::failed(code::SPAWN_FAILED, format!("{failed} of {} did not come", results.len()))
        };
        srv::SpawnResults { result, results }
    }

    async fn spawn(&self, wanted: srv::SpawnEntity) -> srv::SpawnResult {
        match self.come(wanted).await {
            Ok(entity_name) => srv::SpawnResult { result: srv::Result::ok(), entity_name },
            Err(result) => srv::SpawnResult { result, ..srv::SpawnResult::default() },
        }
    }

    /// Spawns a robot. Returns its name.
    async fn come(&self, wanted: srv::SpawnEntity) -> Result<String, srv::Result> {
        let failed = |result, why: &str| Err(srv::Result::failed(result, why));
        let srv::SpawnEntity { name: called, allow_renaming, entity_resource, entity_namespace, initial_pose } = wanted;
        let srv::Resource { uri, resource_string } = entity_resource;
        if uri.is_empty() && resource_string.is_empty() {
            return failed(code::NO_RESOURCE, SPAWNED_BY);
        }
        if !(entity_namespace.is_empty() || entity_namespace.trim_start_matches('/') == name(&called)) {
            let why = format!("`{entity_namespace}`: a robot's namespace is its name");
            return failed(code::NAMESPACE_INVALID, &why);
        }
        let placed = placed(&initial_pose.header.frame_id, &initial_pose.pose);
        let (location, rotation) = placed.ok_or_else(|| srv::Result::failed(code::INVALID_POSE, POSE_RULE))?;
        // A robot whose name is taken adds no class.
        let wanted = if uri.is_empty() { "robot" } else { &uri };
        let name = self.free_name(called, wanted, allow_renaming)?;
        let class_name = if resource_string.is_empty() { uri } else { self.add_class(resource_string).await? };
        let init = Init { class_name, name: name.clone(), location, rotation, ..Init::default() };
        let answer = self.order(&self.spawner, None, Command::Init(init)).await;
        let answer = answer.map_err(|why| srv::Result::failed(code::OPERATION_FAILED, why))?;
        if answer.spawned.is_some() {
            self.wait_for(|| self.entity(&name).is_ok()).await;
            return Ok(name);
        }
        let why: Vec<String> = answer.problems.iter().map(ToString::to_string).collect();
        failed(code::OPERATION_FAILED, &why.join("; "))
    }

    /// Adds the class of a URDF, and returns its name.
    async fn add_class(&self, text: String) -> Result<String, srv::Result> {
        let unsupported = || srv::Result::failed(code::UNSUPPORTED_FORMAT, "robots are spawned by their classes alone");
        let ReadRobot(read) = self.read_robot.clone().ok_or_else(unsupported)?;
        let (scene, _) = self.latest().ok_or_else(|| srv::Result::failed(code::OPERATION_FAILED, stops()))?;
        let add = move || scene.def().robots.add(read(&text)?).map(str::to_owned);
        let added = tokio::task::spawn_blocking(add).await;
        let added = added.unwrap_or_else(|_| Err("a defect: the URDF cannot be read".to_owned()));
        added.map_err(|why| srv::Result::failed(code::RESOURCE_PARSE_ERROR, why))
    }

    /// Returns the name of a new robot of a class: its own, or, if it may be renamed, one that nobody has.
    fn free_name(&self, called: String, class: &str, allow_renaming: bool) -> Result<String, srv::Result> {
        let taken: Vec<String> = self.entities().into_iter().map(|entity| entity.name).collect();
        let is_free = |name: &str| !name.is_empty() && !taken.iter().any(|taken| taken == name);
        let own = if called.is_empty() && allow_renaming { class.to_owned() } else { called };
        if is_free(&own) {
            return Ok(own);
        }
        if allow_renaming {
            return Ok(names::free(&own, is_free));
        }
        Err(match own.as_str() {
            "" => srv::Result::failed(code::NAME_INVALID, "expected a name, or allow_renaming"),
            _ => srv::Result::failed(code::NAME_NOT_UNIQUE, format!("`{own}` is taken")),
        })
    }

    /// Waits a little until it is known here what the world has done, so that the next question finds it.
    async fn wait_for(&self, is_known: impl Fn() -> bool) {
        let end = Instant::now() + NEWS;
        while !is_known() && Instant::now() < end {
            sleep(TICK).await;
        }
    }

    async fn delete(&self, wanted: &str) -> srv::Done {
        let result = match self.entity(wanted) {
            Ok(Entity { robot: Some(robot), .. }) => {
                let removed = self.control(Control::Remove(robot)).await;
                if removed.is_ok() {
                    self.wait_for(|| self.entity(wanted).is_err()).await;
                }
                outcome(removed)
            }
            Ok(_) => srv::Result::failed(code::OPERATION_FAILED, "the map has it: only robots can be deleted"),
            Err(result) => result,
        };
        srv::Done { result }
    }

    fn named_poses(&self, asked: &srv::Tags) -> srv::NamedPoses {
        let Some((scene, _)) = self.latest().filter(|_| asked.tags.tags.is_empty()) else {
            return srv::NamedPoses { result: srv::Result::ok(), poses: Vec::new() };
        };
        let starts = scene.def().map.starts.iter();
        let named = starts.map(|start| srv::NamedPose {
            name: start.name.clone(),
            pose: pose(&scene::pose(start.position, start.rotation)),
            ..srv::NamedPose::default()
        });
        srv::NamedPoses { result: srv::Result::ok(), poses: named.collect() }
    }

    fn current_world(&self) -> srv::World {
        let map = self.latest().map(|(scene, _)| scene.def().map.clone()).unwrap_or_default();
        srv::World { result: srv::Result::ok(), world: world(&map.name, &map.description) }
    }

    /// Changes the map, and returns when the world is on it.
    async fn load(&self, resource: srv::Resource) -> srv::World {
        let failed =
            |result, why: String| srv::World { result: srv::Result::failed(result, why), ..srv::World::default() };
        let srv::Resource { uri, resource_string } = resource;
        if !resource_string.is_empty() {
            return failed(code::WORLD_UNSUPPORTED_FORMAT, "expected the name of a map as the URI".to_owned());
        }
        if uri.is_empty() {
            return failed(code::WORLD_NO_RESOURCE, "expected the name of a map as the URI".to_owned());
        }
        if !self.maps.iter().any(|(name, _)| *name == uri) {
            let names: Vec<&str> = self.maps.iter().map(|(name, _)| name.as_str()).collect();
            return failed(code::NOT_FOUND, format!("no map `{uri}`: expected {}", names.join(", ")));
        }
        match self.restart(Control::Map(uri.clone())).await {
            Ok(()) => {
                let about = self.maps.iter().find(|(name, _)| *name == uri).map_or("", |(_, about)| about.as_str());
                srv::World { result: srv::Result::ok(), world: world(&uri, about) }
            }
            Err(why) => failed(code::OPERATION_FAILED, why),
        }
    }
}

/// Rule of a pose in a request.
const POSE_RULE: &str = "expected finite numbers in the frame map";

/// Returns position and angles of the wire for a pose in the map; `None` if it is in another frame or not finite.
fn placed(frame: &str, at: &ros::Pose) -> Option<([f64; 3], [f64; 3])> {
    let is_map = ["", "map", "world"].contains(&frame.trim_start_matches('/'));
    let placed = scene::position_and_rotation(&from_pose(at));
    let is_finite = placed.0.iter().chain(&placed.1).all(|number| number.is_finite());
    (is_map && is_finite).then_some(placed)
}

fn world(name: &str, description: &str) -> srv::WorldResource {
    srv::WorldResource {
        name: name.to_owned(),
        world_resource: srv::Resource { uri: name.to_owned(), resource_string: String::new() },
        description: description.to_owned(),
        tags: Vec::new(),
    }
}

/// Returns the reason why nothing is done any longer.
fn stops() -> String {
    "the server stops".to_owned()
}

fn triggered(outcome: Result<(), String>) -> srv::Triggered {
    srv::Triggered { success: outcome.is_ok(), message: outcome.err().unwrap_or_default() }
}

fn outcome(outcome: Result<(), String>) -> srv::Result {
    outcome.map_or_else(|why| srv::Result::failed(code::OPERATION_FAILED, why), |()| srv::Result::ok())
}

/// A function that reads a request; `None` if the bytes are none.
type ReadCdr<Q> = fn(&[u8]) -> Option<Q>;

/// Services that are being offered.
struct Offer<'a> {
    node: &'a mut Node,
    desk: &'a Desk,
    replies: &'a Replies,
    tasks: Vec<tokio::task::JoinHandle<()>>,
}

impl Offer<'_> {
    /// Offers a service of simulation_interfaces by the name of its type, as `/usarsim/get_entities` for `GetEntities`.
    fn standard<Q: Request + 'static, R: Serialize + 'static>(
        &mut self,
        kind: &str,
        answer: impl AsyncFn(&Desk, Q) -> R + 'static,
    ) {
        self.add(&snake(kind), &format!("simulation_interfaces/{kind}"), answer);
    }

    fn add<Q: Request + 'static, R: Serialize + 'static>(
        &mut self,
        called: &str,
        kind: &str,
        answer: impl AsyncFn(&Desk, Q) -> R + 'static,
    ) {
        self.add_read(called, kind, (Q::read, cdr_of::<Q>), answer);
    }

    /// Offers SetEntityState, which has two versions.
    fn set_entity_state(&mut self) {
        let answer = async |desk: &Desk, wanted: srv::SetEntityState| desk.set_entity_state(wanted).await;
        let read = (srv::SetEntityState::read as ReadCdr<_>, srv::SetEntityState::of_json as ReadJson);
        self.add_read("set_entity_state", "simulation_interfaces/SetEntityState", read, answer);
    }

    /// Offers a service whose requests are read from CDR, and made into CDR from JSON.
    fn add_read<Q: 'static, R: Serialize + 'static>(
        &mut self,
        called: &str,
        kind: &str,
        (read, of_json): (ReadCdr<Q>, ReadJson),
        answer: impl AsyncFn(&Desk, Q) -> R + 'static,
    ) {
        let (mut requests, number) = self.node.offer(format!("/usarsim/{called}"), kind.to_owned(), of_json);
        let (desk, replies) = (self.desk.clone(), self.replies.clone());
        self.tasks.push(tokio::task::spawn_local(async move {
            while let Some((from, bytes)) = requests.recv().await {
                // A request that cannot be read has no answer: its client waits as for a service that is not there.
                let Some(request) = read(&bytes) else { continue };
                let response = answer(&desk, request).await;
                let reply = match from {
                    Caller::Dds(to) => {
                        let message = cdr::write(&response).ok();
                        message.map(|message| Reply::Dds(Order::Reply { number, to, message }))
                    }
                    Caller::Rosbridge(asking) => json::write(&response).ok().map(|it| Reply::Rosbridge(asking, it)),
                    Caller::Nameless => None,
                };
                if reply.is_some_and(|reply| replies.send(reply).is_err()) {
                    return;
                }
            }
        }));
    }
}

/// Returns the name of a service for the name of its type: `get_entities` for `GetEntities`.
fn snake(kind: &str) -> String {
    let mut name = String::new();
    for letter in kind.chars() {
        if letter.is_ascii_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.push(letter.to_ascii_lowercase());
    }
    name
}
