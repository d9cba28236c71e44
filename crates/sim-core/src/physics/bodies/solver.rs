//! Parameters of the engine's solver, and the sweeps in which robots land.

use rapier3d::prelude::*;

/// Sweeps of the solver over the contacts while a robot lands. One is enough where the last step's impulses are a good
/// guess. In an impact it gives the whole momentum to the wheel that comes first, and friction takes hold of what
/// follows from that: a robot that falls flat from 1 m then turns by up to 0.1 rad.
const LANDING_SWEEPS: usize = 20;
/// Length of a landing after the fall, s: until the overlap of the impact is pushed out.
const LANDING_TIME: f64 = 0.1;

/// Sets the parameters that do not change.
pub(in super::super) fn set_parameters(parameters: &mut IntegrationParameters, time_step: f64) {
    parameters.dt = time_step;
    // One iteration with friction solved together with the penetration is what makes free rollers roll
    // right; without it four iterations are slower and worse. Recycled contacts lag behind a turning roller.
    parameters.num_solver_iterations = 1;
    parameters.friction_in_bias_pass = true;
    parameters.friction_model = FrictionModel::Coulomb;
    parameters.contact_recycling = false;
    // Contacts that are about to happen, from here on: more of them only cost time, a robot moves 2 mm in a step
    // at 1 m/s.
    parameters.normalized_prediction_distance = 0.002;
}

/// The time left of the landing of a robot, s; `LANDING_TIME` while one falls.
#[derive(Default)]
pub(in super::super) struct Landing(f64);

impl Landing {
    /// Expects a robot that falls to land.
    pub(super) fn expect(&mut self) {
        self.0 = LANDING_TIME;
    }

    /// Sets the sweeps of the coming step.
    pub(in super::super) fn set_sweeps(&mut self, parameters: &mut IntegrationParameters) {
        let sweeps = if self.0 > 0.0 { LANDING_SWEEPS } else { 1 };
        // With the velocity that pushes out overlaps, and without it.
        parameters.num_internal_pgs_iterations = sweeps;
        parameters.num_internal_stabilization_iterations = sweeps;
        self.0 -= parameters.dt;
    }
}
