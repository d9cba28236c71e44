use experiments::real::{Measured, run};
use scene::Tyre;
fn main() {
    let mut args = std::env::args().skip(1);
    let file = args.next().unwrap();
    let numbers: Vec<f64> = args.map(|it| it.parse().unwrap()).collect();
    let mut measured: Measured = toml::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    if let [cx, cy, a, b, s] = numbers[..] {
        measured.robot.tyre = Some(Tyre { stiffness: [cx, cy], patch: [a, b], relaxation: s, friction: [1.0, 1.0] });
    }
    for row in run(&measured).unwrap() {
        println!("{} {:.4} {:.4} {:+.2} %", row.what, row.real, row.ours, (row.ours / row.real - 1.0) * 100.0);
    }
}
