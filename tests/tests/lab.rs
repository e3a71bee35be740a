//! The stability lab: every case's probe keeps its bounds, and the table is whole.

use std::collections::BTreeSet;
use std::path::Path;

use lightbox_core::lab::{Check, Side, Verdict, cases, find};
use lightbox_core::scene::{BUILTIN_LAB, load};

/// Measures a case: lightbox must keep every bound, and a naive method must break one.
fn hold(id: &str) {
    let case = find(id).unwrap_or_else(|| panic!("{id} is not in the lab's table"));
    let figures = case.measure();
    assert_eq!(
        case.verdict(&figures),
        Verdict::Holds,
        "{} {}: {:#?}",
        case.id,
        case.title,
        figures.iter().filter(|f| !f.holds()).collect::<Vec<_>>()
    );
    let tried: Vec<bool> = figures.iter().filter_map(|f| f.naive_fails()).collect();
    assert!(
        tried.is_empty() || tried.contains(&true),
        "{id}: what the naive method is said to get wrong, it gets right: {figures:#?}"
    );
}

macro_rules! probes {
    ($($id:ident)*) => {
        $(#[test]
        fn $id() {
            hold(stringify!($id));
        })*

        const PROBES: &[&str] = &[$(stringify!($id)),*];
    };
}

probes! {
    s01 s02 s03 s04 s05 s06 s07 s08 s09 s10 s11 s12
    t01 t02 t03 t04 t05 t06 t07 t08 t09 t10 t11 t12 t13
    q01 q02 q03 q04
    m01 m02 m03
    k01 k02 k03 k04 k05 k06 k07 k08 k09 k10 k11
    v01 v02 v03 v04 v05 v06 v07 v08 v09 v10
    i01 i02 i03 i04 i05 i06 i07
    l01 l02 l03 l04 l05 l06 l07 l08
    b01 b02 b03 b04 b05 b06 b07
    y01 y02 y03 y04 y05 y06 y07 y08
    f01 f02 f03 f04 f05 f06 f07
    a01 a02 a03 a04 a05 a06
    g01 g02 g03 g04 g05 g06 g07 g08
    d01 d02 d03 d04 d05 d06 d07 d08 d09
    c01 c02 c03 c04
    w01 w05
}

#[test]
fn every_probe_is_a_test_above() {
    let of_table: BTreeSet<String> = cases()
        .filter(|case| matches!(case.check, Check::Probe(_)))
        .map(|case| case.id.to_lowercase())
        .collect();
    let listed: BTreeSet<String> = PROBES.iter().map(|id| (*id).to_owned()).collect();
    assert_eq!(of_table, listed);
    assert_eq!(listed.len(), PROBES.len(), "an id is listed twice");
}

#[test]
fn ids_are_unique_and_a_letter_with_two_digits() {
    let mut seen = BTreeSet::new();
    for case in cases() {
        let bytes = case.id.as_bytes();
        assert!(
            bytes.len() == 3
                && bytes[0].is_ascii_uppercase()
                && bytes[1..].iter().all(u8::is_ascii_digit),
            "{}",
            case.id
        );
        assert!(seen.insert(case.id), "{} twice", case.id);
    }
}

#[test]
fn tests_that_are_named_exist() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for case in cases() {
        let Check::Test(test) = case.check else {
            continue;
        };
        let (file, name) = test
            .split_once("::")
            .unwrap_or_else(|| panic!("{}: {test} is not file::name", case.id));
        let source = std::fs::read_to_string(top.join(file))
            .unwrap_or_else(|e| panic!("{}: {file}: {e}", case.id));
        let function = format!("fn {name}()");
        let attributes = source.split_once(&function).map(|(before, _)| {
            let end_of_last_item = before.rfind(['}', ';']).unwrap_or(0);
            &before[end_of_last_item..]
        });
        assert!(
            attributes.is_some_and(|a| a.contains("#[test]") && !a.contains("#[ignore")),
            "{}: no test {name} in {file}",
            case.id
        );
    }
}

#[test]
fn scenes_load_and_pictures_can_be_drawn() {
    for scene in BUILTIN_LAB {
        assert!(
            cases().any(|case| case.scene == Some(scene)),
            "{scene} shows no case"
        );
    }
    for case in cases() {
        if let Some(scene) = case.scene {
            let scene = load(Path::new(scene))
                .and_then(|source| source.build(&lightbox_core::scene::unwatched))
                .unwrap_or_else(|e| panic!("{}: {e}", case.id));
            assert_eq!(scene.warnings(), [], "{}", case.id);
        }
        if let Some(picture) = case.picture {
            let [naive, lightbox] = [Side::Naive, Side::Lightbox].map(picture);
            assert_eq!(
                [naive.width, naive.height],
                [lightbox.width, lightbox.height],
                "{}",
                case.id
            );
            assert!(lightbox.pixels.iter().all(|p| p.is_finite()), "{}", case.id);
            assert_ne!(naive.pixels, lightbox.pixels, "{}: no difference", case.id);
        }
    }
}
