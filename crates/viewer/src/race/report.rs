//! What a race leaves: the table for people, race.json, chart.csv, chart.svg and a map of each
//! comparison.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use glam::Vec3;
use lightbox_core::agreement::Agreement;
use lightbox_core::color::ToneMap;
use lightbox_core::settings::UNLIMITED;
use lightbox_core::{Image, image_io};
use serde_json::{Value, json};

use super::{Race, chart};

/// Differences beyond this many standard deviations have full colour on a map.
const FULL_COLOR: f64 = 5.0;

/// Writes all files of a race; returns its table. The error is one line.
pub fn write(race: &Race, folder: &Path) -> Result<String, String> {
    let put = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::write(&path, text).map_err(|e| cannot_write(&path, &e))
    };
    put("chart.csv", &csv(race))?;
    let json = serde_json::to_string_pretty(&json(race));
    put(
        "race.json",
        &(json.map_err(|e| format!("race.json cannot be made ({e})"))? + "\n"),
    )?;
    put("chart.svg", &chart::svg(race)?)?;
    for (i, j, agreement) in &race.agreements {
        let path = folder.join(map_name(race, *i, *j));
        let text = agreement.headline(&race.labels[*i], &race.labels[*j]);
        image_io::write(
            &path,
            &map(agreement, [race.settings.width, race.settings.height]),
            ToneMap::default(),
            &text,
        )?;
    }
    Ok(table(race, folder))
}

fn map_name(race: &Race, i: usize, j: usize) -> String {
    let name = |k: usize| race.labels[k].replace([' ', ':'], "-");
    format!("agreement-{}-{}.png", name(i), name(j))
}

/// The colour of a tile whose means differ by `t` standard deviations: red where the first of two
/// methods is brighter than noise explains, blue where darker, white where they agree.
pub fn color(t: f64) -> Vec3 {
    let share = (t / FULL_COLOR).clamp(-1.0, 1.0) as f32;
    let fade = 1.0 - share.abs();
    if share > 0.0 {
        Vec3::new(1.0, fade, fade)
    } else {
        Vec3::new(fade, fade, 1.0)
    }
}

/// A picture of how two methods differ.
fn map(agreement: &Agreement, [width, height]: [u32; 2]) -> Image {
    let mut pixels = vec![Vec3::ONE; width as usize * height as usize];
    for tile in &agreement.tiles {
        for y in tile.rect.y..tile.rect.y + tile.rect.height {
            let start = (y * width + tile.rect.x) as usize;
            pixels[start..start + tile.rect.width as usize].fill(color(tile.t));
        }
    }
    Image {
        width,
        height,
        pixels,
    }
}

fn csv(race: &Race) -> String {
    let mut text = String::from("contestant,seed,seconds,samples,rays,relMSE\n");
    for (label, record) in race.labels.iter().zip(&race.records) {
        for run in &record.runs {
            for p in &run.points {
                // Writing to a string cannot fail.
                let _ = writeln!(
                    text,
                    "{label},{},{:.6},{},{},{:e}",
                    run.seed, p.seconds, p.samples, p.rays, p.rel_mse
                );
            }
        }
    }
    text
}

fn json(race: &Race) -> Value {
    let settings = &race.settings;
    let contestants: Vec<Value> = (0..race.entries.len())
        .map(|i| {
            let [method, accel, sampler, filter] = race.entries[i].words();
            let curve = &race.curves[i];
            json!({
                "label": race.labels[i], "method": method, "accel": accel, "sampler": sampler, "filter": filter,
                "efficiency": curve.efficiency, "slope": curve.slope,
                "curve": {"columns": ["seconds", "relMSE", "least", "most"], "points": curve.points, "front": curve.front},
                "runs": race.records[i].runs,
            })
        })
        .collect();
    let agreements: Vec<Value> = race
        .agreements
        .iter()
        .map(|(i, j, agreement)| {
            let (a, b) = (&race.labels[*i], &race.labels[*j]);
            json!({
                "a": a, "b": b, "p": agreement.p, "agree": agreement.holds(),
                "headline": agreement.headline(a, b), "map": map_name(race, *i, *j),
            })
        })
        .collect();
    let references: Vec<Value> = race
        .references
        .iter()
        .map(|r| {
            json!({
                "filter": r.filter.to_string(), "origin": r.origin,
                "relMSE": r.error.map(|e| e.rel_mse), "band": r.error.map(|e| [e.low, e.high]),
            })
        })
        .collect();
    let depth: Value = if settings.depth == UNLIMITED {
        "unlimited".into()
    } else {
        settings.depth.into()
    };
    json!({
        "scene": race.scene.path().to_string_lossy(),
        "version": env!("CARGO_PKG_VERSION"),
        // Whoever builds knows it.
        "commit": option_env!("LIGHTBOX_COMMIT"),
        "machine": {"cpu": cpu(), "os": std::env::consts::OS, "arch": std::env::consts::ARCH, "threads": rayon::current_num_threads()},
        "width": settings.width, "height": settings.height, "depth": depth,
        "seconds": race.rules.seconds, "seeds": race.rules.seeds, "interrupted": race.interrupted,
        "references": references, "contestants": contestants, "agreement": agreements,
    })
}

/// Makes a folder and checks that files can be written there.
pub fn check_folder(folder: &Path) -> Result<(), String> {
    if folder.is_file() {
        return Err(format!("{}: is a file; choose a folder", folder.display()));
    }
    fs::create_dir_all(folder).map_err(|e| cannot_write(folder, &e))?;
    image_io::check_writable(&folder.join("map.png"))
}

fn cannot_write(path: &Path, e: &std::io::Error) -> String {
    format!(
        "{}: cannot be written ({e}); choose a folder that you may write to",
        path.display()
    )
}

/// The processor's name, where the system tells it in a file.
fn cpu() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn table(race: &Race, folder: &Path) -> String {
    let settings = &race.settings;
    let mut text = format!(
        "{} {}x{}, {} s each, {} seed{}{}: {}\n",
        race.scene.path().display(),
        settings.width,
        settings.height,
        race.rules.seconds,
        race.rules.seeds,
        if race.rules.seeds == 1 { "" } else { "s" },
        if race.interrupted {
            ", interrupted"
        } else {
            ""
        },
        folder.join("chart.svg").display(),
    );
    let width = race
        .labels
        .iter()
        .map(String::len)
        .max()
        .unwrap_or(0)
        .max("contestant".len());
    let _ = writeln!(
        text,
        "{:width$}  {:>9}  {:>9}  {:>10}  slope",
        "contestant", "relMSE", "spp", "efficiency"
    );
    for (i, label) in race.labels.iter().enumerate() {
        let curve = &race.curves[i];
        let Some(end) = curve.points.last() else {
            let _ = writeln!(text, "{label:width$}  nothing measured");
            continue;
        };
        let ends = race.records[i]
            .runs
            .iter()
            .filter_map(|run| run.points.last());
        let samples: Vec<u64> = ends.map(|p| p.samples).collect();
        let spp = samples.iter().sum::<u64>() / samples.len().max(1) as u64;
        let slope = curve.slope.map_or_else(
            || "-".to_owned(),
            |s| {
                let trouble = if s.trouble {
                    "  trouble: error does not fall as it should"
                } else {
                    ""
                };
                format!("{s}{trouble}")
            },
        );
        let _ = writeln!(
            text,
            "{label:width$}  {:>9.2e}  {spp:>9}  {:>10.3e}  {slope}",
            end[1], curve.efficiency
        );
    }
    for (i, j, agreement) in &race.agreements {
        text += &agreement.headline(&race.labels[*i], &race.labels[*j]);
        text.push('\n');
    }
    let worst = race
        .references
        .iter()
        .filter_map(|r| r.error)
        .map(|e| e.rel_mse);
    let best = race
        .curves
        .iter()
        .filter_map(|c| c.points.last())
        .map(|p| p[1]);
    let (worst, best) = (
        worst.fold(0.0, f64::max),
        best.fold(f64::INFINITY, f64::min),
    );
    if worst > 0.2 * best {
        let _ = writeln!(
            text,
            "the reference itself has a relMSE of {worst:.1e}: it flattens the ends of the curves; race longer, or give --reference"
        );
    }
    text
}
