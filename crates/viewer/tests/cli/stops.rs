//! What ends a render: samples, noise, time.

use crate::{Folder, json, render};

#[test]
fn noise_stops_at_the_same_sample_on_any_number_of_threads() {
    let folder = Folder::new();
    let path = folder.path("a.exr");
    let reports = [1, 3].map(|threads| {
        render(
            "cornell-box",
            &format!("--size 24x24 --noise 0.04 --threads {threads}"),
            &path,
        )
    });
    for report in &reports {
        assert_eq!(report["stopped_by"], "noise");
        assert!(
            report["noise"].as_f64() <= Some(0.04) && report["spp"].as_u64() > Some(16),
            "{report}"
        );
    }
    assert_eq!(reports[0]["spp"], reports[1]["spp"]);
    // Whichever is reached first.
    let report = render("cornell-box", "--size 24x24 --noise 0.04 --spp 6", &path);
    assert_eq!(
        (&report["stopped_by"], &report["spp"]),
        (&"spp".into(), &6.into())
    );
}

#[test]
fn seconds_stop_a_render_that_never_ends_otherwise() {
    let report = json([
        "render",
        "cornell-box",
        "--size",
        "16x16",
        "--seconds",
        "0.3",
        "--noise",
        "1e-9",
        "--json",
    ]);
    assert_eq!(report["stopped_by"], "seconds");
    assert!(report["spp"].as_u64() > Some(1), "{report}");
    assert_eq!(
        report["paths"].as_u64(),
        report["spp"].as_u64().map(|spp| spp * 256)
    );
}
