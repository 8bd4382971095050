//! The fuzz targets on their corpus, on random bytes, and in a campaign on mutations of the corpus: `make mutate`. The
//! mutations are random. They run ten times as fast as the campaigns of `make fuzz`, which are guided by branch
//! coverage.

#[path = "../../../fuzz/inputs.rs"]
#[expect(unreachable_pub, reason = "the library of the fuzz targets")]
mod inputs;

use std::panic::{catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use std::{env, fs, process, thread};

use random::Random;

#[path = "../src/math/random.rs"]
mod random;

type Target = fn(&[u8]);

/// Bytes that select rare or extreme values.
const TELLING: [u8; 12] = [0, 1, 2, 127, 128, 159, 160, 192, 223, 224, 239, 255];
/// Longest input.
const MOST_BYTES: usize = 4096;
/// Time after which an input counts as hanging.
const HANGS: Duration = Duration::from_secs(60);

/// A number from the environment.
fn asked<T: FromStr>(name: &str, otherwise: T) -> T {
    env::var(name).map_or(otherwise, |text| {
        text.parse().unwrap_or_else(|_| panic!("{name} = {text} is no number"))
    })
}

impl Random {
    fn byte(&mut self) -> u8 {
        self.bits().to_le_bytes()[0]
    }

    fn below(&mut self, count: usize) -> usize {
        self.bits() as usize % count
    }

    /// One input, or the beginning of one and the end of another, with some bytes changed.
    fn offspring(&mut self, corpus: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = corpus[self.below(corpus.len())].clone();
        if self.below(3) == 0 {
            let other = &corpus[self.below(corpus.len())];
            bytes.truncate(self.below(bytes.len() + 1));
            bytes.extend_from_slice(&other[self.below(other.len() + 1)..]);
        }
        for _ in 0..=self.below(5) {
            if bytes.is_empty() {
                bytes.push(0);
            }
            let i = self.below(bytes.len());
            match self.below(7) {
                0 => bytes[i] = self.byte(),
                1 => bytes[i] = TELLING[self.below(TELLING.len())],
                2 => bytes[i] ^= 1 << self.below(8),
                3 => bytes[i] = bytes[i].wrapping_add(1),
                4 => bytes[i] = bytes[self.below(bytes.len())],
                5 => bytes.insert(i, self.byte()),
                _ => drop(bytes.remove(i)),
            }
        }
        bytes.truncate(MOST_BYTES);
        bytes
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn files(folder: &Path) -> Vec<Vec<u8>> {
    let all = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = all.flatten().map(|file| file.path()).collect();
    paths.sort();
    let read =
        |path: &PathBuf| fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    paths.iter().map(read).collect()
}

/// The corpus and random bytes: 1000 inputs, or `STANDFAST_FUZZ_INPUTS`.
fn all(name: &str, target: Target) {
    files(&root().join("fuzz/corpus").join(name)).iter().for_each(|input| target(input));
    for seed in 0..asked("STANDFAST_FUZZ_INPUTS", 1000) {
        let mut random = Random(seed);
        let bytes: Vec<u8> =
            (0..12 + seed % 20).flat_map(|_| random.bits().to_le_bytes()).collect();
        target(&bytes);
    }
}

/// Mutations of the corpus and of the inputs that `make fuzz` has found, for `STANDFAST_FUZZ_SECONDS`, with seed
/// `STANDFAST_FUZZ_SEED`. An input that fails or hangs is written to target/fuzz.
fn campaign(name: &str, target: Target) {
    let seed = asked("STANDFAST_FUZZ_SEED", 0);
    let found = root().join("target/fuzz").join(name);
    fs::create_dir_all(&found).unwrap_or_else(|e| panic!("{}: {e}", found.display()));
    let mut corpus = files(&root().join("fuzz/corpus").join(name));
    corpus.extend(files(&found));
    let path = root().join(format!("target/fuzz/{name}-{seed}"));
    let keep = move |input: &[u8], what: &str| {
        fs::write(&path, input).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        println!("{} {what}", path.display());
    };
    let (tell, told) = channel::<Vec<u8>>();
    let watch = keep.clone();
    thread::spawn(move || {
        let mut current = Vec::new();
        loop {
            match told.recv_timeout(HANGS) {
                Ok(input) => current = input,
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {
                    watch(&current, "hangs");
                    process::exit(1);
                }
            }
        }
    });
    let (mut random, mut count, mut slowest) = (Random(seed), 0_u64, Duration::ZERO);
    let (start, time) = (Instant::now(), Duration::from_secs(asked("STANDFAST_FUZZ_SECONDS", 60)));
    while start.elapsed() < time {
        let input = random.offspring(&corpus);
        tell.send(input.clone()).unwrap_or_else(|e| panic!("{e}"));
        let before = Instant::now();
        if let Err(failure) = catch_unwind(|| target(&input)) {
            keep(&input, "fails");
            resume_unwind(failure);
        }
        slowest = slowest.max(before.elapsed());
        count += 1;
    }
    println!("{name}: {count} inputs, 0 findings, slowest {:.2} s", slowest.as_secs_f64());
}

macro_rules! targets {
    ($($name:ident),*) => {$(
        mod $name {
            #[test]
            fn corpus_and_random_bytes() {
                super::all(stringify!($name), super::inputs::$name);
            }

            #[test]
            #[ignore = "a campaign: make mutate"]
            fn mutated() {
                super::campaign(stringify!($name), super::inputs::$name);
            }
        }
    )*};
}

targets!(scene, motion, modes, standing);
