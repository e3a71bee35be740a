//! `lightbox info`: the census of a scene.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use lightbox_core::scene::MaterialDesc;
use lightbox_core::{AccelKind, RenderSettings, Scene};
use serde::Serialize;

use super::{Opened, json_line, open, print_warnings, table};
use crate::args::InfoArgs;

/// The report of `--json`. Lengths are scene units, memory is bytes.
#[derive(Serialize)]
struct Census<'a> {
    scene: Cow<'a, str>,
    objects: usize,
    triangles: usize,
    quads: usize,
    spheres: usize,
    materials: Materials,
    /// Primitives that emit.
    lights: usize,
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
    load_seconds: f64,
    build_seconds: f64,
    warnings: Vec<String>,
}

/// Materials in use, by how they scatter.
#[derive(Default, Serialize)]
struct Materials {
    diffuse: usize,
    blend: usize,
    mirror: usize,
    glass: usize,
    /// Of the above, those that emit.
    emitting: usize,
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
    let opened = open(&args.scene, |_| Ok(()), &|_| ())?;
    print_warnings(&opened.scene);
    let census = census(&opened);
    if args.json {
        json_line(&census)
    } else {
        Ok(text(&census))
    }
}

fn census(opened: &Opened) -> Census<'_> {
    let scene = &*opened.scene;
    let (geometry, primitives) = (scene.geometry(), scene.primitives());
    let slots = slots_in_use(scene);
    // Slots can share a texture; each is held once.
    let textures: BTreeMap<_, _> = slots
        .values()
        .filter_map(|prim| scene.material(*prim).texture.as_ref())
        .map(|texture| (Arc::as_ptr(texture), texture.bytes()))
        .collect();
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
        primitives: size_of_val(&*primitives.triangles)
            + size_of_val(&*primitives.triangle_uvs)
            + size_of_val(&*primitives.quads)
            + size_of_val(&*primitives.spheres)
            + size_of_val(&*primitives.slots),
        accelerator: geometry.accel_bytes(),
        textures: textures.values().sum(),
    };
    Census {
        scene: scene.path().to_string_lossy(),
        objects: scene.objects().len(),
        triangles: primitives.triangles.len(),
        quads: primitives.quads.len(),
        spheres: primitives.spheres.len(),
        materials: count_materials(slots.keys().map(|slot| scene.slot_material(*slot))),
        lights: scene.lights().len(),
        background: scene.background(),
        textures: textures.len(),
        bounds: (!primitives.is_empty()).then(|| [geometry.bounds().min, geometry.bounds().max]),
        camera: scene.desc().camera,
        render: scene.desc().render,
        accel: geometry.accel(),
        tree,
        memory,
        load_seconds: opened.load_seconds,
        build_seconds: opened.build_seconds,
        warnings: scene.warnings().iter().map(ToString::to_string).collect(),
    }
}

/// Material slots that some primitive has, each with such a primitive.
fn slots_in_use(scene: &Scene) -> BTreeMap<u32, u32> {
    let slots = &scene.primitives().slots;
    slots
        .iter()
        .enumerate()
        .map(|(prim, slot)| (*slot, prim as u32))
        .collect()
}

fn count_materials(materials: impl Iterator<Item = MaterialDesc>) -> Materials {
    // Slots can share a material.
    let by_name: BTreeMap<String, MaterialDesc> = materials.map(|m| (m.name.clone(), m)).collect();
    let mut counts = Materials::default();
    for material in by_name.values() {
        let kind = match material {
            MaterialDesc { glass: Some(_), .. } => &mut counts.glass,
            MaterialDesc { mirror, .. } if *mirror >= 1.0 => &mut counts.mirror,
            MaterialDesc { mirror, .. } if *mirror > 0.0 => &mut counts.blend,
            _ => &mut counts.diffuse,
        };
        *kind += 1;
        counts.emitting += usize::from(material.emission != glam::Vec3::ZERO);
    }
    counts
}

/// The census for people.
fn text(census: &Census<'_>) -> String {
    let Materials {
        diffuse,
        blend,
        mirror,
        glass,
        emitting,
    } = census.materials;
    let (camera, render) = (&census.camera, &census.render);
    let Memory {
        primitives,
        accelerator: accelerator_bytes,
        textures,
    } = census.memory;
    let accelerator = match &census.tree {
        None => census.accel.to_string(),
        Some(tree) => format!(
            "{}: {} nodes, {} leaves, {} references, depth {}, {:.1} bytes per primitive, SAH cost {:.1}",
            census.accel,
            tree.nodes,
            tree.leaves,
            tree.references,
            tree.max_depth,
            tree.bytes_per_primitive,
            tree.sah_cost
        ),
    };
    table(&[
        ("scene", census.scene.to_string()),
        ("objects", census.objects.to_string()),
        ("triangles", census.triangles.to_string()),
        ("quads", census.quads.to_string()),
        ("spheres", census.spheres.to_string()),
        (
            "materials",
            format!(
                "{diffuse} diffuse, {blend} blend, {mirror} mirror, {glass} glass; {emitting} emitting"
            ),
        ),
        (
            "lights",
            format!(
                "{} emitting primitives, background {}",
                census.lights, census.background
            ),
        ),
        ("textures", census.textures.to_string()),
        (
            "bounds",
            census
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
        ("load", format!("{:.3} s", census.load_seconds)),
        ("build", format!("{:.3} s", census.build_seconds)),
    ])
}

fn megabytes(bytes: usize) -> String {
    format!("{:.2} MB", bytes as f64 / 1e6)
}
