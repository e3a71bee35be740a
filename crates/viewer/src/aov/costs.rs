//! What rays and paths cost, counted by some that are cast for nothing else.

use lightbox_core::View;
use lightbox_core::film::TileRect;
use lightbox_core::render::autopsy::LENGTHS;

use super::colors::{log_share, viridis};
use super::{Colors, Legend, Scope};
use crate::panels::format::{count, counted, short};

/// Steps at the ends of their scale: the same for every scene, so that trees can be compared.
const STEPS: [f32; 2] = [1.0, 1000.0];

/// Paths that are followed in each pixel.
const PATHS: u32 = 16;

pub fn traversal(_: &Scope<'_>, view: &View, rect: TileRect) -> Colors {
    let traversals = view.traversals(rect).into_iter();
    let steps = traversals.map(|t| t.steps() as f32);
    steps.map(|n| viridis(log_share(n, STEPS))).collect()
}

pub fn traversal_legend() -> Legend {
    let [low, high] = STEPS.map(|n| count(n as u64));
    Legend::Scale {
        color: viridis,
        ends: [low, format!("{high} nodes and shapes")],
    }
}

pub fn traversal_reading(view: &View, pixel: [u32; 2]) -> String {
    let only = view.traversals(one(pixel)).pop().unwrap_or_default();
    let [nodes, tests] = [only.nodes, only.tests].map(u64::from);
    format!("{}, {}", counted(nodes, "node"), counted(tests, "shape"))
}

pub fn path_length(scope: &Scope<'_>, view: &View, rect: TileRect) -> Colors {
    let ends = lengths(scope);
    let means = view.path_lengths(rect, PATHS).into_iter();
    means.map(|n| viridis(log_share(n, ends))).collect()
}

/// From light that is seen directly to paths of the full depth.
fn lengths(scope: &Scope<'_>) -> [f32; 2] {
    [1.0, scope.settings.depth.clamp(2, LENGTHS as u32) as f32]
}

pub fn path_length_legend(scope: &Scope<'_>) -> Legend {
    let [low, high] = lengths(scope).map(|n| count(n as u64));
    let more = match scope.settings.depth {
        depth if depth > LENGTHS as u32 => " or more",
        _ => "",
    };
    Legend::Scale {
        color: viridis,
        ends: [low, format!("{high}{more} segments")],
    }
}

pub fn path_length_reading(view: &View, pixel: [u32; 2]) -> String {
    let mean = view.path_lengths(one(pixel), PATHS).pop();
    let mean = short(mean.unwrap_or_default());
    format!("path length {mean}")
}

fn one([x, y]: [u32; 2]) -> TileRect {
    let (width, height) = (1, 1);
    TileRect {
        x,
        y,
        width,
        height,
    }
}
