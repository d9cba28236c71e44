//! Plays fixed worlds and compares their digests with those that every platform must give. Prints them; fails if one differs.
//!
//! `cargo test` plays them on this machine, `tests/golden/run` in WebAssembly.

use std::process::ExitCode;

use gamebots_proto::Command;
use sim_core::{Options, World};

/// Steps of each world.
const STEPS: u32 = 1500;

/// A map, the lines of clients by their names, and the digest at the end.
struct Golden {
    name: &'static str,
    map: &'static str,
    /// Lines in their order, each behind the number of its client.
    lines: &'static [(usize, &'static str)],
    digest: u64,
}

/// Worlds with every kind of robot, object and mechanics.
const WORLDS: [Golden; 5] = [
    Golden {
        name: "youbots",
        map: "arena",
        lines: &[
            (0, "INIT {ClassName USARBot.YouBot} {Location 0,0,-0.3}"),
            (0, "DRIVE {Front-Left 3} {Front-Right -2} {Back-Left -3} {Back-Right 4}"),
            (1, "INIT {ClassName USARBot.YouBotArm} {Location 0,2,-0.3} {Rotation 0,0,0.4}"),
            (1, "DRIVE {LinearVelocity 0.3} {RotationalVelocity 0.5}"),
            (1, "ACT {Name Arm} {Link 1} {Value 0.7} {Link 2} {Value -1.2}"),
        ],
        digest: 0x68d4_6b62_0972_fb2b,
    },
    Golden {
        name: "the engine",
        map: "slope-4.5",
        lines: &[
            (0, "INIT {ClassName USARBot.KUKA_YouBot} {Start PlayerStart_0}"),
            (0, "DRIVE {LinearVelocity 0.2} {LateralVelocity 0.1} {RotationalVelocity 0.3}"),
        ],
        digest: 0xb6e1_8eee_dc35_4e21,
    },
    Golden {
        name: "skid",
        map: "arena",
        lines: &[
            (0, "INIT {ClassName USARBot.P3AT} {Location -3,-3,-0.3} {Rotation 0,0,1}"),
            (0, "DRIVE {Left 4} {Right 1}"),
            (1, "INIT {ClassName USARBot.Kenaf} {Location 2,1,-0.4}"),
            (1, "DRIVE {Left 2} {Right 3}"),
            (1, "MULTIDRIVE {FLFlipper 0.5} {RRFlipper -0.7}"),
        ],
        digest: 0x839e_d5e7_4bb0_9bb4,
    },
    Golden {
        name: "a heap",
        map: "hall",
        lines: &[
            (0, "INIT {ClassName USARBot.P3AT} {Location 0,0,-0.3}"),
            (0, "DRIVE {Left 5} {Right 5}"),
            (1, "INIT {ClassName USARBot.P3AT} {Location 0,0,-0.9} {Rotation 0.1,0.2,0.3}"),
            (2, "INIT {ClassName USARBot.YouBot} {Location 1,0,-0.3} {Rotation 0,0,3}"),
            (2, "DRIVE {LinearVelocity 0.5}"),
            (3, "INIT {ClassName USARBotAPI.WorldController}"),
            (3, "CONTROL {Type Create} {ClassName WCCrate} {Name c} {Location 0.4,0.9,-1} {Physics RigidBody}"),
            (3, "CONTROL {Type Create} {ClassName WCPallet} {Name lift} {Location 0,-1.2,-0.2} {Rotation 0,0,0.3}"),
            (3, "CONTROL {Type Rotate} {Name lift} {Speed 0,0,0.7}"),
        ],
        digest: 0x2fc8_74d8_c533_cad2,
    },
    Golden {
        name: "cars and flight",
        map: "rough",
        lines: &[
            (0, "INIT {ClassName USARBot.FrontAckerman} {Location 0,0,-0.3}"),
            (0, "DRIVE {Speed 3} {FrontSteer 0.3} {RearSteer 0}"),
            (1, "INIT {ClassName USARBot.BasicAckermanRobot} {Location 0,3,-0.3}"),
            (1, "DRIVE {Speed 2} {FrontSteer -0.2} {RearSteer 0}"),
            (2, "INIT {ClassName USARBot.AirRobot} {Location 3,0,-1}"),
            (2, "DRIVE {AltitudeVelocity 0.2} {LinearVelocity 0.5} {RotationalVelocity 30}"),
        ],
        digest: 0x4f49_9a45_705c_95ea,
    },
];

/// Plays a world. Fails with the reason in words.
fn play(golden: &Golden) -> Result<u64, String> {
    let scene = scene_loader::load(golden.map, &[]).map_err(|error| error.to_string())?;
    let mut world = World::new(scene, Options::default());
    let mut pawns = [None; 8];
    for &(client, line) in golden.lines {
        let mut problems = Vec::new();
        let command = Command::parse(line, &mut problems).ok_or(line)?;
        let pawn = pawns.get_mut(client).ok_or("a client too many")?;
        let spawned = world.execute(*pawn, &command, &mut problems).spawned;
        *pawn = spawned.or(*pawn);
        if let Some(problem) = problems.first() {
            return Err(format!("{line}: {problem}"));
        }
    }
    (0..STEPS).for_each(|_| drop(world.step()));
    Ok(world.digest())
}

fn main() -> ExitCode {
    let mut outcome = ExitCode::SUCCESS;
    for golden in &WORLDS {
        match play(golden) {
            Ok(digest) if digest == golden.digest => println!("{}: {digest:016x}", golden.name),
            Ok(digest) => {
                println!("{}: {digest:016x}, expected {:016x}", golden.name, golden.digest);
                outcome = ExitCode::FAILURE;
            }
            Err(reason) => {
                println!("{}: {reason}", golden.name);
                outcome = ExitCode::FAILURE;
            }
        }
    }
    outcome
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_world_has_its_golden_digest() {
        for golden in &WORLDS {
            assert_eq!(
                play(golden).map(|digest| format!("{digest:016x}")),
                Ok(format!("{:016x}", golden.digest)),
                "{}",
                golden.name
            );
        }
    }
}
