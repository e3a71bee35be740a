//! MTL material libraries. As with OBJ, a pre-pass checks every record and hands tobj canonical
//! ones: tobj (4.0.5) panics on a colour of one number and drops a whole file for one odd record.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use glam::Vec3;

use super::text::{
    Warnings, arguments, decode, find_file, finite, keyword_and_rest, logical_lines, quoted,
};
use crate::scene::check::EMISSION_LIMIT;
use crate::scene::desc::MaterialDesc;
use crate::scene::error::SceneError;

/// Index of refraction of glass that states none, or one that no glass has.
const DEFAULT_IOR: f32 = 1.5;

/// The materials of all libraries of an OBJ file.
#[derive(Default)]
pub(super) struct Library {
    pub materials: Vec<MaterialDesc>,
    pub ids: HashMap<String, u32>,
}

impl Library {
    /// Adds the files that a `mtllib` record of `obj` names. One that is not there is a warning:
    /// the geometry is still worth seeing.
    pub(super) fn add(
        &mut self,
        obj: &Path,
        line: usize,
        names: &str,
        warnings: &mut Warnings,
    ) -> Result<(), SceneError> {
        let folder = obj.parent().unwrap_or(Path::new(""));
        for name in library_names(names) {
            let Some(path) = find_file(folder, name) else {
                let message = format!(
                    "no material library {}; put it beside the OBJ file",
                    quoted(name)
                );
                warnings.add(obj, line, message);
                continue;
            };
            match std::fs::read(&path) {
                Ok(bytes) => self.add_text(&decode(&bytes), &path, warnings)?,
                Err(e) => warnings.add(
                    obj,
                    line,
                    format!("cannot read material library {} ({e})", quoted(name)),
                ),
            }
        }
        Ok(())
    }

    /// Adds the materials of a text; `path` is for messages, and textures are relative to it.
    pub(super) fn add_text(
        &mut self,
        text: &str,
        path: &Path,
        warnings: &mut Warnings,
    ) -> Result<(), SceneError> {
        let (canonical, lines) = canonical(text, path, warnings)?;
        let (materials, _) = tobj::load_mtl_buf(&mut canonical.as_bytes())
            .map_err(|e| SceneError::in_file(path, e.to_string()))?;
        for (material, line) in materials.iter().zip(lines) {
            if self.ids.contains_key(&material.name) {
                warnings.add(path, line, "materials of a name that was taken are skipped");
                continue;
            }
            let mut warn = |message| warnings.add(path, line, message);
            self.ids
                .insert(material.name.clone(), self.materials.len() as u32);
            self.materials.push(describe(material, path, &mut warn));
        }
        Ok(())
    }
}

/// The names in a `mtllib` record. They may hold blanks, so each runs up to its extension.
fn library_names(text: &str) -> Vec<&str> {
    let is_whole = |name: &str| {
        let extension = name.get(name.len().saturating_sub(4)..);
        extension.is_some_and(|e| e.eq_ignore_ascii_case(".mtl"))
    };
    let mut names = Vec::new();
    let mut start = 0;
    for (end, _) in text.match_indices(|c: char| c.is_ascii_whitespace()) {
        if is_whole(&text[start..end]) {
            names.push(text[start..end].trim());
            start = end;
        }
    }
    names.push(text[start..].trim());
    names
}

/// The records that have a meaning here, in the form that tobj reads, and the line of each
/// material. All others are skipped.
fn canonical(
    text: &str,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<(String, Vec<usize>), SceneError> {
    const KEYS: [&str; 7] = ["newmtl", "Kd", "Ks", "Ke", "Ni", "illum", "map_Kd"];
    let mut out = String::new();
    let mut lines = Vec::new();
    for (line, text) in logical_lines(text) {
        let (keyword, rest) = keyword_and_rest(&text);
        let Some(&key) = KEYS.iter().find(|key| key.eq_ignore_ascii_case(keyword)) else {
            continue;
        };
        let error = |message| SceneError::at_line(path, line, format!("{key}: {message}"));
        let mut warn = |message: &str| warnings.add(path, line, format!("{key}: {message}"));
        if key == "newmtl" {
            if rest.is_empty() {
                return Err(error("the material has no name; write one".to_owned()));
            }
            lines.push(line);
        } else if lines.is_empty() {
            warn("stands before the first newmtl; skipped");
            continue;
        }
        let value = match key {
            "newmtl" => Some(rest.to_owned()),
            "Kd" | "Ks" => color(rest, 1.0, &mut warn).map_err(error)?,
            "Ke" => color(rest, EMISSION_LIMIT, &mut warn).map_err(error)?,
            "Ni" => {
                let argument = arguments(rest).next().unwrap_or_default();
                Some(finite(argument).map_err(error)?.to_string())
            }
            "illum" => illumination(rest, &mut warn),
            _ => texture_name(rest, &mut warn),
        };
        if let Some(value) = value {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{key} {value}");
        }
    }
    Ok((out, lines))
}

/// Three numbers clamped to `[0, limit]`, or one for all three; `None` for other colour spaces.
fn color(rest: &str, limit: f32, warn: &mut dyn FnMut(&str)) -> Result<Option<String>, String> {
    let arguments: Vec<&str> = arguments(rest).take(3).collect();
    let rgb = match *arguments {
        ["spectral" | "xyz", ..] => {
            warn("spectral and xyz colours are not supported; skipped");
            return Ok(None);
        }
        [gray] => [gray; 3],
        [r, g, b] => [r, g, b],
        _ => {
            return Err(format!(
                "a colour is one or three numbers, here are {}",
                arguments.len()
            ));
        }
    };
    let mut clamped = [0.0; 3];
    for (clamped, argument) in clamped.iter_mut().zip(rgb) {
        let value = finite(argument)?;
        *clamped = value.clamp(0.0, limit);
        if *clamped != value {
            warn(&format!("values are clamped to 0 … {limit}"));
        }
    }
    let [r, g, b] = clamped;
    Ok(Some(format!("{r} {g} {b}")))
}

/// An illumination model.
fn illumination(rest: &str, warn: &mut dyn FnMut(&str)) -> Option<String> {
    let argument = arguments(rest).next().unwrap_or_default();
    if argument.parse::<u8>().is_err() {
        warn("the illumination model is a number from 0 to 10; skipped");
        return None;
    }
    Some(argument.to_owned())
}

/// File name after the options of a texture, which have no counterpart here: a warning says so
/// unless they change nothing.
fn texture_name(rest: &str, warn: &mut dyn FnMut(&str)) -> Option<String> {
    let mut name = rest;
    let mut changes = false;
    while name.starts_with('-') {
        let (option, mut tail) = keyword_and_rest(name);
        // Least and most arguments, and the numbers that change nothing.
        let (least, most, neutral) = match option {
            "-s" => (1, 3, Some(1.0)),
            "-o" | "-t" => (1, 3, Some(0.0)),
            "-mm" => (2, 2, None),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-texres" | "-bm" | "-boost"
            | "-imfchan" | "-type" => (1, 1, None),
            _ => break,
        };
        changes |= neutral.is_none();
        for i in 0..most {
            let (argument, after) = keyword_and_rest(tail);
            let number = argument.parse::<f32>();
            if i >= least && number.is_err() {
                break;
            }
            changes |= number.ok() != neutral;
            tail = after;
        }
        name = tail;
    }
    if changes {
        warn("texture options are not supported; skipped");
    }
    if name.is_empty() {
        warn("names no file; skipped");
        return None;
    }
    Some(name.to_owned())
}

/// What a material of an MTL file is in lightbox.
fn describe(material: &tobj::Material, mtl: &Path, warn: &mut dyn FnMut(String)) -> MaterialDesc {
    let defaults = MaterialDesc::default();
    let illumination = material.illumination_model.unwrap_or(2);
    let texture = material.diffuse_texture.as_deref().and_then(|name| {
        let found = find_file(mtl.parent().unwrap_or(Path::new("")), name);
        if found.is_none() {
            warn(format!(
                "no texture {}; put it beside the MTL file",
                quoted(name)
            ));
        }
        // Absolute, so that it does not matter what the reader's own paths are relative to.
        found.map(|path| std::path::absolute(&path).unwrap_or(path))
    });
    let mut desc = MaterialDesc {
        name: material.name.clone(),
        emission: material.emissive.map_or(Vec3::ZERO, Vec3::from),
        ..defaults
    };
    let specular = material.specular.map_or(Vec3::ZERO, Vec3::from);
    let s = specular.max_element();
    let is_mirror = illumination == 3 && s > 0.0;
    desc.albedo = match material.diffuse {
        Some(diffuse) => Vec3::from(diffuse),
        None if texture.is_some() => Vec3::ONE,
        None if is_mirror => Vec3::ZERO,
        None => desc.albedo,
    };
    desc.texture = texture;
    if is_mirror {
        // A blend picks one of the two parts, so each is scaled up by the share it gets.
        let d = desc.albedo.max_element();
        if d + s > 1.0 {
            warn("illum 3: Kd and Ks together reflect more than arrives; scaled down".into());
        }
        desc.mirror = s / (d + s);
        desc.mirror_color = (specular / desc.mirror).min(Vec3::ONE);
        if d > 0.0 {
            desc.albedo = (desc.albedo / (1.0 - desc.mirror)).min(Vec3::ONE);
        }
    }
    // Glass of the models "transparency: glass", "refraction" and "refraction with Fresnel".
    if matches!(illumination, 4 | 6 | 7) {
        let ior = material.optical_density.unwrap_or(DEFAULT_IOR);
        let plausible = (1.0..=5.0).contains(&ior);
        if !plausible {
            warn(format!(
                "Ni: an index of refraction is between 1 and 5; taken as {DEFAULT_IOR}"
            ));
        }
        desc.glass = Some(if plausible { ior } else { DEFAULT_IOR });
    }
    desc
}
