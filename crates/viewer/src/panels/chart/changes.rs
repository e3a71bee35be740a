//! What sets an earlier picture apart from the present one, in a few words.

use lightbox_core::SceneDesc;
use lightbox_core::settings::UNLIMITED;

use crate::model::scene_name;
use crate::session::Run;

/// How a run differs from the present one: what it had, not what it lacked.
pub fn changes(run: &Run, present: Option<&Run>) -> String {
    let Some(present) = present else {
        return scene_name(&run.path);
    };
    if run.path != present.path {
        return scene_name(&run.path);
    }
    let (old, new) = (&run.desc.render, &present.desc.render);
    let mut parts = Vec::new();
    let mut note = |differs: bool, text: String| {
        if differs {
            parts.push(text);
        }
    };
    note(old.method != new.method, old.method.to_string());
    note(old.sampler != new.sampler, old.sampler.to_string());
    let depth = match old.depth {
        UNLIMITED => "unlimited depth".into(),
        depth => format!("depth {depth}"),
    };
    note(old.depth != new.depth, depth);
    let filter = format!("{} {:.1} px", old.filter.kind.name(), old.filter.radius);
    note(old.filter != new.filter, filter);
    note(old.accel != new.accel, old.accel.to_string());
    note(old.seed != new.seed, format!("seed {}", old.seed));
    let size = format!("{} × {} px", old.width, old.height);
    note([old.width, old.height] != [new.width, new.height], size);
    note(
        run.desc.camera != present.desc.camera,
        "other camera".into(),
    );
    let apart = SceneDesc {
        camera: present.desc.camera,
        render: present.desc.render,
        ..(*run.desc).clone()
    };
    note(apart != *present.desc, "other scene".into());
    if parts.is_empty() {
        "the same again".into()
    } else {
        parts.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::sync::Arc;

    use lightbox_core::Method;

    use super::*;
    use crate::session::History;

    fn run(desc: SceneDesc, path: &str) -> Run {
        let mut history = History::default();
        history.begin(Arc::new(desc), PathBuf::from(path), false);
        history.present.expect("a run")
    }

    #[test]
    fn what_differs_is_named_as_it_was() {
        let present = run(SceneDesc::default(), "a.toml");
        let told = |edit: fn(&mut SceneDesc)| {
            let mut desc = SceneDesc::default();
            edit(&mut desc);
            changes(&run(desc, "a.toml"), Some(&present))
        };
        assert_eq!(told(|_| ()), "the same again");
        assert_eq!(told(|d| d.render.samples = 7), "the same again");
        assert_eq!(
            told(|d| (d.render.method, d.render.depth) = (Method::Naive, 4)),
            "naive, depth 4"
        );
        assert_eq!(told(|d| d.render.depth = UNLIMITED), "unlimited depth");
        assert_eq!(told(|d| d.render.filter.radius = 3.0), "box 3.0 px");
        assert_eq!(told(|d| d.camera.fov = 11.0), "other camera");
        assert_eq!(
            told(|d| d.background = glam::Vec3::splat(0.7)),
            "other scene"
        );
        let other = run(SceneDesc::default(), "some/b.toml");
        assert_eq!(changes(&other, Some(&present)), "b");
    }
}
