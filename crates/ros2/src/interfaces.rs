//! Requests and responses of services: std_srvs and simulation_interfaces, the standard of simulators. In version 2 of the latter a
//! `Resource` holds two fields that version 1 has side by side. On the wire both are the same.

use ros2_topics::interfaces::{Header, Pose, PoseStamped, Twist, Vector3};
use ros2_topics::{cdr, json};
use serde::{Deserialize, Serialize};

use crate::node::cdr_of;

/// An empty request: one byte that C needs.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Empty {
    structure_needs_at_least_one_member: u8,
}

/// Response of `std_srvs/Trigger`.
#[derive(Debug, Serialize)]
pub(crate) struct Triggered {
    pub(crate) success: bool,
    pub(crate) message: String,
}

/// Codes of `simulation_interfaces/Result`.
pub(crate) mod code {
    pub(crate) const FEATURE_UNSUPPORTED: u8 = 0;
    pub(crate) const OK: u8 = 1;
    pub(crate) const NOT_FOUND: u8 = 2;
    pub(crate) const INCORRECT_STATE: u8 = 3;
    pub(crate) const OPERATION_FAILED: u8 = 4;
    // SpawnEntity
    pub(crate) const NAME_NOT_UNIQUE: u8 = 101;
    pub(crate) const NAME_INVALID: u8 = 102;
    pub(crate) const UNSUPPORTED_FORMAT: u8 = 103;
    pub(crate) const NO_RESOURCE: u8 = 104;
    pub(crate) const NAMESPACE_INVALID: u8 = 105;
    pub(crate) const RESOURCE_PARSE_ERROR: u8 = 106;
    pub(crate) const INVALID_POSE: u8 = 109;
    // SpawnEntities
    pub(crate) const SPAWN_FAILED: u8 = 150;
    // SetEntityState
    pub(crate) const INVALID_STATE_POSE: u8 = 101;
    // SetSimulationState
    pub(crate) const ALREADY_IN_TARGET_STATE: u8 = 101;
    // LoadWorld
    pub(crate) const WORLD_UNSUPPORTED_FORMAT: u8 = 101;
    pub(crate) const WORLD_NO_RESOURCE: u8 = 102;
}

/// Values of `simulation_interfaces/SimulationState`.
pub(crate) mod state {
    pub(crate) const STOPPED: u8 = 0;
    pub(crate) const PLAYING: u8 = 1;
    pub(crate) const PAUSED: u8 = 2;
}

/// Values of `simulation_interfaces/EntityCategory`.
pub(crate) mod category {
    pub(crate) const ROBOT: u8 = 1;
    pub(crate) const DYNAMIC_OBJECT: u8 = 4;
}

/// Scopes of `simulation_interfaces/ResetSimulation`.
pub(crate) mod scope {
    pub(crate) const DEFAULT: u8 = 0;
    pub(crate) const TIME_AND_STATE: u8 = 3;
    pub(crate) const SPAWNED: u8 = 4;
    pub(crate) const TIME_STATE_AND_SPAWNED: u8 = 7;
    pub(crate) const ALL: u8 = 255;
}

/// Values of `simulation_interfaces/SimulatorFeatures` that hold here: spawning, deleting, named poses, entities' boxes and categories,
/// states and infos, spawnables, reset of all and of what was spawned, states of the simulation, steps, worlds, and spawning of several.
pub(crate) const FEATURES: [u16; 22] =
    [0, 1, 2, 6, 8, 10, 11, 12, 14, 20, 23, 24, 25, 26, 31, 32, 40, 44, 45, 50, 21, 22];

/// `simulation_interfaces/Bounds` of a box: two corners.
pub(crate) const BOX: u8 = 1;

/// `simulation_interfaces/TagsFilter`. Nothing has tags here.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct TagsFilter {
    pub(crate) tags: Vec<String>,
    #[serde(rename = "filter_mode")]
    _filter_mode: u8,
}

macro_rules! structs {
    ($($name:ident { $($(#[$with:meta])* $field:ident: $kind:ty,)* })*) => {$(
        #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
        #[serde(default)]
        pub(crate) struct $name { $($(#[$with])* pub(crate) $field: $kind,)* }
    )*};
}

structs! {
    Result { result: u8, error_message: String, }
    Resource { uri: String, resource_string: String, }
    Bounds { #[serde(rename = "type")] kind: u8, points: Vec<Vector3>, }
    EntityCategory { category: u8, }
    EntityInfo { category: EntityCategory, description: String, tags: Vec<String>, }
    Accel { linear: Vector3, angular: Vector3, }
    EntityState { header: Header, pose: Pose, twist: Twist, acceleration: Accel, }
    NamedPose { name: String, description: String, tags: Vec<String>, pose: Pose, }
    SimulationState { state: u8, }
    SimulatorFeatures { features: Vec<u16>, spawn_formats: Vec<String>, custom_info: String, }
    Spawnable { entity_resource: Resource, description: String, spawn_bounds: Bounds, }
    SpawnEntity {
        name: String, allow_renaming: bool, entity_resource: Resource, entity_namespace: String, initial_pose: PoseStamped,
    }
    SpawnResult { result: Result, entity_name: String, }
    WorldResource { name: String, world_resource: Resource, description: String, tags: Vec<String>, }
    Named { entity: String, }
    Done { result: Result, }
    Features { features: SimulatorFeatures, }
    Spawnables { result: Result, spawnables: Vec<Spawnable>, }
    Sources { sources: Vec<String>, }
    NamedPoses { result: Result, poses: Vec<NamedPose>, }
    Entities { result: Result, entities: Vec<String>, }
    EntitiesStates { result: Result, entities: Vec<String>, states: Vec<EntityState>, }
    OneState { result: Result, state: EntityState, }
    Info { result: Result, info: EntityInfo, }
    StateIs { state: SimulationState, result: Result, }
    SetState { state: SimulationState, }
    Scope { scope: u8, }
    Steps { steps: u64, }
    SpawnRequests { spawn_requests: Vec<SpawnEntity>, }
    SpawnResults { result: Result, results: Vec<SpawnResult>, }
    LoadWorld {
        world_resource: Resource, fail_on_unsupported_element: bool, ignore_missing_or_unsupported_assets: bool,
    }
    World { result: Result, world: WorldResource, }
    Worlds { result: Result, worlds: Vec<WorldResource>, }
}

/// `simulation_interfaces/EntityFilters`.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct EntityFilters {
    pub(crate) filter: String,
    pub(crate) categories: Vec<EntityCategory>,
    pub(crate) tags: TagsFilter,
    pub(crate) bounds: Bounds,
}

/// Request of `simulation_interfaces/GetEntities` and `GetEntitiesStates`.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Filters {
    pub(crate) filters: EntityFilters,
}

/// Request of `simulation_interfaces/GetNamedPoses`.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Tags {
    pub(crate) tags: TagsFilter,
}

/// Request of `simulation_interfaces/SetEntityState`. Version 1 ends after the state, and sets all of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SetEntityState {
    pub(crate) entity: String,
    pub(crate) state: EntityState,
    pub(crate) set_pose: bool,
    pub(crate) set_twist: bool,
}

structs! {
    SetEntityState1 { entity: String, state: EntityState, }
    SetEntityState2 { entity: String, state: EntityState, set_pose: bool, set_twist: bool, set_acceleration: bool, }
}

/// A request that can be read.
pub(crate) trait Request: Serialize + serde::de::DeserializeOwned {
    /// Reads it from CDR, little endian; `None` if it is none.
    fn read(bytes: &[u8]) -> Option<Self>;
}

impl<T: Serialize + serde::de::DeserializeOwned> Request for T {
    fn read(bytes: &[u8]) -> Option<Self> {
        cdr::read(bytes).ok()
    }
}

impl SetEntityState {
    /// Reads it in either version.
    pub(crate) fn read(bytes: &[u8]) -> Option<Self> {
        if let Some(SetEntityState2 { entity, state, set_pose, set_twist, .. }) = SetEntityState2::read(bytes) {
            return Some(Self { entity, state, set_pose, set_twist });
        }
        let SetEntityState1 { entity, state } = SetEntityState1::read(bytes)?;
        Some(Self { entity, state, set_pose: true, set_twist: true })
    }

    /// Makes its CDR from JSON in either version: the second has switches.
    pub(crate) fn of_json(text: &str) -> std::result::Result<Vec<u8>, String> {
        match json::read::<serde_json::Value>(text).is_ok_and(|it| it.get("set_pose").or(it.get("set_twist")).is_some())
        {
            true => cdr_of::<SetEntityState2>(text),
            false => cdr_of::<SetEntityState1>(text),
        }
    }
}

impl Result {
    pub(crate) fn ok() -> Self {
        Self { result: code::OK, error_message: String::new() }
    }

    pub(crate) fn failed(result: u8, why: impl Into<String>) -> Self {
        Self { result, error_message: why.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cdr(message: &impl Serialize) -> Vec<u8> {
        cdr::write(message).expect("CDR")
    }

    #[test]
    fn a_state_is_set_in_both_versions_of_the_standard() {
        let (entity, state) = ("R1".to_owned(), EntityState::default());
        let first = cdr(&SetEntityState1 { entity: entity.clone(), state: state.clone() });
        let second = SetEntityState2 {
            entity: entity.clone(),
            state: state.clone(),
            set_pose: true,
            set_twist: false,
            set_acceleration: true,
        };
        let read = |bytes: &[u8]| SetEntityState::read(bytes).expect("a request");
        assert_eq!(
            read(&first),
            SetEntityState { entity: entity.clone(), state: state.clone(), set_pose: true, set_twist: true }
        );
        assert_eq!(read(&cdr(&second)), SetEntityState { entity, state, set_pose: true, set_twist: false });
        assert_eq!(SetEntityState::read(&first[..20]), None);
    }
}
