//! Files that users bring.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use lightbox_core::scene::{Source, load};
use lightbox_core::{RenderSettings, View};

/// Largest generated mesh that is built here, triangles.
const BOULDER: u32 = 2000;

fn check_line(line: &str) {
    assert!(
        !line.is_empty() && !line.contains(['\n', '\r']),
        "not one line: {line:?}"
    );
}

/// Opens a scene or mesh as the viewer does, and takes a very small picture of it.
fn open(path: &Path) {
    let source = match load(path) {
        Ok(source) => source,
        Err(e) => return check_line(&e.to_string()),
    };
    if source
        .desc
        .meshes
        .iter()
        .any(|m| m.boulder.is_some_and(|n| n > BOULDER))
    {
        return; // Takes long, as it should.
    }
    let scene = match source.build(&lightbox_core::scene::unwatched) {
        Ok(scene) => Arc::new(scene),
        Err(e) => return check_line(&e.to_string()),
    };
    for warning in scene.warnings() {
        check_line(&warning.to_string());
    }
    check_edits(&source, &scene);
    let settings = RenderSettings {
        width: 3,
        height: 2,
        samples: 2,
        depth: scene.desc().render.depth.min(6),
        ..scene.desc().render
    };
    let view =
        View::new(scene.clone(), &scene.desc().camera, settings).unwrap_or_else(|e| panic!("{e}"));
    let film = view.film();
    view.render(&film, settings.samples, &AtomicBool::new(false));
    assert!(film.develop().pixels.iter().all(|p| p.is_finite()));
}

/// What the viewer's panels rely on: the same description needs nothing new, and every object
/// has its primitives and materials.
fn check_edits(source: &Source, scene: &lightbox_core::Scene) {
    assert!(!scene.rebuilds_for(&source.desc));
    assert!(
        scene
            .edit(source.desc.clone(), &lightbox_core::scene::unwatched)
            .is_ok()
    );
    for id in 0..scene.primitives().len() as u32 {
        let object = scene.object(id);
        let slot = scene.slot(id);
        assert!((object.first_slot..object.first_slot + object.slots).contains(&slot));
        let material = scene.slot_material(slot);
        assert_eq!(material.emission, scene.material(id).emission);
    }
}

/// Any bytes as a scene file, beside a small mesh.
pub fn scene(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    if bytes.windows(4).any(|w| w == b"file") {
        let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n";
        std::fs::write(folder.path().join("m.obj"), mesh).expect("a file");
    }
    std::fs::write(&path, bytes).expect("a file");
    open(&path);
}

/// Any bytes as an OBJ file, up to a zero byte; those after it as the MTL file `m.mtl` beside it.
pub fn obj(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let (obj, mtl) = match bytes.iter().position(|b| *b == 0) {
        Some(i) => (&bytes[..i], &bytes[i + 1..]),
        None => (bytes, &[][..]),
    };
    let path = folder.path().join("m.obj");
    std::fs::write(&path, obj).expect("a file");
    if !mtl.is_empty() {
        std::fs::write(folder.path().join("m.mtl"), mtl).expect("a file");
    }
    open(&path);
    // What any other program may rely on.
    if let Ok(mesh) = lightbox_core::scene::obj::parse(obj, &path) {
        let n = mesh.positions.len() as u32;
        assert!(
            mesh.positions.iter().all(|p| p.is_finite()) && mesh.uvs.iter().all(|p| p.is_finite())
        );
        assert!(mesh.triangles.iter().flatten().all(|i| *i < n));
        assert_eq!(mesh.triangles.len(), mesh.triangle_materials.len());
        let uvs = mesh.uvs.len() as u32;
        assert!(
            mesh.uv_triangles
                .iter()
                .flatten()
                .all(|i| *i < uvs || *i == u32::MAX)
        );
        for material in mesh.triangle_materials {
            assert!(material == u32::MAX || (material as usize) < mesh.materials.len());
        }
    }
}
