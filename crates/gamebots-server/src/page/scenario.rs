//! Scenarios on the page: their cards, pictures, and logs of their demos. A demo is played when somebody first asks for it, so its log is
//! always of this version's physics.

use axum::body::Bytes;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use scene::{Setting, WorldDef};
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

use crate::page::packed::json;
use crate::scenarios::{AvailableScenario, Offered, Scenarios};

/// Scenarios as the page offers them.
pub(crate) struct ScenarioPages {
    scenarios: Scenarios,
    /// Classes of robots and objects for demos; the maps are the scenarios'.
    world: WorldDef,
    /// Turn to play a demo, which takes a core for a second or two.
    turn: Semaphore,
}

impl ScenarioPages {
    pub(crate) fn new(scenarios: Scenarios, world: &WorldDef) -> Self {
        Self { scenarios, world: world.clone().on(Setting::default()), turn: Semaphore::new(1) }
    }

    /// Answers with the cards of all scenarios.
    pub(crate) fn list(&self) -> Response {
        json(self.scenarios.json().into())
    }

    /// Answers with a scenario's picture.
    pub(crate) fn picture(&self, name: &str) -> Response {
        match self.scenarios.find(name).and_then(|offered| offered.scenario.picture.clone()) {
            Some(picture) => ([(header::CONTENT_TYPE, "image/jpeg")], picture).into_response(),
            None => nothing(name),
        }
    }

    /// Answers with the log of a scenario's demo. It is played once; who asks meanwhile waits.
    pub(crate) async fn demo(&self, name: &str) -> Response {
        let Some(Offered { scenario, log }) = self.scenarios.find(name) else { return nothing(name) };
        let Some(lines) = scenario.demo.clone() else { return nothing(name) };
        let played = log.get_or_init(|| async {
            let _turn = self.turn.acquire().await;
            let (scenario, world) = (scenario.clone(), self.world.clone());
            let played = spawn_blocking(move || play(&scenario, world, &lines));
            played.await.unwrap_or_else(|_| Err("a defect: the demo cannot be played".to_owned()))
        });
        match played.await {
            Ok(log) => ([(header::CONTENT_TYPE, "application/octet-stream")], log.clone()).into_response(),
            Err(reason) => (StatusCode::UNPROCESSABLE_ENTITY, format!("{reason}\n")).into_response(),
        }
    }
}

fn play(scenario: &AvailableScenario, world: WorldDef, lines: &str) -> Result<Bytes, String> {
    let world = world.on((scenario.read)()?);
    world.check().map_err(|problem| problem.to_string())?;
    let file = tempfile::NamedTempFile::new().map_err(|error| error.to_string())?;
    logbook::write_demo(world, lines, file.path()).map_err(|error| error.to_string())?;
    std::fs::read(file.path()).map(Bytes::from).map_err(|error| error.to_string())
}

fn nothing(name: &str) -> Response {
    (StatusCode::NOT_FOUND, format!("nothing is there of a scenario {name}\n")).into_response()
}
