//! Parsers of values on the command line.

use scene::DriveModel;
use scene::check::TIME_STEP;

/// Parses a number from the command line, within bounds.
pub(crate) fn within(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if (least..=most).contains(&value) { Ok(value) } else { Err(format!("expected {least} to {most}")) }
}

/// Parses a time step, s.
pub(crate) fn time_step(text: &str) -> Result<f64, String> {
    within(text, TIME_STEP.least, TIME_STEP.most)
}

/// Parses simulated seconds per real second; 0 is as fast as possible.
pub(crate) fn real_time_factor(text: &str) -> Result<f64, String> {
    let factor: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    gamebots_server::check_real_time_factor(factor)
}

/// Reads a drive model of the command line. That of the textbook is for experiments, which compare with it.
pub(crate) fn drive_model(name: &str) -> Result<DriveModel, String> {
    match name.parse()? {
        DriveModel::KinematicTextbook => {
            Err(format!("`{name}` is for experiments: expected articulated, bodies, analytic or kinematic"))
        }
        model => Ok(model),
    }
}
