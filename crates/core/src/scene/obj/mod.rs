//! Triangle meshes from OBJ files with their MTL materials. In: the bytes of any file. Out: an
//! [`ObjMesh`], or one line that says what to do.
//!
//! `records` and `mtl` check each line and rewrite it to what tobj reads without fail; tobj
//! parses that; `polygon` cuts the faces into triangles. Faces are shaded flat: normals in the
//! file are checked but not used.

#[cfg(test)]
mod file_test;
mod mtl;
#[cfg(test)]
mod mtl_test;
mod polygon;
#[cfg(test)]
mod random_test;
mod records;
#[cfg(test)]
mod test;
mod text;

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::desc::MaterialDesc;
use super::error::{SceneError, SceneWarning};
use crate::math::Aabb;
use mtl::Library;
use polygon::{Outcome, Triangulator};
use records::Records;
use text::{Warnings, quoted};

/// Triangles of an OBJ file with its materials.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct ObjMesh {
    /// Vertices that faces use: finite, at most 1e18 in size.
    pub positions: Vec<Vec3>,
    /// Texture coordinates that faces use, finite; v runs up. Empty when the file has none.
    pub uvs: Vec<Vec2>,
    /// Corners as indices into `positions`, counter-clockwise seen from the front. None is without
    /// area.
    pub triangles: Vec<[u32; 3]>,
    /// Corners as indices into `uvs`, [`u32::MAX`] thrice for a face without; empty when `uvs` is.
    pub uv_triangles: Vec<[u32; 3]>,
    /// The materials of the MTL files, in their order; names are unique. Textures are absolute
    /// paths of files that were there.
    pub materials: Vec<MaterialDesc>,
    /// By triangle: index into `materials`; [`u32::MAX`] where none, or none known, is named.
    pub triangle_materials: Vec<u32>,
    /// What was odd but did not stop the load.
    pub warnings: Vec<SceneWarning>,
}

impl ObjMesh {
    /// Box around its triangles.
    pub fn bounds(&self) -> Aabb {
        let corners = self.triangles.iter().flatten();
        Aabb::of_points(corners.map(|v| self.positions[*v as usize]))
    }
}

/// Reads an OBJ file and the MTL files and textures that it names, which are looked for beside it.
pub fn load(path: &Path) -> Result<ObjMesh, SceneError> {
    let bytes = std::fs::read(path)
        .map_err(|e| SceneError::in_file(path, format!("cannot be read as an OBJ file ({e})")))?;
    parse(&bytes, path)
}

/// Parses the bytes of an OBJ file; `path` is for messages, and MTL files are relative to it.
pub fn parse(bytes: &[u8], path: &Path) -> Result<ObjMesh, SceneError> {
    let text = decode(bytes).map_err(|message| SceneError::in_file(path, message))?;
    let mut warnings = Warnings::default();
    let mut records = records::read(&text, path, &mut warnings)?;
    let mut library = Library::default();
    for (line, names) in &records.libraries {
        library.add(path, *line, names, &mut warnings)?;
    }
    let polygons = read_polygons(&mut records)
        .map_err(|e| SceneError::in_file(path, format!("cannot be read as an OBJ file ({e})")))?;
    let mut mesh = triangles(&polygons, &records, &library, path, &mut warnings);
    if mesh.triangles.is_empty() {
        return Err(SceneError::in_file(
            path,
            "has no face with an area, so there is nothing to see",
        ));
    }
    mesh.materials = library.materials;
    mesh.warnings = warnings.into_list(path);
    Ok(mesh)
}

/// The materials of an MTL text with no files beside it, and what was odd.
pub(crate) fn materials(text: &str) -> Result<(Vec<MaterialDesc>, Vec<SceneWarning>), SceneError> {
    let path = Path::new("lab.mtl");
    let (mut library, mut warnings) = (Library::default(), Warnings::default());
    library.add_text(text, path, &mut warnings)?;
    Ok((library.materials, warnings.into_list(path)))
}

/// The text of a file that can be one of OBJ.
fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, String> {
    if bytes.trim_ascii().is_empty() {
        return Err("is empty; export the mesh again".into());
    }
    if bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF") {
        return Err("is UTF-16 text; save it as UTF-8".into());
    }
    if bytes.contains(&0) {
        return Err("is not an OBJ file but binary data; convert the mesh to OBJ".into());
    }
    // Line numbers, vertex numbers and corner numbers then all fit 32 bits.
    if u32::try_from(bytes.len()).is_err() {
        return Err("is larger than 4 GiB; split it into several meshes".into());
    }
    Ok(text::decode(bytes))
}

/// All faces in one mesh of tobj, in their order. Takes the texts out of `records`.
fn read_polygons(records: &mut Records) -> Result<tobj::Mesh, tobj::LoadError> {
    let [vertices, uvs, faces] = [
        &mut records.vertices,
        &mut records.uvs,
        &mut records.faces_text,
    ]
    .map(std::mem::take);
    let mut reader = vertices
        .as_bytes()
        .chain(uvs.as_bytes())
        .chain(faces.as_bytes());
    let (models, _) = tobj::load_obj_buf(&mut reader, &tobj::LoadOptions::default(), |_| {
        Err(tobj::LoadError::GenericFailure)
    })?;
    // Without "o", "g" and "usemtl" records there is one model.
    models
        .into_iter()
        .next()
        .map(|model| model.mesh)
        .ok_or(tobj::LoadError::GenericFailure)
}

fn triangles(
    polygons: &tobj::Mesh,
    records: &Records,
    library: &Library,
    path: &Path,
    warnings: &mut Warnings,
) -> ObjMesh {
    let ids: Vec<u32> = records
        .materials
        .iter()
        .map(|used| {
            library.ids.get(&used.name).copied().unwrap_or_else(|| {
                let message = format!(
                    "no material {}; the default one is used",
                    quoted(&used.name)
                );
                warnings.add_counted(path, used.line, used.count, message);
                u32::MAX
            })
        })
        .collect();

    let mut mesh = ObjMesh {
        positions: polygons
            .positions
            .chunks_exact(3)
            .map(Vec3::from_slice)
            .collect(),
        uvs: polygons
            .texcoords
            .chunks_exact(2)
            .map(Vec2::from_slice)
            .collect(),
        ..ObjMesh::default()
    };
    let mut triangulator = Triangulator::default();
    let mut corners = Vec::new();
    let mut start = 0;
    for (i, face) in records.faces.iter().enumerate() {
        let line = face.line as usize;
        // No list of sizes means that all are triangles.
        let end = start + polygons.face_arities.get(i).map_or(3, |n| *n as usize);
        let vertices = &polygons.indices[start..end];
        corners.clear();
        corners.extend(vertices.iter().map(|v| mesh.positions[*v as usize]));
        match triangulator.triangulate(&corners) {
            Outcome::Covered => {}
            Outcome::Crossing => {
                warnings.add(path, line, "faces that cross themselves may look wrong")
            }
            Outcome::NoArea => warnings.add(path, line, "faces without area are skipped"),
        }
        let material = ids.get(face.material as usize).copied().unwrap_or(u32::MAX);
        for triangle in &triangulator.triangles {
            mesh.triangles.push(triangle.map(|c| vertices[c]));
            mesh.triangle_materials.push(material);
            if !mesh.uvs.is_empty() {
                let uvs = &polygons.texcoord_indices[start..end];
                // tobj makes coordinates up for faces without.
                mesh.uv_triangles
                    .push(triangle.map(|c| if face.has_uvs { uvs[c] } else { u32::MAX }));
            }
        }
        start = end;
    }
    mesh
}
