//! What robots do does not depend on how many threads move them.

use std::sync::Arc;

use gamebots_proto::Dialect;
use scene::{Material, Object, Shape, Solid};
use sim_core::{Options, World};
use system_tests::{apply, init};
use thread_pool::ThreadPool;

/// On the arena: alone, side by side, in heaps, in the air, moved by the engine, and against crates.
const ROBOTS: [(&str, &str, &str); 14] = [
    ("P3AT", "-3,-3,-0.2", "DRIVE {Left 2}{Right -1}"),
    ("P3AT", "-3,-1,-0.2", "DRIVE {Left 1}{Right 2}"),
    ("P3AT", "-3,-1,-0.6", "DRIVE {Left 2}{Right 2}"),
    ("Kenaf", "-3,1,-0.3", "DRIVE {Left 2}{Right 2}"),
    ("Kenaf", "-3,1.1,-0.8", "DRIVE {Left -2}{Right 2}"),
    ("YouBot", "0,0,-0.2", "DRIVE {Left 3}{Right 3}"),
    ("YouBot", "0,1,-0.2", "DRIVE {Front-Left 3}{Front-Right -3}{Back-Left -3}{Back-Right 3}"),
    ("KUKA_YouBot", "0,-1,-0.2", "DRIVE {Left 3}{Right 3}"),
    ("P3AT", "0.8,-1,-0.2", "DRIVE {Left 0}{Right 0}"),
    ("AirRobot", "-1,-3,-1", "DRIVE {LinearVelocity 0.5} {AltitudeVelocity -0.3}"),
    ("P2AT", "2,-2,-0.2", "DRIVE {Left 2}{Right 2}"),
    ("P2AT", "2,0,-0.2", "DRIVE {Left 2}{Right 2}"),
    ("P2AT", "2,2,-0.2", "DRIVE {Left 2}{Right 2}"),
    ("BasicSkidRobot", "-1,3,-0.2", "DRIVE {Left 2}{Right 1}"),
];

fn world() -> World {
    let mut def = scene_loader::load("arena", &[]).expect("a map");
    for (number, x) in [0.5, 1.0, 2.6].into_iter().enumerate() {
        let (name, shape) = (format!("crate {number}"), Shape::Box { size: [0.2; 3] });
        let solid = Solid { name, shape, position: [x, 0.0, -0.1], rotation: [0.0; 3], material: Material::default() };
        def.map.objects.push(Object { solid, mass: 1.0 });
    }
    World::new(def, Options { seed: 7, ..Options::default() })
}

/// Digest after every tenth of a second, and every line.
fn play(threads: &ThreadPool) -> (Vec<u64>, Vec<String>) {
    let mut world = world().on_threads(Arc::new(threads.clone()));
    for (class, place, line) in ROBOTS {
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location {place}}}"));
        apply(&mut world, robot, line);
    }
    let (mut digests, mut lines) = (Vec::new(), Vec::new());
    for step in 0..1000 {
        let messages = world.step();
        lines.extend(messages.into_iter().map(|(id, message)| format!("{id:?} {}", message.write(Dialect::Udk))));
        if step % 50 == 0 {
            digests.push(world.digest());
        }
    }
    (digests, lines)
}

#[test]
fn any_number_of_threads_gives_the_same_bits_and_lines() {
    let one = play(&ThreadPool::one());
    assert!(one.1.iter().any(|line| line.contains("RangeScanner")), "no laser measures");
    for threads in [2, 8] {
        let pool = ThreadPool::new(threads).expect("threads");
        assert_eq!(pool.threads(), threads);
        for (how, many) in [("from outside", play(&pool)), ("inside", pool.run(|| play(&pool)))] {
            assert_eq!(many.0, one.0, "{threads} threads, {how}");
            assert!(many.1 == one.1, "{threads} threads, {how}: lines differ");
        }
    }
    let pool = ThreadPool::new(3).expect("threads");
    assert_eq!(pool.run_in_a_hurry(|| play(&pool)).0, one.0, "in a hurry");
}

/// Whoever steps a world learns of a panic, and nobody waits for ever.
#[test]
fn a_panic_on_a_thread_ends_what_it_was_part_of() {
    let pool = ThreadPool::new(2).expect("threads");
    for how in [ThreadPool::run::<()>, ThreadPool::run_in_a_hurry::<()>] as [fn(&ThreadPool, fn()); 2] {
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| how(&pool, || panic!("as asked"))));
        assert!(result.is_err());
    }
}
