//! The pre-pass over an OBJ text. In: any text. Out: an OBJ text of nothing but `v`, `vt` and `f`
//! records that tobj reads without error, and what is known of each face.
//!
//! tobj (4.0.5) lets NaN pass, overflows on some indices, invents texture coordinates for corners
//! without and names no lines; so everything is checked here, where the line is known.

use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use std::path::Path;

use super::text::{Warnings, arguments, finite, float, keyword_and_rest, logical_lines, quoted};
use crate::scene::check::COORDINATE_LIMIT;
use crate::scene::error::SceneError;

/// [`Face::material`] of faces before the first `usemtl`.
pub(super) const NO_MATERIAL: u32 = u32::MAX;

/// Records that say nothing about surfaces.
const SKIPPED: [&str; 13] = [
    "",
    "g",
    "o",
    "s",
    "mg",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "maplib",
    "usemap",
    "shadow_obj",
    "trace_obj",
];

/// What the pre-pass finds.
#[derive(Default)]
pub(super) struct Records {
    /// Canonical `v x y z [w]` records, all of them before the faces.
    pub vertices: String,
    /// Canonical `vt u v` records; empty if no face uses them.
    pub uvs: String,
    /// Canonical `f` records of at least three corners, `v` or `v/vt`, counted from 1.
    pub faces_text: String,
    /// One for each `f` record.
    pub faces: Vec<Face>,
    /// The different names in `usemtl` records.
    pub materials: Vec<MaterialUse>,
    /// Arguments of the different `mtllib` records, with their lines.
    pub libraries: Vec<(usize, String)>,
}

/// What tobj does not tell about a face.
pub(super) struct Face {
    /// Where it stands.
    pub line: u32,
    /// Index into [`Records::materials`], or [`NO_MATERIAL`].
    pub material: u32,
    /// Whether all its corners have texture coordinates.
    pub has_uvs: bool,
}

/// A name in `usemtl` records.
pub(super) struct MaterialUse {
    pub name: String,
    /// First line.
    pub line: usize,
    /// Number of records.
    pub count: usize,
}

/// Reads and checks all records.
pub(super) fn read(
    text: &str,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<Records, SceneError> {
    let mut reader = Reader {
        path,
        warnings,
        records: Records::default(),
        v: Numbered::new("vertex"),
        vt: Numbered::new("texture coordinate"),
        vn: Numbered::new("normal"),
        corners: Vec::new(),
        material: NO_MATERIAL,
        material_ids: HashMap::new(),
        libraries_seen: HashSet::new(),
        unknown: None,
    };
    for (line, text) in logical_lines(text) {
        reader
            .record(line, &text)
            .map_err(|message| SceneError::at_line(path, line, message))?;
    }
    reader.finish()
}

struct Reader<'a> {
    path: &'a Path,
    warnings: &'a mut Warnings,
    records: Records,
    v: Numbered,
    vt: Numbered,
    vn: Numbered,
    /// Vertex and texture coordinate of the corners of the face being read.
    corners: Vec<(usize, Option<usize>)>,
    /// Of the faces to come.
    material: u32,
    material_ids: HashMap<String, u32>,
    libraries_seen: HashSet<String>,
    /// First record that is none of OBJ's.
    unknown: Option<(usize, String)>,
}

impl Reader<'_> {
    fn record(&mut self, line: usize, text: &str) -> Result<(), String> {
        let (keyword, rest) = keyword_and_rest(text);
        match keyword {
            "v" => self.vertex(line, rest)?,
            "vt" => self.uv(line, rest)?,
            // Faces are shaded flat; only the number of normals matters, to check indices.
            "vn" => self.vn.count += 1,
            "f" | "fo" => self.face(line, rest)?,
            "l" | "p" => self.warn(line, "points and lines have no area; skipped"),
            "usemtl" => self.use_material(line, rest),
            "mtllib" => {
                if self.libraries_seen.insert(rest.to_owned()) {
                    self.records.libraries.push((line, rest.to_owned()));
                }
            }
            _ if keyword.starts_with('#') || SKIPPED.contains(&keyword) => {}
            _ => {
                self.unknown.get_or_insert_with(|| (line, quoted(keyword)));
                let keyword = quoted(keyword);
                self.warn(
                    line,
                    format!("records of type {keyword} are not supported; skipped"),
                );
            }
        }
        Ok(())
    }

    fn warn(&mut self, line: usize, message: impl Into<String>) {
        self.warnings.add(self.path, line, message);
    }

    fn vertex(&mut self, line: usize, rest: &str) -> Result<(), String> {
        let out = &mut self.records.vertices;
        let mut arguments = arguments(rest);
        let mut position = [0.0; 3];
        out.push('v');
        for coordinate in &mut position {
            let argument = arguments
                .next()
                .ok_or("a vertex needs three numbers: v x y z")?;
            *coordinate = finite(argument)?;
            out.push(' ');
            out.push_str(argument);
        }
        // A fourth number is a weight; more are a colour.
        match (arguments.next(), arguments.next()) {
            (Some(weight), None) => {
                let w = finite(weight)?;
                if w == 0.0 {
                    return Err(
                        "the fourth number of a vertex, w, is 0: a point at infinity; \
                                write 1 or leave it out"
                            .into(),
                    );
                }
                position = position.map(|x| x / w);
                out.push(' ');
                out.push_str(weight);
            }
            (Some(_), Some(_)) => self
                .warnings
                .add(self.path, line, "vertex colours are not used"),
            (None, _) => {}
        }
        self.records.vertices.push('\n');
        if let Some(x) = position.iter().find(|x| !(x.abs() <= COORDINATE_LIMIT)) {
            return Err(format!(
                "coordinate {x:e} is beyond {COORDINATE_LIMIT:e}; scale the mesh down"
            ));
        }
        self.v.count += 1;
        Ok(())
    }

    fn uv(&mut self, line: usize, rest: &str) -> Result<(), String> {
        let mut arguments = arguments(rest);
        let u = arguments
            .next()
            .ok_or("a texture coordinate needs a number: vt u v")?;
        let v = arguments.next().unwrap_or("0");
        self.records.uvs.push_str("vt");
        for argument in [u, v] {
            self.records.uvs.push(' ');
            if float(argument)?.is_finite() {
                self.records.uvs.push_str(argument);
            } else {
                // Common in exports of degenerate charts, and harmless to the geometry.
                self.records.uvs.push('0');
                self.warn(
                    line,
                    "texture coordinates that are not finite are taken as 0",
                );
            }
        }
        self.records.uvs.push('\n');
        self.vt.count += 1;
        Ok(())
    }

    fn face(&mut self, line: usize, rest: &str) -> Result<(), String> {
        self.corners.clear();
        for corner in arguments(rest) {
            let mut indices = corner.split('/');
            let v = self.v.resolve(indices.next().unwrap_or_default(), line)?;
            let mut optional = |numbered: &mut Numbered| match indices.next() {
                None | Some("") => Ok(None),
                Some(index) => numbered.resolve(index, line).map(Some),
            };
            let vt = optional(&mut self.vt)?;
            optional(&mut self.vn)?;
            if indices.next().is_some() {
                return Err(format!(
                    "corner {} has more than three indices; write v, v/vt, v//vn or v/vt/vn",
                    quoted(corner)
                ));
            }
            self.corners.push((v, vt));
        }
        if self.corners.len() < 3 {
            self.warn(
                line,
                "faces of fewer than three corners have no area; skipped",
            );
            return Ok(());
        }
        let has_uvs = self.corners.iter().all(|(_, vt)| vt.is_some());
        if !has_uvs && self.corners.iter().any(|(_, vt)| vt.is_some()) {
            self.warn(
                line,
                "faces that lack the texture coordinate of some corner are drawn without",
            );
        }
        let out = &mut self.records.faces_text;
        out.push('f');
        for (v, vt) in &self.corners {
            // Writing to a string cannot fail.
            let _ = match vt.filter(|_| has_uvs) {
                Some(vt) => write!(out, " {v}/{vt}"),
                None => write!(out, " {v}"),
            };
        }
        out.push('\n');
        self.records.faces.push(Face {
            line: line as u32,
            material: self.material,
            has_uvs,
        });
        Ok(())
    }

    fn use_material(&mut self, line: usize, name: &str) {
        if name.is_empty() {
            self.material = NO_MATERIAL;
            self.warn(line, "usemtl names no material; the default one is used");
        } else if let Some(&id) = self.material_ids.get(name) {
            self.material = id;
            self.records.materials[id as usize].count += 1;
        } else {
            self.material = self.records.materials.len() as u32;
            self.material_ids.insert(name.to_owned(), self.material);
            self.records.materials.push(MaterialUse {
                name: name.to_owned(),
                line,
                count: 1,
            });
        }
    }

    /// Checks what only the end of the file tells.
    fn finish(mut self) -> Result<Records, SceneError> {
        for numbered in [&self.v, &self.vt, &self.vn] {
            if let Some(message) = numbered.missing() {
                return Err(SceneError::at_line(
                    self.path,
                    numbered.highest_line,
                    message,
                ));
            }
        }
        if self.records.faces.is_empty() {
            return Err(match self.unknown {
                Some((line, keyword)) if self.v.count == 0 => {
                    let message =
                        format!("is not an OBJ file: no record of one begins with {keyword}");
                    SceneError::at_line(self.path, line, message)
                }
                _ => {
                    let message =
                        "has no faces, so there is nothing to see; export the mesh as polygons";
                    SceneError::in_file(self.path, message)
                }
            });
        }
        if !self.records.faces.iter().any(|face| face.has_uvs) {
            self.records.uvs = String::new();
        }
        Ok(self.records)
    }
}

/// A kind of record that faces refer to by number.
struct Numbered {
    name: &'static str,
    /// Records so far.
    count: usize,
    /// Largest number referred to, and where: it may stand further down.
    highest: usize,
    highest_line: usize,
}

impl Numbered {
    fn new(name: &'static str) -> Self {
        Self {
            name,
            count: 0,
            highest: 0,
            highest_line: 0,
        }
    }

    /// The number, from 1, that an index means.
    fn resolve(&mut self, index: &str, line: usize) -> Result<usize, String> {
        let parsed: i64 = index.parse().map_err(|_| {
            format!(
                "{} is not an index; write a whole number like 7",
                quoted(index)
            )
        })?;
        let distance = usize::try_from(parsed.unsigned_abs()).unwrap_or(usize::MAX);
        match parsed {
            0 => Err(format!(
                "{} 0 does not exist: OBJ counts from 1, or back from -1",
                self.name
            )),
            ..0 if distance <= self.count => Ok(self.count - distance + 1),
            ..0 => Err(format!(
                "{} {parsed} is before the first one; {} precede this line",
                self.name, self.count
            )),
            _ => {
                if distance > self.highest {
                    (self.highest, self.highest_line) = (distance, line);
                }
                Ok(distance)
            }
        }
    }

    /// What is wrong if a number was referred to that never came.
    fn missing(&self) -> Option<String> {
        let Self {
            name,
            count,
            highest,
            ..
        } = self;
        (highest > count).then(|| format!("{name} {highest} does not exist; the file has {count}"))
    }
}
