//! From a description to a frozen scene. In: [`SceneDesc`] and the files it names. Out: [`Scene`],
//! which rays can be cast at from any thread.

mod assemble;
mod boulder;
mod builtin;
mod census;
mod check;
mod desc;
mod error;
mod load;
pub mod obj;
mod rewrite;
mod stage;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use glam::{Vec2, Vec3};

pub use boulder::boulder;
pub use builtin::{LAB as BUILTIN_LAB, NAMES as BUILTIN};
pub use census::{Census, MaterialKinds};
pub use desc::{CameraDesc, MaterialDesc, MeshDesc, QuadDesc, SceneDesc, SphereDesc};
pub use error::{SceneError, SceneWarning};
pub use load::{Source, load, parse, save};

use crate::accel::Progress;
use crate::bsdf::Bsdf;
use crate::geometry::{Geometry, Hit, Primitives, Traversal};
use crate::integrator::Transport;
use crate::light::{Casters, Guide, Lights};
use crate::material::Material;
use crate::math::{Aabb, Ray};
use crate::settings::{AccelKind, Method};
use crate::shape::Sphere;
use obj::ObjMesh;

/// What building a scene is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Reading meshes and textures.
    Reading,
    /// Building the accelerator.
    BuildingAccelerator {
        /// Over so many primitives.
        primitives: usize,
        /// How much of it is done, to 100.
        percent: u8,
    },
    /// Done.
    Ready,
}

/// Who is told what building a scene is busy with, from whichever thread does it, and says
/// whether to go on: if not, what was begun ends with an error soon.
pub type Watcher<'a> = &'a (dyn Fn(Phase) -> ControlFlow<()> + Sync);

/// The [`Watcher`] where nobody watches.
pub fn unwatched(_: Phase) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Tells a watcher; an error if it wants no more.
fn tell(watcher: Watcher<'_>, phase: Phase) -> Result<(), SceneError> {
    if watcher(phase).is_break() {
        return Err(SceneError::in_file(Path::new(""), "cancelled"));
    }
    Ok(())
}

/// One sphere, quad or mesh of the description.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Object {
    /// Where it stands in the description.
    pub kind: ObjectKind,
    /// Label: its name, or kind and number.
    pub label: String,
    /// Its first material slot.
    pub first_slot: u32,
    /// Number of its slots: one for each material of the mesh file, else 1.
    pub slots: u32,
    /// Box around it; around a mesh as its file has it, before [`MeshDesc::placement`].
    pub bounds: Aabb,
    /// Box around it where it stands in the scene.
    pub placed: Aabb,
}

/// Index into the description's list of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectKind {
    /// `desc.spheres[i]`
    Sphere(usize),
    /// `desc.quads[i]`
    Quad(usize),
    /// `desc.meshes[i]`
    Mesh(usize),
}

/// A sphere that is a mirror, or a blend with one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MirrorSphere {
    /// Primitive id.
    pub prim: u32,
    pub sphere: Sphere,
    /// Reflectance of the mirror, its share of the blend included.
    pub reflectance: Vec3,
}

/// Everything a picture is taken of. Frozen; cheap to clone and share through `Arc`.
#[derive(Debug)]
pub struct Scene {
    desc: SceneDesc,
    path: PathBuf,
    meshes: MeshCache,
    textures: assemble::Textures,
    geometry: Arc<Geometry>,
    objects: Arc<[Object]>,
    /// By slot.
    materials: Vec<Material>,
    /// By slot: the name under which the material stands, or would stand, in the description.
    material_names: Vec<String>,
    lights: Lights,
    mirror_spheres: Vec<MirrorSphere>,
    casters: Casters,
    guide: OnceLock<Option<Guide>>,
    census: Census,
    warnings: Vec<SceneWarning>,
}

impl Scene {
    /// Builds a scene; paths in `desc` are relative to the folder of `path`.
    fn build(
        desc: SceneDesc,
        path: &Path,
        known_meshes: &MeshCache,
        textures: assemble::Textures,
        watcher: Watcher<'_>,
    ) -> Result<Self, SceneError> {
        check::check(&desc)?;
        tell(watcher, Phase::Reading)?;
        let meshes = known_meshes.complete(&desc, path)?;
        let (primitives, objects) = assemble::primitives(&desc, &meshes);
        check::count(primitives.len()).map_err(|problem| SceneError::in_file(path, problem))?;
        let count = primitives.len();
        let building = |percent| Phase::BuildingAccelerator {
            primitives: count,
            percent,
        };
        tell(watcher, building(0))?;
        let report = |percent| watcher(building(percent));
        let work = Progress::new(&report);
        let geometry = Geometry::build_watched(primitives, desc.render.built_accel(), &work);
        // Whether it was ended early.
        tell(watcher, building(100))?;
        let geometry = Arc::new(geometry);
        let scene = Self::finish(desc, path, meshes, textures, geometry, objects.into())?;
        tell(watcher, Phase::Ready)?;
        Ok(scene)
    }

    /// Whether [`Scene::edit`] to `desc` needs a new accelerator, and so may take long.
    pub fn rebuilds_for(&self, desc: &SceneDesc) -> bool {
        !self.desc.same_shapes(desc)
    }

    /// The same scene with another accelerator, built unless it is the one that it was asked for
    /// with.
    pub fn with_accel(self: &Arc<Self>, accel: AccelKind) -> Result<Arc<Self>, SceneError> {
        if accel == self.desc.render.accel {
            return Ok(self.clone());
        }
        let mut desc = self.desc.clone();
        desc.render.accel = accel;
        self.edit(desc, &unwatched).map(Arc::new)
    }

    /// The same scene with an edited description. What the edit did not touch is shared: only
    /// moved or changed shapes, or another accelerator, lead to a new one.
    pub fn edit(&self, desc: SceneDesc, watcher: Watcher<'_>) -> Result<Self, SceneError> {
        if self.rebuilds_for(&desc) {
            let textures = self.textures.clone();
            return Self::build(desc, &self.path, &self.meshes, textures, watcher);
        }
        check::check(&desc)?;
        let (meshes, textures) = (self.meshes.clone(), self.textures.clone());
        let scene = Self::finish(
            desc,
            &self.path,
            meshes,
            textures,
            self.geometry.clone(),
            self.objects.clone(),
        )?;
        tell(watcher, Phase::Ready)?;
        Ok(scene)
    }

    /// Materials, lights and warnings around ready geometry.
    fn finish(
        desc: SceneDesc,
        path: &Path,
        meshes: MeshCache,
        mut textures: assemble::Textures,
        geometry: Arc<Geometry>,
        objects: Arc<[Object]>,
    ) -> Result<Self, SceneError> {
        let mut warnings: Vec<SceneWarning> = meshes
            .iter()
            .flat_map(|m| m.warnings.iter().cloned())
            .collect();
        let (material_names, materials) =
            assemble::materials(&desc, path, &meshes, &objects, &mut textures)?;
        let lights = assemble::lights(geometry.primitives(), &materials);
        if lights.is_empty() && desc.background == Vec3::ZERO {
            warnings.push(SceneWarning::general(
                "nothing emits light, so the picture is black; give a material an emission, or set background",
            ));
        }
        let mut scene = Self {
            desc,
            path: path.to_owned(),
            meshes,
            textures,
            geometry,
            objects,
            materials,
            material_names,
            lights,
            mirror_spheres: Vec::new(),
            casters: Casters::default(),
            guide: OnceLock::new(),
            census: Census::default(),
            warnings,
        };
        scene.mirror_spheres = assemble::mirror_spheres(&scene);
        scene.casters = assemble::casters(&scene);
        scene.census = Census::of(&scene);
        if let Some(object) = scene.object_around_camera() {
            let warning = format!(
                "the camera is inside \"{}\"; move eye out of it to see it from outside",
                object.label
            );
            return Ok(Self {
                warnings: [scene.warnings.clone(), vec![SceneWarning::general(warning)]].concat(),
                ..scene
            });
        }
        Ok(scene)
    }

    /// The object that the camera looks out of, if any: a sphere around the eye, or a closed
    /// mesh whose back it sees straight ahead from within its box.
    fn object_around_camera(&self) -> Option<&Object> {
        let CameraDesc { eye, target, .. } = self.desc.camera;
        let ray = Ray::new(eye, (target - eye).normalize_or_zero());
        let hit = self.intersect(&ray)?;
        let object = self.object(hit.prim);
        let back = self.primitives().surface_point(&ray, &hit).n.dot(ray.dir) > 0.0;
        let inside = match object.kind {
            ObjectKind::Sphere(_) => back,
            ObjectKind::Quad(_) => false,
            ObjectKind::Mesh(_) => back && object.placed.contains(eye),
        };
        // A room seen from within is meant so.
        let room = object.placed == self.geometry.bounds();
        (inside && !room).then_some(object)
    }

    /// The nearest surface along a ray.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.geometry
            .intersect(ray, |prim| self.material(prim).emits())
    }

    /// What it takes to find what [`Scene::intersect`] finds.
    pub(crate) fn traversal(&self, ray: &Ray) -> Traversal {
        let is_emitter = |prim| self.material(prim).emits();
        self.geometry.traversal(ray, is_emitter)
    }

    /// The nearest surface along each ray, in place of what `hits` held.
    pub fn intersect_all(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        hits.resize(rays.len(), None);
        self.geometry.intersect_many(
            rays,
            |ray| *ray,
            |prim| self.material(prim).emits(),
            |i, hit| hits[i] = hit,
        );
    }

    /// Whether anything but primitive `except` lies within the ray's `t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray, except: u32) -> bool {
        self.geometry.occluded(ray, except)
    }

    /// Material of a primitive.
    #[inline(always)]
    pub fn material(&self, prim: u32) -> &Material {
        &self.materials[self.primitives().slots[prim as usize] as usize]
    }

    /// Materials by slot.
    pub(crate) fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The primitives.
    #[inline(always)]
    pub fn primitives(&self) -> &Primitives {
        self.geometry.primitives()
    }

    /// Primitives and accelerator.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Whether there is no light at all.
    pub fn is_dark(&self) -> bool {
        self.lights.is_empty() && self.desc.background == Vec3::ZERO
    }

    /// The emitters.
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// The spheres that mirror on their outsides.
    pub(crate) fn mirror_spheres(&self) -> &[MirrorSphere] {
        &self.mirror_spheres
    }

    /// The methods that differ in it: light paths are traced only where something casts caustics.
    pub fn methods(&self) -> impl Iterator<Item = Method> {
        let all = Method::ALL.iter().copied();
        all.filter(|method| *method != Method::Caustics || self.casts_caustics())
    }

    /// Whether light may take ways that light paths find and nothing aims at.
    pub(crate) fn casts_caustics(&self) -> bool {
        !self.casters.is_empty() && !self.lights.is_empty()
    }

    /// What may throw caustics that are not aimed at by way of mirror spheres.
    pub(crate) fn casters(&self) -> &Casters {
        &self.casters
    }

    /// Where caustics come from, if there are any: found when it is first asked for, in some
    /// milliseconds, by the scene of the transport, which is this one.
    pub(crate) fn guide(&self, transport: &Transport<'_>) -> Option<&Guide> {
        self.guide.get_or_init(|| Guide::of(transport)).as_ref()
    }

    /// Whether a primitive mirrors, refracts or emits light.
    #[inline(always)]
    pub(crate) fn shows_caustics(&self, prim: u32) -> bool {
        let material = self.material(prim);
        material.emits() || !matches!(material.bsdf(Vec2::default), Bsdf::Diffuse(_))
    }

    /// What it uses.
    pub fn census(&self) -> &Census {
        &self.census
    }

    /// Radiance from where nothing is, W/(m²·sr).
    pub fn background(&self) -> Vec3 {
        self.desc.background
    }

    /// The description it was built from.
    pub fn desc(&self) -> &SceneDesc {
        &self.desc
    }

    /// The file it came from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was odd but did not stop the load.
    pub fn warnings(&self) -> &[SceneWarning] {
        &self.warnings
    }

    /// The objects, in the order spheres, quads, meshes.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The object that a primitive belongs to.
    pub fn object(&self, prim: u32) -> &Object {
        let slot = self.primitives().slots[prim as usize];
        let i = self.objects.partition_point(|o| o.first_slot <= slot) - 1;
        &self.objects[i]
    }

    /// Material slot of a primitive.
    pub fn slot(&self, prim: u32) -> u32 {
        self.primitives().slots[prim as usize]
    }

    /// Name of the material in each slot; several slots may have one in common.
    pub fn material_names(&self) -> &[String] {
        &self.material_names
    }

    /// The material of a slot as it stands, or would have to stand, in the description: putting
    /// an edited copy there (replacing the one of that name) changes the slot.
    pub fn slot_material(&self, slot: u32) -> MaterialDesc {
        let name = &self.material_names[slot as usize];
        if let Some(material) = self.desc.materials.iter().find(|m| m.name == *name) {
            return material.clone();
        }
        let from_mesh = self
            .objects
            .iter()
            .find(|o| (o.first_slot..o.first_slot + o.slots).contains(&slot))
            .and_then(|o| {
                let ObjectKind::Mesh(i) = o.kind else {
                    return None;
                };
                let mesh = self.meshes.get(&self.desc.meshes[i])?;
                mesh.materials.get((slot - o.first_slot) as usize).cloned()
            });
        MaterialDesc {
            name: name.clone(),
            ..from_mesh.unwrap_or_default()
        }
    }
}

/// Meshes by what the description says of their source: read once, shared between edits.
#[derive(Clone, Debug, Default)]
struct MeshCache(Vec<(Option<PathBuf>, Option<u32>, Arc<ObjMesh>)>);

impl MeshCache {
    fn get(&self, desc: &MeshDesc) -> Option<&Arc<ObjMesh>> {
        self.0
            .iter()
            .find(|(file, boulder, _)| (file, boulder) == (&desc.file, &desc.boulder))
            .map(|(_, _, mesh)| mesh)
    }

    fn insert(&mut self, desc: &MeshDesc, mesh: Arc<ObjMesh>) {
        self.0.push((desc.file.clone(), desc.boulder, mesh));
    }

    fn iter(&self) -> impl Iterator<Item = &ObjMesh> {
        self.0.iter().map(|(_, _, mesh)| &**mesh)
    }

    /// The meshes that `desc` needs, reading those not yet there; paths are relative to the
    /// folder of `path`.
    fn complete(&self, desc: &SceneDesc, path: &Path) -> Result<Self, SceneError> {
        let mut cache = Self::default();
        for (i, mesh) in desc.meshes.iter().enumerate() {
            if cache.get(mesh).is_some() {
                continue;
            }
            let ready = match (self.get(mesh), &mesh.file, mesh.boulder) {
                (Some(known), _, _) => known.clone(),
                (None, Some(file), _) => {
                    let file = builtin::beside(path, file);
                    Arc::new(load::read_mesh(&file).map_err(|e| missing_file(e, i))?)
                }
                (None, None, triangles) => {
                    let (positions, triangles) = boulder(triangles.unwrap_or(20));
                    Arc::new(ObjMesh {
                        triangle_materials: vec![u32::MAX; triangles.len()],
                        positions,
                        triangles,
                        ..ObjMesh::default()
                    })
                }
            };
            cache.insert(mesh, ready);
        }
        Ok(cache)
    }
}

/// An error about a mesh file as a whole is also one about the line that names it.
fn missing_file(error: SceneError, mesh: usize) -> SceneError {
    if error.line.is_some() {
        return error;
    }
    SceneError::at_place("mesh", mesh, "file", error.to_string())
}
