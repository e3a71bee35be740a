//! Makes the project's own teddy, `scenes/meshes/teddy.obj`: an implicit bear, meshed by marching
//! tetrahedra, reduced to well-shaped triangles and written as OBJ. The same bytes on every
//! machine.
//!
//! `cargo run --release -p lightbox-core --example make_teddy -- scenes/meshes/teddy.obj`
//! (without a path, to standard output).

mod bear;
mod implicit;
mod march;
mod mesh;
mod remesh;

use std::fmt::Write;

use glam::DVec3;

/// Triangles of the teddy.
const TRIANGLES: usize = 3200;

fn main() -> std::io::Result<()> {
    let obj = teddy_obj();
    match std::env::args_os().nth(1) {
        Some(path) => std::fs::write(path, obj),
        None => {
            print!("{obj}");
            Ok(())
        }
    }
}

/// The teddy as OBJ text: 1 unit tall, standing on y = 0, centred in x and z, looking along +z.
pub fn teddy_obj() -> String {
    let solid = bear::bear();
    let mut mesh = march::march(&solid, DVec3::new(0.0, 0.5, 0.05), 0.55, 48);
    remesh::remesh(&mut mesh, &solid, TRIANGLES);

    let low = mesh.positions.iter().copied().fold(DVec3::MAX, DVec3::min);
    let high = mesh.positions.iter().copied().fold(DVec3::MIN, DVec3::max);
    let middle = low.midpoint(high).with_y(low.y);
    let scale = 1.0 / (high.y - low.y);

    let mut obj = String::from(
        "# The lightbox teddy: an implicit surface made and meshed by this project,\n\
         # crates/core/examples/make_teddy. Closed, outward, 1 unit tall, looking along +z.\n",
    );
    for &position in &mesh.positions {
        let p = (position - middle) * scale;
        // Adding zero turns −0 into 0. Writing to a string cannot fail.
        let _ = writeln!(obj, "v {:.6} {:.6} {:.6}", p.x + 0.0, p.y + 0.0, p.z + 0.0);
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v + 1)) {
        let _ = writeln!(obj, "f {a} {b} {c}");
    }
    obj
}
