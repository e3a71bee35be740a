//! Cost as work grows: time and memory of whole renders against resolution, samples, triangles and
//! threads, a model of them, and what it foretells of sizes that it has not seen, for docs/growth.md.
//!
//! `cargo build --release && cargo run --release -p lightbox-tests --example growth [ROUNDS]`
//!
//! Adds so many rounds (default 5) to docs/growth/measured.csv, of which the least run of each size
//! counts, and draws the charts beside it. Needs GNU time.

mod charts;
mod measure;
mod model;
mod sizes;

use std::path::Path;

use charts::Panel;
use measure::{Cost, Runs};
use model::{Memory, Model, Sum};
use sizes::Size;

/// One of the numbers of a cost.
type Number = fn(&Cost) -> f64;

fn main() -> Result<(), String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/growth");
    std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
    let csv = folder.join("measured.csv");
    let rounds: u32 = match std::env::args().nth(1) {
        Some(text) => text.parse().map_err(|_| "use a number of rounds")?,
        None => 5,
    };
    let known = known();
    let program = measure::program()?;
    // In turns, so that a busy minute of the machine does not fall on one size alone.
    for round in 1..=rounds {
        for size in known.iter().chain(&sizes::unseen()) {
            let cost = measure::run(&program, size)?;
            measure::keep(&csv, size, &cost)?;
        }
        eprintln!("round {round} of {rounds}");
    }

    let measured = |sizes: &[Size]| -> Result<Runs, String> {
        let runs = sizes.iter().map(|size| match measure::least(&csv, size)? {
            Some(cost) => Ok((*size, cost)),
            None => Err(format!("{size}: was not measured; ask for a round")),
        });
        runs.collect()
    };
    let (known, unseen) = (measured(&known)?, measured(&sizes::unseen())?);
    let model = Model::fit(&known);
    println!("Seconds on the clock:\n\n{}", formula(&model.wall));
    println!("Seconds of the processors:\n\n{}", formula(&model.cpu));
    println!("Memory:\n\n{}", memory(&model.memory));
    println!("Fitted to:\n\n{}", table(&model, &known));
    println!("Foretold:\n\n{}", table(&model, &unseen));

    charts::growth(&folder.join("growth.svg"), &panels(&model, &csv)?)?;
    let pairs = |cost: Number| {
        let pair = |(size, c): &(Size, Cost)| [cost(c), cost(&model.of(size))];
        unseen.iter().map(pair).collect()
    };
    let kinds = [
        ("seconds on the clock", pairs(|c| c.wall)),
        ("seconds of the processors", pairs(|c| c.cpu)),
        ("megabytes", pairs(|c| c.memory / 1e6)),
    ];
    charts::unseen(&folder.join("unseen.svg"), &kinds)
}

/// The sizes that the model is fitted to, at each number of threads.
fn known() -> Vec<Size> {
    let sweeps = sizes::sweeps().into_iter().flat_map(|sweep| sweep.sizes);
    let mut known: Vec<Size> = Vec::new();
    for size in sweeps.chain(sizes::corners()) {
        for threads in sizes::THREADS {
            let size = Size { threads, ..size };
            if !known.contains(&size) {
                known.push(size);
            }
        }
    }
    known
}

/// The coefficients of a sum, as a table.
fn formula(sum: &Sum) -> String {
    let mut text = "| for each | |\n|---|---|\n".to_owned();
    for (term, c) in sum.terms.iter().zip(&sum.coefficients) {
        let (unit, scale) = term.unit;
        text += &format!("| {} | {:.3} {unit} |\n", term.name, c * scale);
    }
    text
}

/// The same of memory.
fn memory(memory: &Memory) -> String {
    let Memory {
        program,
        building,
        rendering,
        pixel,
    } = memory;
    format!(
        "| for each | |\n|---|---|\n\
         | program | {:.1} MB |\n\
         | triangle, while building | {building:.0} bytes |\n\
         | triangle, while rendering | {rendering:.0} bytes |\n\
         | pixel, while rendering | {pixel:.0} bytes |\n",
        program / 1e6
    )
}

/// What was measured beside what the model says, and the worst of it.
fn table(model: &Model, runs: &Runs) -> String {
    let mut text = "| picture | samples | triangles | threads | seconds | foretold | processor seconds | foretold | MB | foretold |\n\
                    |---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    let mut worst = [0.0f64; 3];
    for (size, cost) in runs {
        text += &format!("| {size} |");
        let said = model.of(size);
        let pairs = [
            (cost.wall, said.wall),
            (cost.cpu, said.cpu),
            (cost.memory / 1e6, said.memory / 1e6),
        ];
        for ((measured, said), worst) in pairs.into_iter().zip(&mut worst) {
            let error = said / measured - 1.0;
            *worst = worst.max(error.abs());
            let digits = if measured < 100.0 { 2 } else { 0 };
            text += &format!(
                " {measured:.digits$} | {said:.digits$} ({:+.0} %) |",
                100.0 * error
            );
        }
        text += "\n";
    }
    let [wall, cpu, memory] = worst.map(|w| format!("{:.1} %", 100.0 * w));
    text + &format!(
        "\nWorst: {wall} of the seconds, {cpu} of processor seconds, {memory} of memory\n"
    )
}

/// The sweeps, once for time and once for memory.
fn panels(model: &Model, csv: &Path) -> Result<Vec<Panel>, String> {
    let costs: [(&str, Number); 2] = [
        ("seconds", |cost| cost.wall),
        ("megabytes", |cost| cost.memory / 1e6),
    ];
    let mut panels = Vec::new();
    for (y, cost) in costs {
        for sweep in sizes::sweeps() {
            let mut series = [const { Vec::new() }; 2];
            for (points, threads) in series.iter_mut().zip(sizes::THREADS) {
                for size in &sweep.sizes {
                    let size = Size { threads, ..*size };
                    if let Some(measured) = measure::least(csv, &size)? {
                        points.push([(sweep.at)(&size), cost(&measured), cost(&model.of(&size))]);
                    }
                }
            }
            panels.push(Panel {
                x: sweep.name,
                y,
                series,
            });
        }
    }
    Ok(panels)
}
