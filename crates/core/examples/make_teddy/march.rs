//! Marching tetrahedra (Doi & Koide 1991): a closed manifold mesh of a solid from a grid of
//! samples. Each cell is cut into six tetrahedra about its diagonal (Kuhn 1960), alike in every
//! cell, so that neighbours agree on the faces between them and no case is ambiguous.

use std::collections::BTreeMap;

use glam::{DVec3, IVec3};

use super::{implicit::Solid, mesh::Mesh};

/// The steps that lead from a cell's first corner to its last, one tetrahedron each.
const PATHS: [[IVec3; 3]; 6] = [
    [IVec3::X, IVec3::Y, IVec3::Z],
    [IVec3::X, IVec3::Z, IVec3::Y],
    [IVec3::Y, IVec3::Z, IVec3::X],
    [IVec3::Y, IVec3::X, IVec3::Z],
    [IVec3::Z, IVec3::X, IVec3::Y],
    [IVec3::Z, IVec3::Y, IVec3::X],
];

/// Meshes the surface of `solid` inside the cube of the given centre and half-width, cut into
/// `cells`³ cells.
pub fn march(solid: &Solid, center: DVec3, half_width: f64, cells: i32) -> Mesh {
    let spacing = 2.0 * half_width / f64::from(cells);
    let position = |corner: IVec3| center - half_width + corner.as_dvec3() * spacing;
    let index = |c: IVec3| ((c.z * (cells + 1) + c.y) * (cells + 1) + c.x) as usize;
    let values: Vec<f64> = grid(cells + 1)
        .map(|corner| solid.sample(position(corner)).value)
        .collect();

    let mut mesh = Mesh {
        positions: Vec::new(),
        triangles: Vec::new(),
    };
    // One vertex on each grid edge that crosses the surface, shared by all tetrahedra around it.
    let mut crossings = BTreeMap::new();
    let mut crossing = |inside: IVec3, outside: IVec3| {
        let (i, o) = (index(inside), index(outside));
        *crossings.entry((i, o)).or_insert_with(|| {
            let t = values[i] / (values[i] - values[o]);
            mesh.positions
                .push(position(inside).lerp(position(outside), t));
            mesh.positions.len() - 1
        })
    };
    for cell in grid(cells) {
        for [first, second, third] in PATHS {
            let mut corners = [cell; 4];
            corners[1] += first;
            corners[2] = corners[1] + second;
            corners[3] = corners[2] + third;
            let is_outside = |corner: &IVec3| values[index(*corner)] >= 0.0;
            let outside = corners.iter().filter(|corner| is_outside(corner)).count();
            corners.sort_by_key(is_outside);
            let [a, b, c, d] = corners;
            let right_handed = (b - a).cross(c - a).dot(d - a) > 0;
            let mut emit = |[p, q, r]: [usize; 3]| {
                mesh.triangles
                    .push(if right_handed { [p, q, r] } else { [p, r, q] });
            };
            match outside {
                1 => emit([crossing(a, d), crossing(b, d), crossing(c, d)]),
                2 => {
                    let (start, end) = (crossing(a, c), crossing(b, d));
                    emit([start, crossing(a, d), end]);
                    emit([start, end, crossing(b, c)]);
                }
                3 => emit([crossing(a, b), crossing(a, c), crossing(a, d)]),
                _ => {}
            }
        }
    }
    mesh
}

/// The points of a cubic grid with `count` on a side, x fastest.
fn grid(count: i32) -> impl Iterator<Item = IVec3> {
    (0..count).flat_map(move |z| {
        (0..count).flat_map(move |y| (0..count).map(move |x| IVec3::new(x, y, z)))
    })
}
