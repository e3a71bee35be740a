//! Turns a fine, ragged mesh of a solid into a given number of well-shaped triangles, smaller
//! where the surface bends more.

use glam::DVec3;

use super::implicit::Solid;
use super::mesh::{Fans, Mesh};

/// Curvatures (1/length) beyond which triangles grow no larger and no smaller.
const CURVATURE_RANGE: (f64, f64) = (6.0, 90.0);
/// Largest ratio of the edge lengths wanted at neighbours, and over how many edges it holds.
const GRADING: f64 = 1.25;
const GRADING_ROUNDS: usize = 5;
/// Rounds of flips and relaxation on the final triangles.
const POLISH_ROUNDS: usize = 60;

/// Reduces the mesh to `target` triangles (an even number, as on every closed mesh).
pub fn remesh(mesh: &mut Mesh, solid: &Solid, target: usize) {
    while mesh.triangles.len() > target {
        let sizes = edge_lengths(mesh, solid);
        // A few at a time, so that edges stay even; each takes two triangles away.
        let surplus = (mesh.triangles.len() - target) / 2;
        let budget = surplus.min(mesh.triangles.len() / 8);
        let collapsed = mesh.collapse(solid, &sizes, budget);
        assert!(collapsed > 0, "no edge can be collapsed any more");
        mesh.flip(solid);
        relax(mesh, solid, 0.5);
    }
    for _ in 0..POLISH_ROUNDS {
        mesh.flip(solid);
        relax(mesh, solid, 0.8);
    }
}

/// The edge length wanted at each vertex, up to a common factor: the radius of curvature to the
/// power ¾. The power ½ would hold the distance of the triangles from the surface the same
/// everywhere and 1 the angle between neighbours; the eye sees both.
fn edge_lengths(mesh: &Mesh, solid: &Solid) -> Vec<f64> {
    let fans = Fans::of(mesh);
    let (flattest, sharpest) = CURVATURE_RANGE;
    let length = |&p: &DVec3| {
        let root = (1.0 / solid.curvature(p).clamp(flattest, sharpest)).sqrt();
        root * root.sqrt()
    };
    let mut sizes: Vec<f64> = mesh.positions.iter().map(length).collect();
    // Neighbouring sizes must not jump, or no well-shaped triangle fits between them.
    for _ in 0..GRADING_ROUNDS {
        let graded = |v| {
            let limits = mesh.neighbors(&fans, v).map(|n| GRADING * sizes[n]);
            limits.fold(sizes[v], f64::min)
        };
        sizes = (0..sizes.len()).map(graded).collect();
    }
    sizes
}

/// Moves each vertex by `step` of the way towards the centroid of the triangles around it,
/// weighted by the density 1/size⁴ that makes triangles come out `size` wide (Du, Faber &
/// Gunzburger 1999, on centroidal Voronoi tessellations), and back onto the surface.
fn relax(mesh: &mut Mesh, solid: &Solid, step: f64) {
    let sizes = edge_lengths(mesh, solid);
    let mut sums = vec![(DVec3::ZERO, 0.0); mesh.positions.len()];
    for &triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(triangle);
        let size = triangle.iter().map(|&v| sizes[v]).sum::<f64>();
        let weight = (b - a).cross(c - a).length() / (size * size * size * size);
        let centroid = (a + b + c) / 3.0;
        for v in triangle {
            sums[v].0 += centroid * weight;
            sums[v].1 += weight;
        }
    }
    for (position, (sum, weight)) in mesh.positions.iter_mut().zip(sums) {
        *position = solid.project(position.lerp(sum / weight, step));
    }
}
