//! What the fuzz targets try, over their corpus and over random bytes: the campaigns themselves are `make fuzz`.

#[path = "../../../fuzz/inputs.rs"]
#[expect(unreachable_pub, reason = "the library of the fuzz targets")]
mod inputs;

use std::fs;
use std::path::Path;

/// Inputs of random bytes for each target; `STANDFAST_FUZZ_INPUTS` asks for more.
fn count() -> u64 {
    let asked = std::env::var("STANDFAST_FUZZ_INPUTS");
    asked.map_or(4000, |n| n.parse().unwrap_or_else(|e| panic!("{n}: {e}")))
}

fn all(name: &str, target: fn(&[u8])) {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(name);
    let files = fs::read_dir(&corpus).unwrap_or_else(|e| panic!("{}: {e}", corpus.display()));
    for file in files {
        let path = file.unwrap_or_else(|e| panic!("{e}")).path();
        target(&fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())));
    }
    for seed in 0..count() {
        // SplitMix64 [Steele, Lea & Flood 2014]
        let mut state = seed;
        let bytes: Vec<u8> = (0..12 + seed % 20)
            .flat_map(|_| {
                state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
                let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                (z ^ (z >> 31)).to_le_bytes()
            })
            .collect();
        target(&bytes);
    }
}

#[test]
fn scenes() {
    all("scene", inputs::scene);
}

#[test]
fn motions() {
    all("motion", inputs::motion);
}

#[test]
fn modes() {
    all("modes", inputs::modes);
}

#[test]
fn standing() {
    all("standing", inputs::standing);
}
