//! An edited scene in the words of the file it came from: what the edits leave alone keeps its
//! place, its spelling and its comments.

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike};

use super::desc::SceneDesc;

/// The text of a scene file with as little changed as makes it read as `desc`; `None` if it is no
/// scene, or written in a way that this cannot change.
pub(super) fn rewritten(text: &str, desc: &SceneDesc) -> Option<String> {
    let parse = |text: &str| super::parse(text, "".as_ref()).ok();
    let plain = |desc| {
        let text = toml::to_string(desc).ok()?;
        text.parse::<DocumentMut>().ok()
    };
    let mut file: DocumentMut = text.parse().ok()?;
    let (before, after) = (plain(&parse(text)?)?, plain(desc)?);
    merge(file.as_table_mut(), before.as_table(), after.as_table());
    let text = file.to_string();
    (parse(&text)? == *desc).then_some(text)
}

/// Makes to a table of the file the changes from `before` to `after`.
fn merge(file: &mut dyn TableLike, before: &dyn TableLike, after: &dyn TableLike) {
    for (key, _) in before.iter() {
        if after.get(key).is_none() {
            file.remove(key);
        }
    }
    for (key, to) in after.iter() {
        let from = before.get(key);
        match (file.get_mut(key), from, to) {
            (Some(Item::ArrayOfTables(file)), Some(Item::ArrayOfTables(from)), to) => {
                if let Item::ArrayOfTables(to) = to {
                    merge_arrays(file, from, to);
                }
            }
            (file_item, _, Item::Table(to)) => {
                let empty = Table::new();
                let from = from.and_then(Item::as_table).unwrap_or(&empty);
                match file_item.and_then(Item::as_table_like_mut) {
                    Some(file) => merge(file, from, to),
                    // What the file leaves out it need not say until it changes.
                    None => {
                        let mut table = fresh(&Table::new());
                        merge(&mut table, from, to);
                        if !table.is_empty() {
                            file.insert(key, Item::Table(table));
                        }
                    }
                }
            }
            _ if from.is_some_and(|from| from.to_string() == to.to_string()) => {}
            (Some(Item::Value(old)), _, Item::Value(to)) => {
                let mut value = to.clone();
                *value.decor_mut() = old.decor().clone();
                *old = value;
            }
            (_, _, Item::ArrayOfTables(to)) => {
                file.insert(key, Item::ArrayOfTables(to.iter().map(fresh).collect()));
            }
            (_, _, to) => {
                file.insert(key, to.clone());
            }
        }
    }
}

fn merge_arrays(file: &mut ArrayOfTables, before: &ArrayOfTables, after: &ArrayOfTables) {
    let (before, after): (Vec<_>, Vec<_>) = (before.iter().collect(), after.iter().collect());
    let mut old: Vec<_> = file.iter().cloned().map(Some).collect();
    file.clear();
    for (to, from) in after.iter().zip(aligned(&before, &after)) {
        let kept = from.and_then(|i| Some((before[i], old.get_mut(i)?.take()?)));
        file.push(match kept {
            Some((from, mut table)) => {
                merge(&mut table, from, *to);
                table
            }
            None => fresh(to),
        });
    }
}

/// A table for a place behind those there are.
fn fresh(table: &Table) -> Table {
    let mut table = table.clone();
    table.set_position(None);
    table.decor_mut().set_prefix("\n");
    table
}

/// For each table of `after` the one of `before` that it was: in the same order, and so that as
/// much as possible is the same, or at least has the same name.
fn aligned(before: &[&Table], after: &[&Table]) -> Vec<Option<usize>> {
    let text = |tables: &[&Table]| tables.iter().map(|t| t.to_string()).collect::<Vec<_>>();
    let (old, new) = (text(before), text(after));
    let start = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
    let rest = (old.len().min(new.len())) - start;
    let (from_end, to_end) = (old.iter().rev(), new.iter().rev());
    let end = from_end.zip(to_end).take(rest).take_while(|(a, b)| a == b);
    let end = end.count();
    let (rows, columns) = (old.len() - start - end, new.len() - start - end);

    let name = |table: &Table| {
        let name = table.get("name").and_then(Item::as_str);
        name.unwrap_or_default().to_owned()
    };
    let likeness = |i: usize, j: usize| {
        let (i, j) = (start + i, start + j);
        let (from, to) = (name(before[i]), name(after[j]));
        match from == to {
            _ if old[i] == new[j] => 4,
            true if !to.is_empty() => 3,
            true => 1,
            false => 0,
        }
    };
    // best[i][j]: the most likeness of what is left from i and j on.
    let mut best = vec![vec![0u32; columns + 1]; rows + 1];
    for i in (0..rows).rev() {
        for j in (0..columns).rev() {
            let together = match likeness(i, j) {
                0 => 0,
                likeness => likeness + best[i + 1][j + 1],
            };
            best[i][j] = together.max(best[i + 1][j]).max(best[i][j + 1]);
        }
    }
    let mut middle = vec![None; columns];
    let (mut i, mut j) = (0, 0);
    while i < rows && j < columns {
        if best[i][j] == best[i + 1][j] {
            i += 1;
        } else if best[i][j] == best[i][j + 1] {
            j += 1;
        } else {
            middle[j] = Some(start + i);
            (i, j) = (i + 1, j + 1);
        }
    }
    let last = old.len() - end..old.len();
    (0..start)
        .map(Some)
        .chain(middle)
        .chain(last.map(Some))
        .collect()
}

#[cfg(test)]
mod test {
    use glam::Vec3;

    use super::*;
    use crate::scene::{MaterialDesc, SphereDesc};

    const FILE: &str = r##"# A room.
background = [0.0, 0.5, 1] # sky

[camera] # from the door
eye = [ 0, 0, 4 ]
fov = 40 # wide

# Walls.
[[material]]
name = "clay"   # grey
albedo = [0.5, 0.5, 0.5]

[[material]]
name = "lamp"
emission = [5, 5, 5]

# The first.
[[sphere]]
material = "clay" # as the second
center = [0, 0, 0]
radius = 0.5

# The second.
[[sphere]]
material = "clay"
center = [1, 0, 0] # right
radius = 0.25

# Below.
[[sphere]]
name = "ball"
material = "lamp"
center = [0, -1, 0]
radius = 0.25
# The end.
"##;

    fn desc() -> SceneDesc {
        super::super::parse(FILE, "file".as_ref()).unwrap()
    }

    /// The rewritten file, which must read as what was asked for.
    fn rewrite(desc: &SceneDesc) -> String {
        let text = rewritten(FILE, desc).expect("rewritten");
        assert_eq!(super::super::parse(&text, "file".as_ref()).unwrap(), *desc);
        text
    }

    #[test]
    fn what_was_not_edited_stays_to_the_letter() {
        assert_eq!(rewrite(&desc()), FILE);
        let mut edited = desc();
        edited.spheres[1].center.x = 2.0;
        edited.camera.fov = 35.5;
        let expected = FILE
            .replace("[1, 0, 0] # right", "[2.0, 0.0, 0.0] # right")
            .replace("fov = 40 # wide", "fov = 35.5 # wide");
        assert_eq!(rewrite(&edited), expected);
    }

    #[test]
    fn what_the_file_left_out_is_said_once_it_matters() {
        let mut edited = desc();
        edited.render.samples = 17;
        edited.camera.up = Vec3::Z;
        edited.materials[1].glass = Some(1.5);
        let text = rewrite(&edited);
        assert!(text.contains("[render]\nsamples = 17\n"), "{text}");
        assert!(
            !text.contains("depth") && text.matches("albedo").count() == 1,
            "{text}"
        );
        for comment in FILE.lines().filter_map(|l| l.split_once('#')) {
            assert!(text.contains(comment.1), "{} in {text}", comment.1);
        }
        edited.materials[1].glass = None;
        assert!(!rewrite(&edited).contains("glass"));
    }

    #[test]
    fn objects_come_and_go_and_the_others_keep_their_comments() {
        let mut edited = desc();
        edited.spheres.remove(0);
        edited.spheres[1].radius = 3.0;
        let new = SphereDesc {
            name: "new".into(),
            ..edited.spheres[0].clone()
        };
        edited.spheres.insert(1, new.clone());
        edited.spheres.push(new);
        edited.materials.insert(
            1,
            MaterialDesc {
                name: "new".into(),
                ..MaterialDesc::default()
            },
        );
        let text = rewrite(&edited);
        assert!(!text.contains("# The first."), "{text}");
        for comment in [
            "# The second.",
            "# right",
            "# Below.",
            "# Walls.",
            "# grey",
            "# The end.",
        ] {
            assert!(text.contains(comment), "{comment} in {text}");
        }
        edited.spheres.clear();
        assert!(!rewrite(&edited).contains("sphere"));
    }

    #[test]
    fn other_ways_to_write_a_scene_read_as_it_too() {
        let inline = r#"camera = { eye = [0, 0, 4], fov = 40 } # short
render.samples = 3 # few
material = [{ name = "clay" }, { name = "lamp", emission = [1, 1, 1] }]
sphere = [{ material = "clay", center = [0, 0, 0], radius = 1 }]
"#;
        let mut desc = super::super::parse(inline, "file".as_ref()).unwrap();
        desc.camera.fov = 41.0;
        desc.render.samples = 4;
        let text = rewritten(inline, &desc).expect("rewritten");
        assert!(text.contains("# short") && text.contains("# few"), "{text}");
        // A list in one line cannot take tables: it is written anew.
        desc.spheres[0].radius = 2.0;
        if let Some(text) = rewritten(inline, &desc) {
            assert_eq!(super::super::parse(&text, "file".as_ref()).unwrap(), desc);
        }
        assert_eq!(rewritten("nonsense = 1", &desc), None);
    }
}
