//! Evidence at a scale that no ordinary test has time for: the figures of docs/stability.md.
//!
//! `cargo run --release -p lightbox-tests --example evidence -- WHAT [COUNT] [planted]`, with WHAT
//! one of the commands below. `planted` puts in the defect that the command is meant to see, to
//! show that it would.

mod accelerators;
mod leaks;
mod meshes;
mod methods;
mod self_hits;

use std::process::ExitCode;

use lightbox_core::lab::random::Rng;
use lightbox_core::planted::{Bug, plant};
use rayon::prelude::*;

/// A command: its name, what it counts, its usual count, the defect it is meant to see, and what
/// it does; true if all is well.
type Command = (
    &'static str,
    &'static str,
    u64,
    Option<Bug>,
    fn(u64, bool) -> bool,
);

const COMMANDS: [Command; 4] = [
    (
        "leaks",
        "rays",
        100_000_000,
        Some(Bug::StrictEdges),
        leaks::run,
    ),
    ("self-hits", "rays", 100_000_000, None, self_hits::run),
    ("accelerators", "rays", 10_000_000, None, accelerators::run),
    (
        "methods",
        "scenes",
        100,
        Some(Bug::ReusedUnseen),
        methods::run,
    ),
];

/// Rays of one seed: what a thread takes at a time.
const CHUNK: u64 = 20_000;

/// The sum of `f` over `count` rays, by chunks of at most [`CHUNK`] with a generator each.
fn sum<const N: usize>(count: u64, f: impl Fn(&mut Rng, u64) -> [u64; N] + Sync) -> [u64; N] {
    (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|i| f(&mut Rng::new(i), CHUNK.min(count - i * CHUNK)))
        .reduce(
            || [0; N],
            |a, b| std::array::from_fn(|i| a[i].wrapping_add(b[i])),
        )
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (name, count, is_planted) = match words[..] {
        [name] => (name, None, false),
        [name, "planted"] => (name, None, true),
        [name, count] => (name, Some(count), false),
        [name, count, "planted"] => (name, Some(count), true),
        _ => ("", None, false),
    };
    let command = COMMANDS.iter().find(|c| c.0 == name);
    let count = count.map_or(Some(command.map_or(0, |c| c.2)), |c| c.parse().ok());
    let (Some((_, unit, _, bug, run)), Some(count)) = (command, count) else {
        eprintln!("usage: evidence leaks|self-hits|accelerators|methods [COUNT] [planted]");
        return ExitCode::from(2);
    };
    println!(
        "{name}, {count} {unit}{}",
        if is_planted {
            ", with a planted defect"
        } else {
            ""
        }
    );
    if is_planted {
        plant(*bug);
    }
    if run(count, is_planted) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
