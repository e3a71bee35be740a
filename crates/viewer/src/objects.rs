//! Edits of whole objects: where they stand, how large they are, which there are. Plain functions
//! on the description; an object that is not there is left alone.

use std::path::PathBuf;

use glam::{DMat3, DQuat, DVec3, EulerRot, Vec3};
use lightbox_core::SceneDesc;
use lightbox_core::math::Aabb;
use lightbox_core::scene::{MaterialDesc, MeshDesc, ObjectKind, QuadDesc, SphereDesc};
use lightbox_core::shape::Quad;

/// The name of the material that an object has; a mesh may have its file's own.
pub fn material(desc: &mut SceneDesc, kind: ObjectKind) -> Option<Material<'_>> {
    match kind {
        ObjectKind::Sphere(i) => Some(Material::One(&mut desc.spheres.get_mut(i)?.material)),
        ObjectKind::Quad(i) => Some(Material::One(&mut desc.quads.get_mut(i)?.material)),
        ObjectKind::Mesh(i) => Some(Material::OneOrOwn(&mut desc.meshes.get_mut(i)?.material)),
    }
}

/// A place for the name of a material.
pub enum Material<'a> {
    /// There must be one.
    One(&'a mut String),
    /// `None`: those of the mesh's file.
    OneOrOwn(&'a mut Option<String>),
}

impl Material<'_> {
    /// The name that stands there.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::One(name) => Some(name),
            Self::OneOrOwn(name) => name.as_deref(),
        }
    }

    /// Puts another name there.
    pub fn set(self, name: String) {
        match self {
            Self::One(place) => *place = name,
            Self::OneOrOwn(place) => *place = Some(name),
        }
    }
}

/// The point that an object is placed by and turned around; `bounds` is [`Object::bounds`], which
/// only a mesh asks for.
///
/// [`Object::bounds`]: lightbox_core::scene::Object::bounds
pub fn center(desc: &SceneDesc, kind: ObjectKind, bounds: &Aabb) -> Option<Vec3> {
    match kind {
        ObjectKind::Sphere(i) => desc.spheres.get(i).map(|s| s.center),
        ObjectKind::Quad(i) => desc.quads.get(i).map(|q| middle(&q.corners).as_vec3()),
        ObjectKind::Mesh(i) => desc.meshes.get(i).map(|m| m.placement()(pivot(bounds))),
    }
}

/// Moves an object.
pub fn shift(desc: &mut SceneDesc, kind: ObjectKind, by: Vec3) {
    match kind {
        ObjectKind::Sphere(i) => {
            if let Some(sphere) = desc.spheres.get_mut(i) {
                sphere.center += by;
            }
        }
        ObjectKind::Quad(i) => {
            if let Some(quad) = desc.quads.get_mut(i) {
                quad.corners = quad.corners.map(|c| c + by);
            }
        }
        ObjectKind::Mesh(i) => {
            if let Some(mesh) = desc.meshes.get_mut(i) {
                mesh.translate += by;
            }
        }
    }
}

/// Turns an object about an axis through its middle, by radians; a sphere stays as it is.
pub fn turn(desc: &mut SceneDesc, kind: ObjectKind, bounds: &Aabb, axis: Vec3, by: f32) {
    let by = DQuat::from_axis_angle(axis.as_dvec3(), f64::from(by));
    match kind {
        ObjectKind::Sphere(_) => {}
        ObjectKind::Quad(i) => {
            if let Some(quad) = desc.quads.get_mut(i) {
                quad.corners = mapped(&quad.corners, DMat3::from_quat(by));
            }
        }
        ObjectKind::Mesh(i) => {
            if let Some(mesh) = desc.meshes.get_mut(i) {
                let rotate = degrees(by * quaternion(mesh.rotate));
                pose(mesh, bounds, rotate, mesh.scale);
            }
        }
    }
}

/// Makes an object larger around its middle.
pub fn grow(desc: &mut SceneDesc, kind: ObjectKind, bounds: &Aabb, factor: f32) {
    match kind {
        ObjectKind::Sphere(i) => {
            if let Some(sphere) = desc.spheres.get_mut(i) {
                sphere.radius *= factor;
            }
        }
        ObjectKind::Quad(i) => {
            if let Some(quad) = desc.quads.get_mut(i) {
                let map = DMat3::from_diagonal(DVec3::splat(f64::from(factor)));
                quad.corners = mapped(&quad.corners, map);
            }
        }
        ObjectKind::Mesh(i) => {
            if let Some(mesh) = desc.meshes.get_mut(i) {
                pose(mesh, bounds, mesh.rotate, mesh.scale * factor);
            }
        }
    }
}

/// Puts an object back as it is in another description.
pub fn restore(desc: &mut SceneDesc, kind: ObjectKind, from: &SceneDesc) {
    fn copy<T: Clone>(to: &mut [T], from: &[T], i: usize) {
        if let (Some(to), Some(from)) = (to.get_mut(i), from.get(i)) {
            *to = from.clone();
        }
    }
    match kind {
        ObjectKind::Sphere(i) => copy(&mut desc.spheres, &from.spheres, i),
        ObjectKind::Quad(i) => copy(&mut desc.quads, &from.quads, i),
        ObjectKind::Mesh(i) => copy(&mut desc.meshes, &from.meshes, i),
    }
}

/// Changes how a mesh is turned and scaled; the middle of its box, in the coordinates of its file,
/// stays where it is.
pub fn pose(mesh: &mut MeshDesc, bounds: &Aabb, rotate: Vec3, scale: f32) {
    let pivot = pivot(bounds);
    let before = mesh.placement()(pivot);
    (mesh.rotate, mesh.scale) = (rotate, scale);
    mesh.translate += before - mesh.placement()(pivot);
}

fn pivot(bounds: &Aabb) -> Vec3 {
    if bounds.is_empty() {
        return Vec3::ZERO;
    }
    bounds.center()
}

fn middle(corners: &[Vec3; 4]) -> DVec3 {
    corners.map(|c| c.as_dvec3()).iter().sum::<DVec3>() / 4.0
}

/// Along the first edge, across it in the plane, and to the front.
fn axes(corners: &[Vec3; 4]) -> Option<DMat3> {
    let [a, b, c, d] = corners.map(|p| p.as_dvec3());
    let front = (c - a).cross(d - b).try_normalize()?;
    let across = front.cross(b - a).try_normalize()?;
    Some(DMat3::from_cols(across.cross(front), across, front))
}

/// How a quadrilateral is turned: about x, then y, then z, degrees. Not at all if its first edge
/// runs along x and its front looks along z.
pub fn angles(corners: &[Vec3; 4]) -> Vec3 {
    let Some(axes) = axes(corners) else {
        return Vec3::ZERO;
    };
    degrees(DQuat::from_mat3(&axes))
}

/// A turn about x, then y, then z, degrees.
fn degrees(turn: DQuat) -> Vec3 {
    let (z, y, x) = turn.to_euler(EulerRot::ZYX);
    // From −0, a plus makes 0.
    DVec3::new(x, y, z)
        .map(|angle| angle.to_degrees() + 0.0)
        .as_vec3()
}

fn quaternion(degrees: Vec3) -> DQuat {
    let [x, y, z] = degrees.as_dvec3().to_array().map(f64::to_radians);
    DQuat::from_euler(EulerRot::ZYX, z, y, x)
}

/// The quadrilateral turned around its middle to these [`angles`].
pub fn turned(corners: &[Vec3; 4], angles: Vec3) -> [Vec3; 4] {
    let Some(axes) = axes(corners) else {
        return *corners;
    };
    mapped(
        corners,
        DMat3::from_quat(quaternion(angles)) * axes.transpose(),
    )
}

/// Whether these are [`angles`] of the quadrilateral: of a turn there are several.
pub fn is_turned_to(corners: &[Vec3; 4], angles: Vec3) -> bool {
    let size = corners[0].distance(corners[2]);
    let same = |(a, b): (&Vec3, Vec3)| a.distance(b) <= 1e-4 * size;
    corners.iter().zip(turned(corners, angles)).all(same)
}

/// Lengths of the first and the last edge, which meet in the first corner.
pub fn edges([a, b, _, d]: &[Vec3; 4]) -> [f32; 2] {
    [a.distance(*b), a.distance(*d)]
}

/// The quadrilateral stretched around its middle to these [`edges`].
pub fn stretched(corners: &[Vec3; 4], wanted: [f32; 2]) -> [Vec3; 4] {
    let [a, b, _, d] = corners.map(|p| p.as_dvec3());
    let (along, across) = (b - a, d - a);
    let factor = |edge: DVec3, wanted: f32| f64::from(wanted) / edge.length();
    let basis = DMat3::from_cols(along, across, along.cross(across));
    let scale = DVec3::new(factor(along, wanted[0]), factor(across, wanted[1]), 1.0);
    mapped(
        corners,
        basis * DMat3::from_diagonal(scale) * basis.inverse(),
    )
}

/// A linear map around the middle. A parallelogram stays one, whatever is rounded.
fn mapped(corners: &[Vec3; 4], map: DMat3) -> [Vec3; 4] {
    let middle = middle(corners);
    let [a, b, c, d] = corners.map(|p| middle + map * (p.as_dvec3() - middle));
    let d = if Quad::is_parallelogram(corners) {
        a + (c - b)
    } else {
        d
    };
    let mapped = [a, b, c, d].map(|p| p.as_vec3());
    // Degenerate corners have no inverse.
    if mapped.iter().all(|p| p.is_finite()) {
        mapped
    } else {
        *corners
    }
}

/// Takes an object out.
pub fn remove(desc: &mut SceneDesc, kind: ObjectKind) {
    fn take<T>(list: &mut Vec<T>, i: usize) {
        if i < list.len() {
            list.remove(i);
        }
    }
    match kind {
        ObjectKind::Sphere(i) => take(&mut desc.spheres, i),
        ObjectKind::Quad(i) => take(&mut desc.quads, i),
        ObjectKind::Mesh(i) => take(&mut desc.meshes, i),
    }
}

/// Adds a copy of an object under a name of its own.
pub fn duplicate(desc: &mut SceneDesc, kind: ObjectKind) -> Option<ObjectKind> {
    let free = |desc: &SceneDesc, name: &str| {
        if name.is_empty() {
            String::new()
        } else {
            free_name(desc, name)
        }
    };
    match kind {
        ObjectKind::Sphere(i) => {
            let copy = desc.spheres.get(i)?.clone();
            let name = free(desc, &copy.name);
            Some(add_sphere(desc, SphereDesc { name, ..copy }))
        }
        ObjectKind::Quad(i) => {
            let copy = desc.quads.get(i)?.clone();
            let name = free(desc, &copy.name);
            Some(add_quad(desc, QuadDesc { name, ..copy }))
        }
        ObjectKind::Mesh(i) => {
            let copy = desc.meshes.get(i)?.clone();
            let name = free(desc, &copy.name);
            Some(add_mesh(desc, MeshDesc { name, ..copy }))
        }
    }
}

/// Adds a sphere.
pub fn add_sphere(desc: &mut SceneDesc, sphere: SphereDesc) -> ObjectKind {
    desc.spheres.push(sphere);
    ObjectKind::Sphere(desc.spheres.len() - 1)
}

/// Adds a quadrilateral.
pub fn add_quad(desc: &mut SceneDesc, quad: QuadDesc) -> ObjectKind {
    desc.quads.push(quad);
    ObjectKind::Quad(desc.quads.len() - 1)
}

/// Adds a mesh.
pub fn add_mesh(desc: &mut SceneDesc, mesh: MeshDesc) -> ObjectKind {
    desc.meshes.push(mesh);
    ObjectKind::Mesh(desc.meshes.len() - 1)
}

/// A mesh file under the name of the file, with the middle of its box at a point and the box's
/// diagonal of some length.
pub fn mesh_at(file: PathBuf, bounds: &Aabb, at: Vec3, diagonal: f32) -> MeshDesc {
    let scale = diagonal / bounds.diagonal();
    let scale = if scale.is_finite() && scale > 0.0 {
        scale
    } else {
        1.0
    };
    MeshDesc {
        name: crate::model::scene_name(&file),
        material: None,
        file: Some(file),
        boulder: None,
        scale,
        rotate: Vec3::ZERO,
        translate: at - pivot(bounds) * scale,
    }
}

/// Adds a copy of a material under a name of its own, or a plain one; the name.
pub fn add_material(desc: &mut SceneDesc, like: Option<&MaterialDesc>) -> String {
    let like = like.cloned().unwrap_or_default();
    let wanted = if like.name.is_empty() {
        "material"
    } else {
        &like.name
    };
    let name = free_name(desc, wanted);
    desc.materials.push(MaterialDesc {
        name: name.clone(),
        ..like
    });
    name
}

/// The name, numbered if a material or an object has it already.
pub fn free_name(desc: &SceneDesc, wanted: &str) -> String {
    let taken = |name: &str| {
        desc.materials.iter().any(|m| m.name == name)
            || desc.spheres.iter().any(|s| s.name == name)
            || desc.quads.iter().any(|q| q.name == name)
            || desc.meshes.iter().any(|m| m.name == name)
    };
    // A copy of "ball 2" is "ball 3".
    let stem = wanted.trim_end_matches(|c: char| c.is_ascii_digit());
    let stem = stem.strip_suffix(' ').filter(|s| !s.is_empty());
    let stem = stem.unwrap_or(wanted);
    let numbered = (2..).map(|i| format!("{stem} {i}"));
    std::iter::once(wanted.to_owned())
        .chain(numbered)
        .find(|name| !taken(name))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILTED: [Vec3; 4] = [
        Vec3::new(1.0, 0.0, 0.0),
        Vec3::new(3.0, 0.5, -1.0),
        Vec3::new(3.2, 2.5, 0.2),
        Vec3::new(1.2, 2.0, 1.2),
    ];

    fn close(a: &[Vec3], b: &[Vec3]) -> bool {
        a.iter().zip(b).all(|(a, b)| a.distance(*b) < 1e-5)
    }

    #[test]
    fn a_quad_turns_to_its_angles_and_back() {
        let angles_before = angles(&TILTED);
        assert!(close(&turned(&TILTED, angles_before), &TILTED));
        assert!(is_turned_to(&TILTED, angles_before));
        assert!(!is_turned_to(&TILTED, angles_before + Vec3::X));
        let flat = turned(&TILTED, Vec3::ZERO);
        assert!(close(&[angles(&flat)], &[Vec3::ZERO]), "{flat:?}");
        assert!((flat[1] - flat[0]).normalize().distance(Vec3::X) < 1e-6);
        assert!(close(&turned(&flat, angles_before), &TILTED));
        // Its front turns with it: about y, from z to x.
        let right = turned(&flat, Vec3::new(0.0, 90.0, 0.0));
        let front = (right[1] - right[0]).cross(right[3] - right[0]).normalize();
        assert!(front.distance(Vec3::X) < 1e-6, "{right:?}");
        assert!(middle(&right).distance(middle(&TILTED)) < 1e-6);
    }

    #[test]
    fn a_quad_stretches_along_its_edges_and_stays_one_shape() {
        let mut corners = TILTED;
        for i in 0..10_000 {
            corners = turned(&corners, Vec3::splat(i as f32 * 0.7));
        }
        corners = stretched(&corners, [4.0, 0.25]);
        let [width, height] = edges(&corners);
        assert!((width - 4.0).abs() < 1e-5 && (height - 0.25).abs() < 1e-5);
        assert!(Quad::is_parallelogram(&corners));
        let flat = [Vec3::ZERO; 4];
        assert_eq!(stretched(&flat, [1.0, 1.0]), flat);
        assert_eq!(turned(&flat, Vec3::ONE), flat);
    }

    #[test]
    fn a_mesh_turns_and_grows_around_its_middle() {
        let bounds = Aabb {
            min: Vec3::new(10.0, 0.0, -3.0),
            max: Vec3::new(14.0, 2.0, -1.0),
        };
        let at = Vec3::new(1.0, 2.0, 3.0);
        let mut mesh = mesh_at("a/b.obj".into(), &bounds, at, 3.0);
        assert_eq!(mesh.name, "b");
        let mut desc = SceneDesc::default();
        let kind = add_mesh(&mut desc, mesh.clone());
        assert!(close(&[center(&desc, kind, &bounds).unwrap()], &[at]));
        pose(&mut mesh, &bounds, Vec3::new(20.0, 130.0, -7.0), 2.5);
        assert!(close(&[mesh.placement()(bounds.center())], &[at]));
        assert_eq!(mesh.scale, 2.5);
        shift(&mut desc, kind, Vec3::X);
        assert!(close(
            &[center(&desc, kind, &bounds).unwrap()],
            &[at + Vec3::X]
        ));
        assert_eq!(mesh_at("b.obj".into(), &Aabb::EMPTY, at, 1.0).translate, at);
    }

    #[test]
    fn a_turn_about_an_axis_is_the_same_for_quads_and_meshes() {
        let bounds = Aabb {
            min: Vec3::splat(-1.0),
            max: Vec3::splat(3.0),
        };
        let mut desc = SceneDesc::default();
        let mesh = add_mesh(&mut desc, mesh_at("b.obj".into(), &bounds, Vec3::ONE, 1.0));
        pose(
            &mut desc.meshes[0],
            &bounds,
            Vec3::new(10.0, 20.0, 30.0),
            0.5,
        );
        // Its corners are those of a quad.
        let flat = [(-1.0, -1.0), (3.0, -1.0), (3.0, 3.0), (-1.0, 3.0)];
        let flat = flat.map(|(x, y)| Vec3::new(x, y, 1.0));
        let corners = flat.map(desc.meshes[0].placement());
        let (name, material) = (String::new(), String::new());
        let quad = QuadDesc {
            name,
            material,
            corners,
        };
        let quad = add_quad(&mut desc, quad);
        let before = desc.clone();
        for kind in [mesh, quad] {
            turn(&mut desc, kind, &bounds, Vec3::Y, 0.7);
            turn(&mut desc, kind, &bounds, Vec3::X, -2.0);
            grow(&mut desc, kind, &bounds, 3.0);
        }
        let placed = flat.map(desc.meshes[0].placement());
        assert!(close(&placed, &desc.quads[0].corners), "{placed:?}");
        assert!(!close(&placed, &corners));
        let wide = placed[0].distance(placed[1]);
        assert!((wide - 6.0).abs() < 1e-5, "{wide}");
        for kind in [mesh, quad] {
            restore(&mut desc, kind, &before);
        }
        assert_eq!(desc, before);
    }

    #[test]
    fn copies_have_names_of_their_own() {
        let mut desc = SceneDesc::default();
        let ball = SphereDesc {
            name: "ball".into(),
            material: String::new(),
            center: Vec3::ZERO,
            radius: 1.0,
        };
        let first = add_sphere(&mut desc, ball);
        let second = duplicate(&mut desc, first).unwrap();
        let third = duplicate(&mut desc, second).unwrap();
        assert_eq!(third, ObjectKind::Sphere(2));
        let names: Vec<_> = desc.spheres.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["ball", "ball 2", "ball 3"]);
        remove(&mut desc, second);
        assert_eq!(desc.spheres.len(), 2);
        assert_eq!(desc.spheres[1].name, "ball 3");
        remove(&mut desc, ObjectKind::Quad(7));
        assert_eq!(duplicate(&mut desc, ObjectKind::Mesh(0)), None);
        let like = MaterialDesc {
            name: "ball".into(),
            ..MaterialDesc::default()
        };
        assert_eq!(add_material(&mut desc, Some(&like)), "ball 2");
        assert_eq!(add_material(&mut desc, None), "material");
        assert_eq!(free_name(&desc, "42"), "42");
    }
}
