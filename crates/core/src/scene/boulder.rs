//! A rock made on demand: the large mesh that no file needs to store.
//!
//! A subdivided icosahedron is blown up to a sphere, cut by fracture planes and roughened by
//! octaves of noise. Every vertex is a pure function of its direction from the centre, so the
//! surface has no seam, cannot meet itself and is the same on every machine and thread count.

use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;

/// Corners of an icosahedron, up to scale; ±φ, ±1 and 0 in each cyclic order.
const CORNERS: [[f32; 3]; 12] = {
    const PHI: f32 = 1.618_034;
    [
        [-1.0, PHI, 0.0],
        [1.0, PHI, 0.0],
        [-1.0, -PHI, 0.0],
        [1.0, -PHI, 0.0],
        [0.0, -1.0, PHI],
        [0.0, 1.0, PHI],
        [0.0, -1.0, -PHI],
        [0.0, 1.0, -PHI],
        [PHI, 0.0, -1.0],
        [PHI, 0.0, 1.0],
        [-PHI, 0.0, -1.0],
        [-PHI, 0.0, 1.0],
    ]
};

/// Its faces, counter-clockwise seen from outside.
const FACES: [[u32; 3]; 20] = [
    [0, 11, 5],
    [0, 5, 1],
    [0, 1, 7],
    [0, 7, 10],
    [0, 10, 11],
    [1, 5, 9],
    [5, 11, 4],
    [11, 10, 2],
    [10, 7, 6],
    [7, 1, 8],
    [3, 9, 4],
    [3, 4, 2],
    [3, 2, 6],
    [3, 6, 8],
    [3, 8, 9],
    [4, 9, 5],
    [2, 4, 11],
    [6, 2, 10],
    [8, 6, 7],
    [9, 8, 1],
];

/// Distances from the centre between which the fracture planes lie; uncut, the rock is the unit
/// sphere.
const FRACTURE_DEPTHS: (f32, f32) = (0.6, 0.95);
/// Distance of the plane that the rock rests on.
const BASE_DEPTH: f32 = 0.55;
/// Width over which the edge between two fractures is worn round.
const WEAR: f32 = 0.05;
/// Amplitude of the first octave of noise; each further one halves it and doubles the frequency.
const ROUGHNESS: f32 = 0.1;
/// Waves per unit length in the first octave.
const COARSEST: f32 = 1.7;

/// A closed, manifold, outward-facing mesh of a rock of about unit radius, lying on a broad side
/// at the bottom (its lowest point near y = −0.57): its vertices and its triangles, with vertices shared.
///
/// It has 20·n² triangles, with the n ≥ 1 that comes nearest to `triangles`. A finer mesh shows
/// the same rock with more octaves of detail, down to the length of its own edges.
pub fn boulder(triangles: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let n = (f64::from(triangles) / 20.0).sqrt().round().max(1.0) as u32;
    let sphere = Icosphere::new(n);
    let rock = Rock::new(n);
    let positions = sphere
        .directions()
        .map(|direction| rock.surface(direction))
        .collect();
    (positions, sphere.triangles().collect())
}

/// An icosahedron whose edges are cut into `n`, numbered corners first, then the inner vertices of
/// the edges, then those of the faces.
///
/// On a face `[a, b, c]`, vertex `(i, j)` with `0 ≤ j ≤ i ≤ n` is the j-th of row i, the rows
/// running from a at 0 to the edge from b to c at n.
struct Icosphere {
    n: u32,
    /// Corners of each edge, the smaller first.
    edges: Vec<[u32; 2]>,
}

impl Icosphere {
    fn new(n: u32) -> Self {
        let sides = FACES.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let edges = sides.filter(|[from, to]| from < to).collect();
        Self { n, edges }
    }

    /// The unit vectors to all vertices, in order.
    fn directions(&self) -> impl ParallelIterator<Item = Vec3> {
        let n = self.n;
        let corners = CORNERS.into_par_iter().map(Vec3::from);
        let edges = (0..30 * (n - 1)).into_par_iter().map(move |id| {
            let ([a, b], step) = (self.edges[(id / (n - 1)) as usize], id % (n - 1) + 1);
            corner(a) * (n - step) as f32 + corner(b) * step as f32
        });
        let faces = (0..20 * n).into_par_iter().flat_map_iter(move |id| {
            let ([a, b, c], i) = (FACES[(id / n) as usize], id % n);
            (1..i).map(move |j| {
                corner(a) * (n - i) as f32 + corner(b) * (i - j) as f32 + corner(c) * j as f32
            })
        });
        corners.chain(edges).chain(faces).map(Vec3::normalize)
    }

    /// All triangles, counter-clockwise seen from outside.
    fn triangles(&self) -> impl ParallelIterator<Item = [u32; 3]> {
        (0..20 * self.n).into_par_iter().flat_map_iter(move |id| {
            let (face, i) = (id / self.n, id % self.n);
            let at = move |i, j| self.vertex(face, i, j);
            let upright = (0..=i).map(move |j| [at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            let inverted = (0..i).map(move |j| [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            upright.chain(inverted)
        })
    }

    /// The number of vertex `(i, j)` of a face.
    fn vertex(&self, face: u32, i: u32, j: u32) -> u32 {
        let (n, [a, b, c]) = (self.n, FACES[face as usize]);
        match (i, j) {
            (0, 0) => a,
            (i, 0) if i == n => b,
            (i, j) if i == n && j == n => c,
            (i, 0) => self.edge_vertex(a, b, i),
            (i, j) if i == j => self.edge_vertex(a, c, i),
            (i, j) if i == n => self.edge_vertex(b, c, j),
            (i, j) => {
                let per_face = (n - 1) * (n - 2) / 2;
                12 + 30 * (n - 1) + face * per_face + (i - 1) * (i - 2) / 2 + j - 1
            }
        }
    }

    /// The number of the vertex `step` steps along the edge between two corners.
    fn edge_vertex(&self, from: u32, to: u32, step: u32) -> u32 {
        let (ends, step) = if from < to {
            ([from, to], step)
        } else {
            ([to, from], self.n - step)
        };
        let edge = self.edges.iter().take_while(|&&edge| edge != ends).count() as u32;
        12 + edge * (self.n - 1) + step - 1
    }
}

fn corner(id: u32) -> Vec3 {
    CORNERS[id as usize].into()
}

/// The rock's shape: how far its surface is from the centre in each direction.
struct Rock {
    /// Unit normal and distance of each fracture plane.
    planes: Vec<(Vec3, f32)>,
    octaves: u32,
}

impl Rock {
    /// The rock with the octaves that edges of length about 1/`n` can show.
    fn new(n: u32) -> Self {
        let (nearest, farthest) = FRACTURE_DEPTHS;
        // One plane for every face of the icosahedron, tilted at random.
        let fractures = FACES.iter().zip(0..).map(|([a, b, c], id)| {
            let random = hash(UVec3::new(id, 0, u32::MAX));
            let normal = (corner(*a) + corner(*b) + corner(*c)).normalize() + 0.5 * random;
            let depth = hash(UVec3::new(id, 1, u32::MAX)).x * 0.5 + 0.5;
            (normal.normalize(), nearest + (farthest - nearest) * depth)
        });
        let planes = fractures.chain([(Vec3::NEG_Y, BASE_DEPTH)]).collect();
        // At least two edges to a wave: COARSEST · 2^k ≤ n/2 for the last octave k.
        let octaves = (n as f32 / (2.0 * COARSEST)).max(1.0) as u32;
        Self {
            planes,
            octaves: octaves.ilog2() + 1,
        }
    }

    /// The point of the surface in a direction (a unit vector).
    fn surface(&self, direction: Vec3) -> Vec3 {
        let mut radius = 1.0;
        for &(normal, depth) in &self.planes {
            let cosine = normal.dot(direction);
            if cosine > 0.0 {
                radius = smooth_min(radius, depth / cosine);
            }
        }
        let chipped = direction * radius;
        let (mut amplitude, mut frequency) = (ROUGHNESS, COARSEST);
        for octave in 0..self.octaves {
            radius += amplitude * gradient_noise(chipped * frequency, octave);
            amplitude *= 0.5;
            frequency *= 2.0;
        }
        direction * radius
    }
}

/// The smaller of two values, rounded off over [`WEAR`] (quadratic polynomial, Quilez 2013).
fn smooth_min(a: f32, b: f32) -> f32 {
    let overlap = (WEAR - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * WEAR)
}

/// Gradient noise (Perlin 2002), about in −1..1, with one wave to a unit; twice differentiable.
fn gradient_noise(p: Vec3, octave: u32) -> f32 {
    let cell = p.floor();
    let offset = p - cell;
    let fade = offset * offset * offset * (offset * (offset * 6.0 - 15.0) + 10.0);
    let at = |x: i32, y: i32, z: i32| {
        let corner = IVec3::new(x, y, z);
        // Negative coordinates wrap round; each octave has a lattice of its own.
        let lattice = (cell.as_ivec3() + corner).as_uvec3() ^ UVec3::splat(octave << 24);
        hash(lattice).dot(offset - corner.as_vec3())
    };
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let along_x = |y, z| lerp(at(0, y, z), at(1, y, z), fade.x);
    let along_y = |z| lerp(along_x(0, z), along_x(1, z), fade.y);
    lerp(along_y(0), along_y(1), fade.z)
}

/// Three numbers in −1..1 from three integers: the generator pcg3d of Jarzynski & Olano 2020,
/// "Hash Functions for GPU Rendering".
fn hash(seed: UVec3) -> Vec3 {
    let mut v =
        [seed.x, seed.y, seed.z].map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[2]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        if round == 0 {
            v = v.map(|x| x ^ (x >> 16));
        }
    }
    v.map(|x| (x >> 8) as f32 * (2.0 / (1 << 24) as f32) - 1.0)
        .into()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    const SIZES: [u32; 7] = [1, 20, 80, 180, 1000, 20_000, 50_000];

    #[test]
    fn is_closed_with_manifold_edges_and_no_holes() {
        for size in SIZES {
            let (positions, triangles) = boulder(size);
            let sides = triangles
                .iter()
                .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
            let mut edges = HashSet::new();
            for side in sides {
                assert!(
                    edges.insert(side),
                    "size {size}: {side:?} runs the same way twice"
                );
            }
            assert!(
                edges.iter().all(|&(a, b)| edges.contains(&(b, a))),
                "size {size}: a border"
            );
            // One vertex too many, left out or pinched would show here.
            let euler = (positions.len() + triangles.len()) as i64 - edges.len() as i64 / 2;
            assert_eq!(euler, 2, "size {size}");
            let used: HashSet<u32> = triangles.iter().flatten().copied().collect();
            assert_eq!(used.len(), positions.len(), "size {size}");
        }
    }

    #[test]
    fn every_triangle_faces_away_from_the_centre() {
        for size in SIZES {
            let (positions, triangles) = boulder(size);
            for t in triangles {
                let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3());
                assert!(a.dot(b.cross(c)) > 0.0, "size {size}, triangle {t:?}");
            }
        }
    }

    #[test]
    fn has_about_as_many_triangles_as_asked_for() {
        for size in [20, 80, 1000, 5000, 123_456, 1_000_000] {
            let count = boulder(size).1.len() as f64;
            // Between two subdivisions n and n + 1 the nearer is at most a share 1/n away.
            let share = (20.0 / f64::from(size)).sqrt();
            assert!(
                (count / f64::from(size) - 1.0).abs() <= share,
                "{size}: {count}"
            );
        }
    }

    #[test]
    fn stays_near_the_unit_ball_and_lies_where_documented() {
        let (positions, _) = boulder(50_000);
        let radii = positions.iter().map(|p| p.length());
        assert!(radii.clone().all(|r| (0.4..=1.1).contains(&r)));
        let lowest = positions.iter().map(|p| p.y).fold(f32::MAX, f32::min);
        assert!((lowest + 0.57).abs() < 0.02, "lowest at {lowest}");
        assert!(radii.fold(0.0, f32::max) > 0.8);
    }

    #[test]
    fn is_the_same_at_any_thread_count() {
        let bits = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let (positions, triangles) = pool.install(|| boulder(30_000));
            let positions: Vec<_> = positions
                .iter()
                .map(|p| p.to_array().map(f32::to_bits))
                .collect();
            (positions, triangles)
        };
        assert!(bits(1) == bits(4));
    }
}
