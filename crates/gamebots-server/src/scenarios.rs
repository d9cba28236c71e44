//! Scenarios that viewers may begin.

use std::sync::Arc;

use axum::body::Bytes;
use page_protocol::scenarios_json;
use scene::{ScenarioCard, Setting};
use tokio::sync::OnceCell;

/// A scenario that a viewer may begin.
#[derive(Clone)]
pub struct AvailableScenario {
    /// The text of its card.
    pub card: ScenarioCard,
    /// Picture as JPEG.
    pub picture: Option<Vec<u8>>,
    /// Reads its map and goals. It fails with the reason in words.
    pub read: Arc<dyn Fn() -> Result<Setting, String> + Send + Sync>,
    /// Lines of a run that reaches its goals, with their times, for [`logbook::write_demo`].
    pub demo: Option<String>,
}

impl std::fmt::Debug for AvailableScenario {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.card.name)
    }
}

/// A scenario, with the log of its demo once somebody has asked for it.
#[derive(Debug)]
pub(crate) struct Offered {
    pub(crate) scenario: AvailableScenario,
    /// The log, or the reason why there is none.
    pub(crate) log: OnceCell<Result<Bytes, String>>,
}

/// The scenarios of a server. Copies share them.
#[derive(Debug, Clone, Default)]
pub struct Scenarios(Arc<Vec<Offered>>);

impl From<Vec<AvailableScenario>> for Scenarios {
    fn from(scenarios: Vec<AvailableScenario>) -> Self {
        let offered = |scenario| Offered { scenario, log: OnceCell::new() };
        Self(Arc::new(scenarios.into_iter().map(offered).collect()))
    }
}

impl Scenarios {
    /// Returns their cards as JSON.
    pub(crate) fn json(&self) -> String {
        let all = self.0.iter().map(|offered| &offered.scenario);
        scenarios_json(all.map(|it| (&it.card, it.demo.is_some(), it.picture.is_some())))
    }

    /// Returns a scenario by its name.
    pub(crate) fn find(&self, name: &str) -> Option<&Offered> {
        self.0.iter().find(|offered| offered.scenario.card.name == name)
    }

    /// Reads the setting of a scenario.
    ///
    /// # Errors
    /// When there is none of that name, or it cannot be read.
    pub(crate) fn read(&self, name: &str) -> Result<Setting, String> {
        let Offered { scenario, .. } = self.find(name).ok_or_else(|| {
            let known = names::listed(self.0.iter().map(|offered| offered.scenario.card.name.as_str()));
            format!("no scenario `{name}`: expected {known}")
        })?;
        (scenario.read)().map_err(|reason| format!("the scenario {name} is not begun: {reason}"))
    }
}
