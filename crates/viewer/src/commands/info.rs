//! `lightbox info`: the census of a scene.

use std::borrow::Cow;
use std::sync::atomic::AtomicBool;

use lightbox_core::light::LightKinds;
use lightbox_core::plan::Part;
use lightbox_core::scene::MaterialKinds;
use lightbox_core::{AccelKind, RenderSettings, View};
use serde::Serialize;

use super::{Opened, json_line, open, print_warnings, table};
use crate::args::InfoArgs;
use crate::savings::{Savings, Trial};

/// The report of `--json`. Lengths are scene units, memory is bytes.
#[derive(Serialize)]
struct Report<'a> {
    scene: Cow<'a, str>,
    objects: usize,
    triangles: usize,
    quads: usize,
    spheres: usize,
    materials: MaterialKinds,
    /// Primitives that emit.
    lights: usize,
    light_kinds: LightKinds,
    background: glam::Vec3,
    textures: usize,
    /// None: there is nothing to bound.
    bounds: Option<[glam::Vec3; 2]>,
    camera: lightbox_core::scene::CameraDesc,
    render: RenderSettings,
    /// What was built; never `auto`.
    accel: AccelKind,
    /// None: every ray tests every primitive.
    tree: Option<Tree>,
    memory: Memory,
    plan: Plan,
    load_seconds: f64,
    build_seconds: f64,
    warnings: Vec<String>,
}

/// What a render with these settings goes without.
#[derive(Serialize)]
struct Plan {
    left_out: Vec<Part>,
    /// What that saves; none if nothing is left out.
    savings: Option<Savings>,
}

#[derive(Serialize)]
struct Tree {
    nodes: usize,
    leaves: usize,
    references: usize,
    max_depth: usize,
    bytes: usize,
    bytes_per_primitive: f64,
    sah_cost: f64,
}

#[derive(Serialize)]
struct Memory {
    primitives: usize,
    accelerator: usize,
    textures: usize,
}

/// Counts what is in a scene; returns the report. The error is one line.
pub fn run(args: &InfoArgs) -> Result<String, String> {
    let opened = open(&args.scene, |_| Ok(()), &lightbox_core::scene::unwatched)?;
    print_warnings(&opened.scene);
    let report = report(&opened)?;
    if args.json {
        json_line(&report)
    } else {
        Ok(text(&report))
    }
}

fn report(opened: &Opened) -> Result<Report<'_>, String> {
    let scene = &*opened.scene;
    let (geometry, primitives, census) = (scene.geometry(), scene.primitives(), scene.census());
    let tree = geometry.tree_stats().map(|stats| Tree {
        nodes: stats.nodes,
        leaves: stats.leaves,
        references: stats.references,
        max_depth: stats.max_depth,
        bytes: stats.bytes,
        bytes_per_primitive: stats.bytes as f64 / primitives.len().max(1) as f64,
        sah_cost: stats.sah_cost,
    });
    let memory = Memory {
        primitives: primitives.bytes(),
        accelerator: geometry.accel_bytes(),
        textures: census.texture_bytes,
    };
    Ok(Report {
        scene: scene.path().to_string_lossy(),
        objects: scene.objects().len(),
        triangles: primitives.triangles.len(),
        quads: primitives.quads.len(),
        spheres: primitives.spheres.len(),
        materials: census.materials,
        lights: census.lights.total(),
        light_kinds: census.lights,
        background: scene.background(),
        textures: census.textures,
        bounds: (!primitives.is_empty()).then(|| [geometry.bounds().min, geometry.bounds().max]),
        camera: scene.desc().camera,
        render: scene.desc().render,
        accel: geometry.accel(),
        tree,
        memory,
        plan: plan(opened)?,
        load_seconds: opened.load_seconds,
        build_seconds: opened.build_seconds,
        warnings: scene.warnings().iter().map(ToString::to_string).collect(),
    })
}

/// The plan, and what it saves, measured.
fn plan(opened: &Opened) -> Result<Plan, String> {
    let view = View::of(opened.scene.clone())?;
    let mut trial = Trial::new(&view, &opened.scene.desc().camera)?;
    let never = AtomicBool::new(false);
    let savings = trial.as_mut().map(|trial| {
        loop {
            trial.round(&never);
            if let Some(savings) = trial.savings() {
                break savings;
            }
        }
    });
    Ok(Plan {
        left_out: view.plan().left_out().collect(),
        savings,
    })
}

/// The census for people.
fn text(report: &Report<'_>) -> String {
    let MaterialKinds {
        diffuse,
        blend,
        mirror,
        glass,
        emitting,
    } = report.materials;
    let (camera, render) = (&report.camera, &report.render);
    let Memory {
        primitives,
        accelerator: accelerator_bytes,
        textures,
    } = report.memory;
    let accelerator = match &report.tree {
        None => report.accel.to_string(),
        Some(tree) => format!(
            "{}: {} nodes, {} leaves, {} references, depth {}, {:.1} bytes per primitive, SAH cost {:.1}",
            report.accel,
            tree.nodes,
            tree.leaves,
            tree.references,
            tree.max_depth,
            tree.bytes_per_primitive,
            tree.sah_cost
        ),
    };
    table(&[
        ("scene", report.scene.to_string()),
        ("objects", report.objects.to_string()),
        ("triangles", report.triangles.to_string()),
        ("quads", report.quads.to_string()),
        ("spheres", report.spheres.to_string()),
        (
            "materials",
            format!(
                "{diffuse} diffuse, {blend} blend, {mirror} mirror, {glass} glass; {emitting} emitting"
            ),
        ),
        (
            "lights",
            format!(
                "{} emitting primitives{}, background {}",
                report.lights,
                light_kinds(&report.light_kinds),
                report.background
            ),
        ),
        ("textures", report.textures.to_string()),
        (
            "bounds",
            report
                .bounds
                .map_or("none".into(), |[min, max]| format!("{min} to {max}")),
        ),
        (
            "camera",
            format!(
                "from {} to {}, up {}, fov {}°",
                camera.eye, camera.target, camera.up, camera.fov
            ),
        ),
        (
            "picture",
            format!(
                "{}x{}, {} spp, {}, filter {}",
                render.width, render.height, render.samples, render.method, render.filter
            ),
        ),
        ("accelerator", accelerator),
        (
            "memory",
            format!(
                "{} primitives, {} accelerator, {} textures",
                megabytes(primitives),
                megabytes(accelerator_bytes),
                megabytes(textures)
            ),
        ),
        ("plan", plan_text(&report.plan)),
        ("saves", savings_text(&report.plan)),
        ("load", format!("{:.3} s", report.load_seconds)),
        ("build", format!("{:.3} s", report.build_seconds)),
    ])
}

/// How lights are sampled, in parentheses.
fn light_kinds(kinds: &LightKinds) -> String {
    let all = [
        (kinds.rectangles, "rectangles"),
        (kinds.parallelograms, "parallelograms"),
        (kinds.triangles, "triangles"),
        (kinds.spheres, "spheres"),
    ];
    let some = all.iter().filter(|(n, _)| *n > 0);
    let words: Vec<String> = some.map(|(n, kind)| format!("{n} {kind}")).collect();
    match &*words {
        [] => String::new(),
        words => format!(" ({})", words.join(", ")),
    }
}

fn plan_text(plan: &Plan) -> String {
    let names: Vec<&str> = plan.left_out.iter().map(|part| part.name()).collect();
    match &*names {
        [] => "everything is needed".into(),
        names => format!("without {}", names.join("; ")),
    }
}

fn savings_text(plan: &Plan) -> String {
    let Some(savings) = &plan.savings else {
        return "nothing".into();
    };
    let parts = savings.parts.iter();
    let parts = parts.map(|(part, saving)| format!("{} {}", part.name(), saving.text()));
    let parts: Vec<String> = parts.collect();
    format!("{}: {}", savings.text(), parts.join("; "))
}

fn megabytes(bytes: usize) -> String {
    format!("{:.2} MB", bytes as f64 / 1e6)
}
