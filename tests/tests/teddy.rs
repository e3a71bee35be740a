//! The project's own teddy is a closed manifold surface of genus 0, the size the scenes expect,
//! and the very file that its generator writes.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

#[path = "../../crates/core/examples/make_teddy/main.rs"]
#[expect(dead_code, reason = "the test calls what main calls")]
mod make_teddy;

/// Smallest angle that a triangle may have, degrees: any thinner is a sliver.
const MIN_ANGLE: f64 = 10.0;

struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

fn committed() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/meshes/teddy.obj");
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Reads `v x y z` and `f a b c` lines; the teddy has no others but comments.
fn teddy() -> Mesh {
    let mut mesh = Mesh {
        positions: Vec::new(),
        triangles: Vec::new(),
    };
    for line in committed().lines().filter(|line| !line.starts_with('#')) {
        match *line.split_whitespace().collect::<Vec<_>>() {
            ["v", x, y, z] => {
                let position = [x, y, z].map(|s| s.parse().expect(line));
                mesh.positions.push(position.into());
            }
            ["f", a, b, c] => {
                let corner = |s: &str| s.parse::<usize>().expect(line) - 1;
                mesh.triangles.push([a, b, c].map(corner));
            }
            _ => panic!("unexpected line {line:?}"),
        }
    }
    mesh
}

/// The directed edges of a triangle.
fn edges([a, b, c]: [usize; 3]) -> [(usize, usize); 3] {
    [(a, b), (b, c), (c, a)]
}

#[test]
fn has_about_three_thousand_triangles() {
    let count = teddy().triangles.len();
    assert!((2800..=3400).contains(&count), "{count} triangles");
}

#[test]
fn every_edge_joins_two_triangles_of_one_orientation() {
    let mesh = teddy();
    let mut seen = BTreeSet::new();
    for edge in mesh.triangles.iter().copied().flat_map(edges) {
        assert!(seen.insert(edge), "{edge:?} runs the same way twice");
    }
    for &(a, b) in &seen {
        assert!(seen.contains(&(b, a)), "({a}, {b}) is a border");
    }
}

#[test]
fn the_triangles_around_every_vertex_form_one_cycle() {
    let mesh = teddy();
    // Around each vertex, the edge opposite to it in each triangle leads to the next triangle.
    let mut links = vec![BTreeMap::new(); mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        for (vertex, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            links[vertex].insert(from, to);
        }
    }
    for (vertex, link) in links.iter().enumerate() {
        let (&start, _) = link.first_key_value().expect("a vertex without triangles");
        let mut at = start;
        for step in 1..=link.len() {
            at = *link.get(&at).expect("an open fan");
            assert_eq!(at == start, step == link.len(), "fan of vertex {vertex}");
        }
    }
}

#[test]
fn is_one_piece_without_holes() {
    let mesh = teddy();
    let edges = mesh.triangles.iter().copied().flat_map(edges);
    let mut neighbors = vec![Vec::new(); mesh.positions.len()];
    edges.for_each(|(a, b)| neighbors[a].push(b));

    let mut reached = BTreeSet::from([0]);
    let mut open = vec![0];
    while let Some(vertex) = open.pop() {
        open.extend(neighbors[vertex].iter().filter(|&&v| reached.insert(v)));
    }
    assert_eq!(reached.len(), mesh.positions.len(), "vertices in one piece");

    let directed_edges = 3 * mesh.triangles.len();
    let euler = (mesh.positions.len() + mesh.triangles.len()) as i64 - directed_edges as i64 / 2;
    assert_eq!(euler, 2, "Euler characteristic");
}

#[test]
fn faces_outward() {
    let mesh = teddy();
    let six_volumes = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| mesh.positions[v]);
        a.dot(b.cross(c))
    });
    let volume = six_volumes.sum::<f64>() / 6.0;
    let size = extent(&mesh);
    assert!(
        volume > 0.1 * size.element_product(),
        "signed volume {volume}"
    );
}

#[test]
fn has_no_slivers() {
    let mesh = teddy();
    for (id, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        for (at, next, last) in [(a, b, c), (b, c, a), (c, a, b)] {
            let [p, q, r] = [at, next, last].map(|v| mesh.positions[v]);
            let angle = (q - p).angle_between(r - p).to_degrees();
            // A zero-area triangle gives 0 or NaN, and neither passes.
            assert!(angle >= MIN_ANGLE, "triangle {id} has an angle of {angle}°");
        }
    }
}

#[test]
fn stands_on_the_ground_one_unit_tall_and_centred() {
    let mesh = teddy();
    let low = mesh.positions.iter().copied().reduce(DVec3::min).unwrap();
    assert_eq!(low.y, 0.0);
    assert_eq!(extent(&mesh).y, 1.0);
    let middle = low + 0.5 * extent(&mesh);
    let digit = 1e-6;
    assert!(
        middle.x.abs() <= digit && middle.z.abs() <= digit,
        "{middle}"
    );
}

#[test]
fn is_the_file_that_its_generator_writes() {
    assert!(
        make_teddy::teddy_obj() == committed(),
        "run the example make_teddy again and commit its output"
    );
}

fn extent(mesh: &Mesh) -> DVec3 {
    let low = mesh.positions.iter().copied().reduce(DVec3::min);
    let high = mesh.positions.iter().copied().reduce(DVec3::max);
    high.expect("a vertex") - low.expect("a vertex")
}
