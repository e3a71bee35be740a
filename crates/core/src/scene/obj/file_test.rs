//! Files that name others: OBJ, MTL and textures.

use std::path::PathBuf;

use glam::Vec3;

use super::load;
use super::test::{SQUARE, assert_readable, assert_sound, warnings};
use crate::scene::desc::MaterialDesc;

/// A folder that is gone after the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lightbox-obj-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Nothing depends on it.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn files_are_found_beside_the_one_that_names_them() {
    let folder = Folder::new("found");
    let texture = folder.write("wood grain.png", "");
    let named = "newmtl wood\nmap_Kd -s 1 1 1 -o 0 wood grain.png\n\
                 newmtl moved wood\nKd .5\nmap_Kd -bm 2 -clamp on C:\\art\\wood grain.png\n\
                 newmtl lost\nmap_Kd gone.png";
    folder.write("my colours.mtl", named);
    folder.write("more.mtl", "newmtl lamp\nKe 5");
    let text = format!(
        "mtllib\tmy colours.mtl\nmtllib my colours.mtl\nmtllib gone.mtl ./more.mtl\n{SQUARE}f 1 2 3\n\
         usemtl  moved wood\nf 1 2 3\nusemtl lamp \nf 1 2 3\nusemtl wood\nf 1 2 3\nusemtl lost\nf 1 2 3"
    );
    let mesh = load(&folder.write("a.obj", &text)).unwrap();
    assert_sound(&mesh);
    assert_eq!(mesh.triangle_materials, [u32::MAX, 1, 3, 0, 2]);
    let [wood, moved, lost, lamp] = mesh.materials.as_slice() else {
        panic!("{:?}", mesh.materials)
    };
    assert_eq!(
        (wood.texture.as_ref(), wood.albedo),
        (Some(&texture), Vec3::ONE)
    );
    assert_eq!(
        (moved.texture.as_ref(), moved.albedo),
        (Some(&texture), Vec3::splat(0.5))
    );
    assert_eq!(
        (lost.texture.as_ref(), lost.albedo),
        (None, MaterialDesc::default().albedo)
    );
    assert_eq!(lamp.emission, Vec3::splat(5.0));
    let warned = warnings(&mesh);
    assert_eq!(warned.len(), 3, "{warned:?}");
    assert!(
        warned[0].starts_with("5×1 map_Kd: texture options"),
        "{warned:?}"
    );
    assert!(
        warned[1].starts_with("6×1 no texture \"gone.png\""),
        "{warned:?}"
    );
    assert!(
        warned[2].starts_with("3×1 no material library \"gone.mtl\""),
        "{warned:?}"
    );

    // A bad material stops the load where it stands; so does a file that cannot be read.
    folder.write("more.mtl", "newmtl lamp\nKe bright");
    let error = load(&folder.0.join("a.obj")).unwrap_err();
    assert_eq!(
        (error.path, error.line),
        (folder.0.join("./more.mtl"), Some(2))
    );
    for path in [folder.0.join("gone.obj"), folder.0.clone()] {
        let error = load(&path).unwrap_err();
        assert_readable(&error);
        assert_eq!(error.path, path);
    }
}
