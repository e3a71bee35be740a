//! What the camera sees first.

use lightbox_core::color::srgb_from_linear;
use lightbox_core::surfaces::Surface;

use super::colors::{distinct, viridis};
use super::{Legend, Scope};
use crate::panels::format::length;

/// Most things that a legend names.
const NAMED: usize = 12;

/// Fronts and backs, as Blender shows them.
const SIDES: [[u8; 3]; 2] = [[60, 110, 230], [225, 60, 50]];

pub fn depth(scope: &Scope<'_>, surface: &Surface) -> [u8; 3] {
    let [near, far] = scope.distances;
    viridis(1.0 - (surface.distance - near) / (far - near))
}

pub fn depth_legend(scope: &Scope<'_>) -> Legend {
    let [near, far] = scope.distances.map(length);
    Legend::Scale {
        color: |share| viridis(1.0 - share),
        ends: [near, format!("{far} scene units")],
    }
}

pub fn normal(_: &Scope<'_>, surface: &Surface) -> [u8; 3] {
    let shown = surface.normal * 127.5 + 127.5;
    shown.to_array().map(|x| x.round() as u8)
}

pub fn normal_legend() -> Legend {
    let axes = ["x", "y", "z"].into_iter().enumerate();
    let ends = axes.flat_map(|(axis, name)| {
        [("+", 255), ("−", 0)].map(|(sign, end)| {
            let mut color = [128; 3];
            color[axis] = end;
            (color, format!("{sign}{name}"))
        })
    });
    Legend::Swatches(ends.collect())
}

pub fn facing(_: &Scope<'_>, surface: &Surface) -> [u8; 3] {
    SIDES[usize::from(!surface.is_front)]
}

pub fn facing_legend() -> Legend {
    let names = ["front", "back"].map(String::from);
    Legend::Swatches(SIDES.into_iter().zip(names).collect())
}

pub fn albedo(surface: &Surface) -> [u8; 3] {
    surface.albedo.to_array().map(srgb_from_linear)
}

pub fn object(scope: &Scope<'_>, surface: &Surface) -> [u8; 3] {
    // Objects stand in the order of their slots.
    let slot = scope.scene.object(surface.prim).first_slot;
    let objects = scope.scene.objects();
    distinct(objects.partition_point(|o| o.first_slot < slot) as u64)
}

pub fn object_legend(scope: &Scope<'_>) -> Legend {
    let names = scope.scene.objects().iter().map(|o| o.label.clone());
    named(names.zip(0..).map(|(name, i)| (distinct(i), name)))
}

pub fn material(scope: &Scope<'_>, surface: &Surface) -> [u8; 3] {
    let slot = scope.scene.slot(surface.prim);
    distinct(u64::from(scope.first_slots()[slot as usize]))
}

pub fn material_legend(scope: &Scope<'_>) -> Legend {
    let slots = scope.first_slots().iter().zip(0..);
    let firsts = slots.filter(|(first, slot)| *first == slot);
    let names = scope.scene.material_names();
    named(firsts.map(|(_, slot)| (distinct(u64::from(slot)), names[slot as usize].clone())))
}

/// As many as there is room for.
fn named(mut all: impl Iterator<Item = ([u8; 3], String)>) -> Legend {
    let mut named: Vec<_> = all.by_ref().take(NAMED).collect();
    let more = all.count();
    if more > 0 {
        named.push(([0; 3], format!("and {more} more")));
    }
    Legend::Swatches(named)
}
