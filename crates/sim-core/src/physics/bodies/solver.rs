//! Parameters of the engine's solver, and extra sweeps for landing robots. One sweep at 500 Hz, with friction solved in the same pass as
//! penetration, is better than four without.

use rapier3d::prelude::*;

/// Sweeps of the solver over the contacts while a robot lands. One sweep is enough if the last step's impulses are a good guess. In an
/// impact, one sweep gives the whole momentum to the first wheel, and friction follows from that. A robot that falls flat from 1 m then
/// turns by up to 0.1 rad.
const LANDING_SWEEPS: usize = 20;
/// Length of a landing after the fall, s. The overlap of the impact is pushed out in it.
const LANDING_TIME: f64 = 0.1;

/// Sets the parameters that never change.
pub(in super::super) fn set_parameters(parameters: &mut IntegrationParameters, time_step: f64) {
    parameters.dt = time_step;
    // One iteration with friction solved together with the penetration makes free rollers roll right. Without it, four iterations are
    // slower and worse. Recycled contacts lag behind a turning roller.
    parameters.num_solver_iterations = 1;
    parameters.friction_in_bias_pass = true;
    parameters.friction_model = FrictionModel::Coulomb;
    parameters.contact_recycling = false;
    // Distance at which contacts begin. More of it only costs time: at 1 m/s a robot moves 2 mm in a step.
    parameters.normalized_prediction_distance = 0.002;
}

/// Time left of a landing, s. It is `LANDING_TIME` while a robot falls.
#[derive(Clone, Default)]
pub(in super::super) struct Landing(f64);

impl Landing {
    /// Expects a falling robot to land.
    pub(super) fn expect(&mut self) {
        self.0 = LANDING_TIME;
    }

    /// Sets the sweeps for the coming step.
    pub(in super::super) fn set_sweeps(&mut self, parameters: &mut IntegrationParameters) {
        let sweeps = if self.0 > 0.0 { LANDING_SWEEPS } else { 1 };
        // The first are sweeps with the velocity that pushes out overlaps, the second without it.
        parameters.num_internal_pgs_iterations = sweeps;
        parameters.num_internal_stabilization_iterations = sweeps;
        self.0 -= parameters.dt;
    }
}
