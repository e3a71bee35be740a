//! Texts of MTL files, and meshes whose materials are missing.

use super::Figure;
use super::meshes::Outcome::Loads;
use super::meshes::{are_as_told, astray, figure};
use crate::scene::obj;

/// What must come of a material: its albedo and the warning as of a mesh, or a part of the error.
type Albedo = Result<([f32; 3], &'static str), &'static str>;

/// MTL texts after `newmtl a` that come out otherwise.
fn materials_astray(table: &[(&str, Albedo)]) -> f64 {
    let wrong = |(text, outcome): &&(&str, Albedo)| match (
        obj::materials(&format!("newmtl a\n{text}\n")),
        outcome,
    ) {
        (Ok((materials, warnings)), Ok((albedo, warning))) => {
            materials.first().map(|m| m.albedo.to_array()) != Some(*albedo)
                || !are_as_told(&warnings, warning)
        }
        (Err(e), Err(part)) => e.line != Some(2) || !e.message.contains(part),
        _ => true,
    };
    table.iter().filter(wrong).count() as f64
}

pub(super) fn colors() -> Vec<Figure> {
    let table = [
        ("Kd 0.5", Ok(([0.5; 3], ""))),
        ("Kd .1 .2 .3", Ok(([0.1, 0.2, 0.3], ""))),
        ("kd .1 .2 .3 .4 # blue", Ok(([0.1, 0.2, 0.3], ""))),
        ("Kd", Err("one or three numbers, here are 0")),
        ("Kd .1 .2", Err("one or three numbers, here are 2")),
        ("Ks 0,5", Err("decimal point")),
    ];
    vec![figure(
        "material texts of 6 with another outcome",
        None,
        materials_astray(&table),
    )]
}

pub(super) fn missing() -> Vec<Figure> {
    let table = [
        (
            "usemtl zzz\nf 1 2 3\nusemtl zzz",
            Loads(0.5, "no material \"zzz\""),
        ),
        (
            "mtllib no such.mtl\nf 1 2 3",
            Loads(0.5, "no material library \"no such.mtl\""),
        ),
        ("usemtl\nf 1 2 3", Loads(0.5, "usemtl names no material")),
    ];
    let default = crate::scene::MaterialDesc::default().albedo.to_array();
    let materials = [
        (
            "Kd spectral file.rfl 1",
            Ok((default, "Kd: spectral and xyz")),
        ),
        ("Kd xyz .1 .2 .3", Ok((default, "Kd: spectral and xyz"))),
        (
            "map_Kd no such.png",
            Ok((default, "no texture \"no such.png\"")),
        ),
        ("map_Kd", Ok((default, "map_Kd: names no file"))),
        (
            "illum many\nillum 256",
            Ok((default, "illum: the illumination model")),
        ),
        ("Pr 0.5\nd 1\nTf 1\n\\\nmap_Bump", Ok((default, ""))),
    ];
    vec![figure(
        "texts of 9 with another outcome",
        None,
        astray(&table) + materials_astray(&materials),
    )]
}

pub(super) fn impossible() -> Vec<Figure> {
    let table = [
        ("Kd nan 2 -1", Err("finite")),
        ("Kd .1 .2 inf", Err("finite")),
        ("Ke inf", Err("finite")),
        ("Ni nan", Err("finite")),
        ("Ni", Err("not a number")),
        ("newmtl ", Err("no name")),
        (
            "Kd 2 -1 .5",
            Ok(([1.0, 0.0, 0.5], "Kd: values are clamped to 0 … 1 (2 times)")),
        ),
        ("Kd .5 .5 .5\nNi 0", Ok(([0.5; 3], ""))),
    ];
    vec![figure(
        "material texts of 8 with another outcome",
        None,
        materials_astray(&table),
    )]
}
