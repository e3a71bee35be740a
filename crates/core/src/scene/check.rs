//! What a description must satisfy before it is built: each violation is one line that says what
//! to write instead.

use glam::Vec3;

use super::desc::{MaterialDesc, MeshDesc, QuadDesc, SceneDesc, SphereDesc};
use super::error::SceneError;
use crate::accel::bvh::MAX_PRIMITIVES;
use crate::suggest;

/// Largest coordinate: beyond it, squares and products leave the range of f32.
pub(super) const COORDINATE_LIMIT: f32 = 1e18;

/// Largest emission per channel, W/(m²·sr): what the film can sum up.
pub(super) const EMISSION_LIMIT: f32 = 1e9;

/// Whether nodes of accelerators can count so many primitives.
pub(super) fn count(primitives: usize) -> Result<(), String> {
    if primitives < MAX_PRIMITIVES {
        return Ok(());
    }
    Err(format!(
        "has {primitives} triangles, quads and spheres; use fewer than {MAX_PRIMITIVES}"
    ))
}

/// Finds the first thing wrong with a description.
pub(super) fn check(desc: &SceneDesc) -> Result<(), SceneError> {
    if let Some(problem) = desc.render.problem() {
        return Err(SceneError::at_place(
            "render",
            0,
            "",
            format!("render: {problem}"),
        ));
    }
    if let Err(problem) = crate::Camera::new(&desc.camera, desc.render.width, desc.render.height) {
        return Err(SceneError::at_place("camera", 0, "", problem));
    }
    if !in_range(desc.background, EMISSION_LIMIT) {
        let problem = format!("background must be three numbers from 0 to {EMISSION_LIMIT:e}");
        return Err(SceneError::at_place("", 0, "background", problem));
    }
    for (i, material) in desc.materials.iter().enumerate() {
        let first = desc.materials.iter().position(|m| m.name == material.name);
        check_material(material, first != Some(i)).map_err(|(key, problem)| {
            SceneError::at_place(
                "material",
                i,
                key,
                format!("material \"{}\": {problem}", material.name),
            )
        })?;
    }
    let names: Vec<&str> = desc.materials.iter().map(|m| m.name.as_str()).collect();
    let known = |name: &str| {
        if names.contains(&name) {
            Ok(())
        } else {
            Err((
                "material",
                format!(
                    "unknown material \"{name}\"{}",
                    suggest::among(name, &names)
                ),
            ))
        }
    };
    for (i, sphere) in desc.spheres.iter().enumerate() {
        let result = known(&sphere.material).and_then(|()| check_sphere(sphere));
        result.map_err(|e| at_shape("sphere", i, &sphere.name, e))?;
    }
    for (i, quad) in desc.quads.iter().enumerate() {
        let result = known(&quad.material).and_then(|()| check_quad(quad));
        result.map_err(|e| at_shape("quad", i, &quad.name, e))?;
    }
    for (i, mesh) in desc.meshes.iter().enumerate() {
        let result = mesh
            .material
            .as_deref()
            .map_or(Ok(()), known)
            .and_then(|()| check_mesh(mesh));
        result.map_err(|e| at_shape("mesh", i, &mesh.name, e))?;
    }
    Ok(())
}

/// The key at fault and what is wrong with it.
type Fault = (&'static str, String);

fn at_shape(table: &'static str, i: usize, name: &str, (key, problem): Fault) -> SceneError {
    let label = if name.is_empty() {
        format!("{table} {}", i + 1)
    } else {
        format!("{table} \"{name}\"")
    };
    SceneError::at_place(table, i, key, format!("{label}: {problem}"))
}

fn in_range(v: Vec3, limit: f32) -> bool {
    v.cmpge(Vec3::ZERO).all() && v.cmple(Vec3::splat(limit)).all()
}

fn coordinates(v: Vec3) -> bool {
    v.abs().cmple(Vec3::splat(COORDINATE_LIMIT)).all()
}

fn check_material(m: &MaterialDesc, repeated: bool) -> Result<(), Fault> {
    if m.name.is_empty() {
        return Err(("name", "has no name; write name = \"…\"".into()));
    }
    if repeated {
        return Err(("name", "the name is used twice; rename one".into()));
    }
    for (key, color) in [("albedo", m.albedo), ("mirror_color", m.mirror_color)] {
        if !in_range(color, 1.0) {
            return Err((
                key,
                format!("{key} is {color}; reflectances are three numbers from 0 to 1"),
            ));
        }
    }
    if !(0.0..=1.0).contains(&m.mirror) {
        return Err((
            "mirror",
            format!("mirror is {}; use 0 (diffuse) to 1 (mirror)", m.mirror),
        ));
    }
    if let Some(ior) = m.glass.filter(|ior| !(0.2..=5.0).contains(ior)) {
        return Err((
            "glass",
            format!(
                "glass is {ior}; an index of refraction is between 0.2 and 5, for window glass 1.5"
            ),
        ));
    }
    if !in_range(m.emission, EMISSION_LIMIT) {
        return Err((
            "emission",
            format!(
                "emission is {}; use three numbers from 0 to {EMISSION_LIMIT:e}",
                m.emission
            ),
        ));
    }
    Ok(())
}

fn check_sphere(s: &SphereDesc) -> Result<(), Fault> {
    if !coordinates(s.center) {
        return Err((
            "center",
            format!(
                "center is {}; use finite numbers up to {COORDINATE_LIMIT:e}",
                s.center
            ),
        ));
    }
    if !(s.radius > 0.0 && s.radius <= COORDINATE_LIMIT) {
        return Err((
            "radius",
            format!(
                "radius is {}; use a positive number up to {COORDINATE_LIMIT:e}",
                s.radius
            ),
        ));
    }
    Ok(())
}

fn check_quad(q: &QuadDesc) -> Result<(), Fault> {
    if !q.corners.iter().all(|c| coordinates(*c)) {
        return Err((
            "corners",
            format!("a corner is not finite or beyond {COORDINATE_LIMIT:e}"),
        ));
    }
    // Convex if the four corners turn the same way: then both splits have consistent normals.
    let [a, b, c, d] = q.corners.map(|p| p.as_dvec3());
    let turns = [(a, b, c), (b, c, d), (c, d, a), (d, a, b)].map(|(p, q, r)| (q - p).cross(r - q));
    if turns.iter().any(|n| n.length_squared() == 0.0) {
        return Err((
            "corners",
            "has no area: two corners coincide or three lie on a line".into(),
        ));
    }
    if turns.iter().any(|n| n.dot(turns[0]) <= 0.0) {
        return Err(("corners", "corners cross or cave in; list four corners of a convex shape in order around the edge".into()));
    }
    Ok(())
}

fn check_mesh(m: &MeshDesc) -> Result<(), Fault> {
    match (&m.file, m.boulder) {
        (None, None) => {
            return Err((
                "",
                "write file = \"….obj\", or boulder = a number of triangles".into(),
            ));
        }
        (Some(_), Some(_)) => {
            return Err((
                "boulder",
                "file and boulder exclude each other; remove one".into(),
            ));
        }
        (None, Some(n)) if !(20..=50_000_000).contains(&n) => {
            return Err((
                "boulder",
                format!("boulder is {n}; use 20 to 50000000 triangles"),
            ));
        }
        _ => {}
    }
    if !(m.scale > 0.0 && m.scale <= COORDINATE_LIMIT) {
        return Err((
            "scale",
            format!(
                "scale is {}; use a positive number up to {COORDINATE_LIMIT:e}",
                m.scale
            ),
        ));
    }
    if !m.rotate.is_finite() {
        return Err((
            "rotate",
            "rotate must be three finite numbers, degrees".into(),
        ));
    }
    if !coordinates(m.translate) {
        return Err((
            "translate",
            format!("translate must be three finite numbers up to {COORDINATE_LIMIT:e}"),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod test {
    use glam::Vec3;

    use super::*;
    use crate::scene::{load, save};

    /// Neither is what was there before lost.
    #[test]
    fn what_could_not_be_read_again_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        let from = std::path::Path::new("builtin:teddy-diffuse.toml");
        let mut desc = load(from).unwrap().desc;
        save(&path, &desc, from).unwrap();
        let before = std::fs::read(&path).unwrap();
        desc.meshes[0].translate = Vec3::splat(1e30);
        let error = save(&path, &desc, from).unwrap_err();
        assert!(error.contains("a.toml: not written"), "{error}");
        assert!(error.contains("finite numbers up to 1e18"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), before);
    }

    #[test]
    fn more_primitives_than_nodes_can_count_are_refused() {
        assert_eq!(count(0), Ok(()));
        assert_eq!(count((1 << 28) - 1), Ok(()));
        for too_many in [1 << 28, 1 << 31, usize::MAX] {
            let problem = count(too_many).unwrap_err();
            assert!(problem.contains("use fewer than 268435456"), "{problem}");
        }
    }
}
