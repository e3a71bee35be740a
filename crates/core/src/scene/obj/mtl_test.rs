//! What MTL texts hold in the wild, and what must come of it. Files that name others are in
//! `file_test`.

use glam::Vec3;

use super::test::assert_readable;
use crate::scene::desc::MaterialDesc;
use crate::scene::error::SceneError;

/// What a renderer relies on.
pub(super) fn assert_physical(m: &MaterialDesc) {
    assert!(!m.name.is_empty());
    for color in [m.albedo, m.mirror_color] {
        assert!(
            color.min_element() >= 0.0 && color.max_element() <= 1.0,
            "{m:?}"
        );
    }
    assert!((0.0..=1.0).contains(&m.mirror), "{m:?}");
    assert!(
        m.glass.is_none_or(|ior| (1.0..=5.0).contains(&ior)),
        "{m:?}"
    );
    assert!(
        m.emission.min_element() >= 0.0 && m.emission.max_element() <= 1e9,
        "{m:?}"
    );
}

/// The materials of a text, and the warnings, a line each.
pub(super) fn materials(text: &str) -> Result<(Vec<MaterialDesc>, String), SceneError> {
    let (materials, warnings) = super::materials(text).inspect_err(assert_readable)?;
    materials.iter().for_each(assert_physical);
    let warnings = warnings.iter().map(|w| format!("{w}\n")).collect();
    Ok((materials, warnings))
}

/// One material of these records.
fn material(records: &str) -> (MaterialDesc, String) {
    let (mut materials, warnings) = materials(&format!("newmtl a\n{records}")).unwrap();
    assert_eq!(materials.len(), 1);
    (materials.remove(0), warnings)
}

/// Names: before the first, given twice, with spaces.
#[test]
fn materials_are_known_by_name() {
    let (found, warnings) =
        materials("Kd 1\nnewmtl a\nKd 0\nnewmtl a b\nKd 1\nnewmtl a\nKd .5").unwrap();
    assert_eq!(
        found
            .iter()
            .map(|m| (&*m.name, m.albedo))
            .collect::<Vec<_>>(),
        [("a", Vec3::ZERO), ("a b", Vec3::ONE)]
    );
    assert!(
        warnings.contains("1: Kd: stands before") && warnings.contains("6: materials of a name"),
        "{warnings}"
    );
}

#[test]
fn illumination_models_choose_diffuse_mirror_or_glass() {
    let (plain, warnings) = material("Kd .2\nKs .6\nNs 9\nNi 0\nillum 2\nKe 1 2 3");
    assert_eq!(
        (plain.albedo, plain.mirror, plain.glass),
        (Vec3::splat(0.2), 0.0, None)
    );
    assert_eq!((plain.emission, &*warnings), (Vec3::new(1.0, 2.0, 3.0), ""));

    // Each part at its share of the picks must give back what the file says.
    let (kd, ks) = (Vec3::new(0.3, 0.2, 0.1), Vec3::new(0.2, 0.4, 0.6));
    let (blend, warnings) = material("Kd .3 .2 .1\nKs .2 .4 .6\nillum 3");
    assert_eq!(blend.mirror, 0.6 / 0.9);
    assert!(
        (blend.albedo * (1.0 - blend.mirror)).abs_diff_eq(kd, 1e-6),
        "{blend:?}"
    );
    assert!(
        (blend.mirror_color * blend.mirror).abs_diff_eq(ks, 1e-6),
        "{blend:?}"
    );
    assert_eq!(warnings, "");

    let (mirror, _) = material("Ks .9\nillum 3");
    assert_eq!(
        (mirror.mirror, mirror.mirror_color),
        (1.0, Vec3::splat(0.9))
    );
    assert_eq!(material("Kd .5\nKs 0\nillum 3").0.mirror, 0.0);
    let (bright, warnings) = material("Kd .8\nKs .8\nillum 3");
    assert_eq!((bright.albedo, bright.mirror_color), (Vec3::ONE, Vec3::ONE));
    assert!(warnings.contains("more than arrives"), "{warnings}");

    for (records, ior, warns) in [
        ("illum 7\nNi 1.33", 1.33, false),
        ("illum 6", 1.5, false),
        ("illum 4\nNi 1", 1.0, false),
        ("illum 7\nNi 0", 1.5, true),
        ("illum 7\nNi 100", 1.5, true),
    ] {
        let (glass, warnings) = material(records);
        assert_eq!(
            (glass.glass, !warnings.is_empty()),
            (Some(ior), warns),
            "{records}"
        );
    }
}
