//! Actuators put on robots.

use nalgebra::{Point3, Vector3};

use crate::{Joint, Link, Part, Pose, RobotDef, Solid, Tool, ToolChanger, Vacuum, Visual, position_and_rotation};

impl RobotDef {
    /// Puts an actuator on a link. The actuator is a robot of its own, whose root becomes a part of the link. `pose` is that of its frame
    /// in the robot frame when every joint is at 0.
    ///
    /// The actuator's joints get the mount's name and a point in front. Its items that have the name of its class get the mount's name;
    /// the others keep theirs.
    pub fn mount(&mut self, actuator: &Self, name: &str, link: usize, pose: &Pose) {
        let before = self.links.len();
        let number = |own: usize| if own == 0 { link } else { before + own - 1 };
        for (own, made) in actuator.links.iter().enumerate() {
            let made = moved_link(made, pose);
            if own == 0 {
                let carrier = &mut self.links[link];
                carrier.parts.extend(made.parts);
                carrier.solids.extend(made.solids);
                carrier.visuals.extend(made.visuals);
                continue;
            }
            let joint = made.joint.map(|joint| Joint {
                parent: number(joint.parent),
                coupling: joint.coupling.map(|it| crate::Coupling { leader: number(it.leader), ..it }),
                ..joint
            });
            self.links.push(Link { name: format!("{name}.{}", made.name), joint, ..made });
        }
        self.assumptions.extend(actuator.assumptions.iter().map(|it| format!("{name}: {it}")));
        let named = |own: &str| if own == actuator.class { name.to_owned() } else { own.to_owned() };
        let numbers = |links: &[usize]| links.iter().map(|&own| number(own)).collect::<Vec<_>>();
        self.actuators.extend(actuator.actuators.iter().map(|it| crate::Actuator {
            name: named(&it.name),
            links: numbers(&it.links),
            tip: moved_point(it.tip, pose),
        }));
        self.grippers.extend(actuator.grippers.iter().map(|it| crate::Gripper {
            name: named(&it.name),
            links: numbers(&it.links),
            ..it.clone()
        }));
        self.tool_changers.extend(actuator.tool_changers.iter().map(|it| {
            let (position, direction) = position_and_rotation(&(pose * it.pose()));
            let tool: Option<Tool> = it.tool.clone();
            ToolChanger { name: named(&it.name), link: number(it.link), position, direction, tool, ..*it }
        }));
        self.vacuums.extend(actuator.vacuums.iter().map(|it| {
            let (position, direction) = position_and_rotation(&(pose * it.pose()));
            Vacuum { name: named(&it.name), link: number(it.link), position, direction, ..it.clone() }
        }));
        self.sensors.extend(actuator.sensors.iter().map(|it| {
            let (position, direction) = position_and_rotation(&(pose * crate::pose(it.position, it.direction)));
            crate::SensorDef { link: number(it.link), position, direction, ..it.clone() }
        }));
    }
}

/// Returns a link whose frame of reference is moved.
fn moved_link(link: &Link, pose: &Pose) -> Link {
    let turn = pose.rotation.to_rotation_matrix();
    let joint = link.joint.as_ref().map(|joint| Joint {
        anchor: moved_point(joint.anchor, pose),
        axis: (pose.rotation * Vector3::from(joint.axis)).into(),
        ..joint.clone()
    });
    let part = |part: &Part| Part {
        name: part.name.clone(),
        mass: part.mass,
        centre: (pose * Point3::from(part.centre)).coords,
        inertia: turn.matrix() * part.inertia * turn.matrix().transpose(),
    };
    let solid = |solid: &Solid| {
        let (position, rotation) = position_and_rotation(&(pose * solid.pose()));
        Solid { position, rotation, ..solid.clone() }
    };
    let visual = |visual: &Visual| {
        let (position, rotation) = position_and_rotation(&(pose * crate::pose(visual.position, visual.rotation)));
        Visual { position, rotation, ..visual.clone() }
    };
    Link {
        name: link.name.clone(),
        joint,
        parts: link.parts.iter().map(part).collect(),
        solids: link.solids.iter().map(solid).collect(),
        wheel: link.wheel.clone(),
        visuals: link.visuals.iter().map(visual).collect(),
    }
}

fn moved_point(point: [f64; 3], pose: &Pose) -> [f64; 3] {
    (pose * Point3::from(point)).coords.into()
}
