//! Instructions of a run: `model = auto` compared with `full` and `local`, on random scenes, counted by callgrind.
//!
//! `cargo run --profile bench -p standfast-benches --bin instructions [-- SCENES]` starts itself under valgrind, reads the
//! counts of every single run, and prints their ratios.

use std::hint::black_box;
use std::process::Command;

use random::Random;
use standfast::{
    Contact, Impact, Model, Options, Outcome, Posture, PostureFields, State, Stop, Trajectory,
    simulate,
};

#[path = "../crates/core/src/math/random.rs"]
mod random;

/// Default number of scenes.
const SCENES: usize = 600;
/// Instructions of a full run above which calls and allocations do not dominate.
const LONG: f64 = 5e4;
/// The models of each scene, in the order in which they are run.
const MODELS: [Model; 3] = [Model::Auto, Model::Full, Model::Local];

impl Random {
    fn power_of_ten(&mut self, low: f64, high: f64) -> f64 {
        10_f64.powf(self.between(low, high))
    }

    fn chance(&mut self, share: f64) -> bool {
        self.next() < share
    }
}

/// One to three contacts on level or sloping ground, thrown from a small height: gaps over five decades, speeds of the
/// same scale, tolerances from 1e-2 to 1e-12.
fn scene(number: usize) -> (Posture, State, Options) {
    let mut random = Random(number as u64 * 1_000_003);
    let r = &mut random;
    loop {
        let count = if r.chance(0.8) {
            2
        } else if r.chance(0.5) {
            1
        } else {
            3
        };
        let level = r.chance(0.5);
        let smooth = r.chance(0.5);
        let feet: &[f64] = match count {
            1 => &[0.0],
            2 => &[-0.5, 0.5],
            _ => &[-0.5, 0.1, 0.5],
        };
        let contacts = feet
            .iter()
            .map(|&x| {
                let slope = if level { 0.0 } else { r.between(-0.4, 0.4) };
                let friction = if smooth { 0.0 } else { r.between(0.0, 1.0) };
                let x = x + r.between(-0.05, 0.05);
                let y = if level { 0.0 } else { r.between(-0.2, 0.2) };
                Contact { friction, ..Contact::at(x, y) }.on_slope(slope)
            })
            .collect();
        let low = r.chance(0.3);
        let fields = PostureFields {
            mass: 1.0,
            gyration_radius: r.between(0.1, 0.7),
            center_of_mass: [r.between(-0.2, 0.2), if low { 0.0 } else { r.between(0.0, 0.6) }],
            contacts,
            restitution: r.between(0.0, 0.9),
            gravity: 9.81,
            ..PostureFields::default()
        };
        let Ok(posture) = Posture::new(fields) else { continue };
        let height = r.power_of_ten(-7.0, -1.0);
        let tolerance = r.power_of_ten(-12.0, -2.0);
        let speed = (2.0 * 9.81 * height).sqrt();
        let q = [r.between(-1.0, 1.0) * height, height * 1.5, r.between(-1.0, 1.0) * height];
        let moving = if r.chance(0.5) { speed } else { 0.0 };
        let qdot = [0, 1, 2].map(|_| r.between(-1.0, 1.0) * moving);
        let stop = if r.chance(0.5) { Stop::Zeno } else { Stop::Rest };
        let options = Options {
            impact: Impact::Newton,
            tolerance,
            stop,
            record: r.chance(0.5),
            event_limit: 20_000,
            ..Options::default()
        };
        let state = State::new(q, qdot);
        let gaps = posture.gaps(&state.q);
        // Only scenes that both models can run: above the ground in either, and finished by the full one.
        if gaps.iter().any(|gap| *gap < 0.0) {
            continue;
        }
        let local = Options { model: Model::Local, ..options };
        if simulate(&posture, &state, &local).is_err() {
            continue;
        }
        let full = simulate(&posture, &state, &Options { model: Model::Full, ..options });
        let ends = |run: &Trajectory| !matches!(run.outcome(), Outcome::EventLimit);
        if full.is_ok_and(|run| ends(&run)) {
            return (posture, state, options);
        }
    }
}

/// The name of [`counted_run`] in callgrind.
const COUNTED: &str = "instructions::counted_run";

/// The function whose instructions are counted.
#[inline(never)]
fn counted_run(posture: &Posture, state: &State, options: &Options) -> Trajectory {
    let run = simulate(black_box(posture), black_box(state), black_box(options));
    let Ok(run) = run else { panic!("a scene that cannot be run") };
    black_box(run)
}

fn runs(scenes: usize) {
    for number in 0..scenes {
        let (posture, state, options) = scene(number);
        for model in MODELS {
            let options = Options { model, ..options };
            // One run without counting, so that the allocator makes no more system calls.
            drop(black_box(simulate(&posture, &state, &options)));
            let run = counted_run(&posture, &state, &options);
            let (chosen, reason) = (run.model(), run.model_reason());
            let [tolerance, elapsed] = [options.tolerance, run.elapsed()];
            println!(
                "{number}\t{model:?}\t{chosen:?}\t{:?}\t{}\t{elapsed:e}\t{tolerance:e}\t{}\t{reason}",
                run.outcome(),
                run.collisions(),
                posture.contacts().len()
            );
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn report(name: &str, ratios: &[f64]) {
    let most = ratios.iter().copied().fold(0.0, f64::max);
    println!("{name:<34} {:>6} {:>8.3} {most:>8.3}", ratios.len(), median(ratios.to_vec()));
}

/// Instructions of all these scenes with `auto`, relative to `full`.
fn shared(scenes: &[&[(Vec<&str>, f64)]]) -> f64 {
    let total = |model: usize| scenes.iter().map(|scene| scene[model].1).sum::<f64>();
    total(0) / total(1)
}

fn count(scenes: usize) -> std::io::Result<()> {
    let folder =
        std::env::temp_dir().join(format!("standfast-instructions-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let out = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg(format!("--callgrind-out-file={}", folder.join("out").display()))
        .args([format!("--toggle-collect={COUNTED}"), format!("--dump-after={COUNTED}")])
        .arg(std::env::current_exe()?)
        .args(["--run", &scenes.to_string()])
        .output()?;
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let lines = String::from_utf8_lossy(&out.stdout).into_owned();
    let mut rows: Vec<(Vec<&str>, f64)> = Vec::new();
    for (k, line) in lines.lines().enumerate() {
        let dump = std::fs::read_to_string(folder.join(format!("out.{}", k + 1)))?;
        let instructions = dump
            .lines()
            .rev()
            .find_map(|line| line.strip_prefix("summary: ").or(line.strip_prefix("totals: ")))
            .and_then(|number| number.trim().parse().ok())
            .unwrap_or_else(|| panic!("no count in dump {}", k + 1));
        rows.push((line.split('\t').collect(), instructions));
    }
    std::fs::remove_dir_all(&folder)?;
    if let Ok(path) = std::env::var("STANDFAST_INSTRUCTIONS") {
        let table: Vec<String> =
            rows.iter().map(|(row, n)| format!("{n}\t{}", row.join("\t"))).collect();
        std::fs::write(path, table.join("\n"))?;
    }
    let (mut all, mut local, mut full) = (Vec::new(), Vec::new(), Vec::new());
    let (mut long, mut alone) = (Vec::new(), Vec::new());
    for scene in rows.chunks(MODELS.len()) {
        let ratio = scene[0].1 / scene[1].1;
        all.push(ratio);
        if scene[0].0[2] == "Local" {
            local.push(ratio);
            alone.push(scene[2].1 / scene[1].1);
            if scene[1].1 > LONG {
                long.push(ratio);
            }
        } else {
            full.push(ratio);
        }
    }
    println!("instructions(auto) / instructions(full)  scenes   median  largest");
    report("all scenes", &all);
    report("auto chose local", &local);
    report("  where full takes over 50 000", &long);
    report("  local without the check", &alone);
    report("auto chose full", &full);
    println!("\ntolerance from  scenes   local  all: auto/full  where local: auto/full");
    for decade in -12..-2 {
        let within = |scene: &&[(Vec<&str>, f64)]| {
            let tolerance: f64 = scene[0].0[6].parse().unwrap_or(f64::NAN);
            tolerance.log10().floor() == f64::from(decade)
        };
        let scenes: Vec<_> = rows.chunks(MODELS.len()).filter(within).collect();
        let local: Vec<_> =
            scenes.iter().copied().filter(|scene| scene[0].0[2] == "Local").collect();
        let (all, part) = (shared(&scenes), shared(&local));
        println!("1e{decade:<12} {:>8} {:>7} {all:>15.3} {part:>23.3}", scenes.len(), local.len());
    }
    let scenes: Vec<_> = rows.chunks(MODELS.len()).collect();
    println!("all together   {:>8} {:>23.4}", scenes.len(), shared(&scenes));
    Ok(())
}

fn main() -> std::io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |text: Option<&String>| text.and_then(|t| t.parse().ok()).unwrap_or(SCENES);
    if arguments.first().is_some_and(|first| first == "--run") {
        runs(number(arguments.get(1)));
        return Ok(());
    }
    count(number(arguments.first()))
}
