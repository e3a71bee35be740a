//! `lightbox lab`: runs the stability lab's probes, and shows what they measured as a table, as
//! JSON or as a report with pictures.
//!
//! The JSON object holds `cases`, `failed` and `results`, one for each case in the table's order
//! with `id`, `area`, `title`, `failure`, `cure`, `verdict` (`holds`, `fails`, `by-test`,
//! `absent`), `figures`, `test` (the test that holds the case) or `reason` (why there is nothing
//! to hold), and `scene` (a built-in scene that shows it), null where there is none. A figure has
//! `what`, `naive` (null if not tried), `lightbox`, `bound` (`{"exactly": x}`, `{"at_most": x}`,
//! `{"at_least": x}` or `{"within": {"truth": x, "tolerance": y}}`), `holds` and `naive_fails`.
//! Numbers that are not finite are null.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use indicatif::ProgressBar;
use lightbox_core::color::ToneMap;
use lightbox_core::lab::{AREAS, Case, Check, Figure, Side, Verdict, cases, find, number};
use lightbox_core::{image_io, suggest};
use rayon::prelude::*;
use serde::Serialize;

use super::{CASE_FAILED, Outcome, json_line};
use crate::args::LabArgs;

/// Folder of the report's pictures, beside the report.
const PICTURES: &str = "lab";

/// The report of `--json`.
#[derive(Serialize)]
struct Report {
    cases: usize,
    failed: usize,
    results: Vec<Run>,
}

/// A case that was run.
#[derive(Serialize)]
struct Run {
    id: &'static str,
    area: &'static str,
    title: &'static str,
    failure: &'static str,
    cure: &'static str,
    verdict: Verdict,
    figures: Vec<Measured>,
    test: Option<&'static str>,
    reason: Option<&'static str>,
    scene: Option<&'static str>,
    #[serde(skip)]
    picture: Option<fn(Side) -> lightbox_core::Image>,
}

#[derive(Serialize)]
struct Measured {
    #[serde(flatten)]
    figure: Figure,
    holds: bool,
    naive_fails: Option<bool>,
}

/// Runs the cases that were asked for; the error is one line.
pub fn run(args: &LabArgs) -> Result<Outcome, String> {
    let chosen = chosen(&args.ids)?;
    if args.list {
        return Ok(Outcome::done(list(&chosen)));
    }
    if let Some(output) = &args.output
        && output.extension().is_none_or(|e| e != "md")
    {
        return Err(format!(
            "{}: the report is Markdown; name a file that ends in .md",
            output.display()
        ));
    }
    if let Some(folder) = args.output.as_deref().and_then(Path::parent)
        && !folder.as_os_str().is_empty()
        && !folder.is_dir()
    {
        return Err(format!(
            "{}: there is no such folder for the report; create it first",
            folder.display()
        ));
    }
    // On standard error, and only if that is a terminal.
    let bar = ProgressBar::new(chosen.len() as u64);
    let results: Vec<Run> = chosen
        .par_iter()
        .map(|case| {
            let run = measure(case);
            bar.inc(1);
            run
        })
        .collect();
    bar.finish_and_clear();
    let report = Report {
        cases: results.len(),
        failed: count(&results, Verdict::Fails),
        results,
    };
    if let Some(output) = &args.output {
        write(output, &report)?;
    }
    Ok(Outcome {
        report: if args.json {
            json_line(&report)?
        } else {
            table(&report)
        },
        status: if report.failed > 0 { CASE_FAILED } else { 0 },
    })
}

/// The cases of some ids, in the order asked for, each once; all of them if none is given.
fn chosen(ids: &[String]) -> Result<Vec<&'static Case>, String> {
    if ids.is_empty() {
        return Ok(cases().collect());
    }
    let mut chosen: Vec<&Case> = Vec::new();
    for id in ids {
        let case = find(id).ok_or_else(|| {
            let all: Vec<_> = cases().map(|case| case.id).collect();
            format!("{id}: no such case{}", suggest::among(id, &all))
        })?;
        if chosen.iter().all(|known| known.id != case.id) {
            chosen.push(case);
        }
    }
    Ok(chosen)
}

fn measure(case: &Case) -> Run {
    let figures = case.measure();
    let (test, reason) = match case.check {
        Check::Probe(_) => (None, None),
        Check::Test(test) => (Some(test), None),
        Check::Absent(reason) => (None, Some(reason)),
    };
    Run {
        id: case.id,
        area: area(case.id),
        title: case.title,
        failure: case.failure,
        cure: case.cure,
        verdict: case.verdict(&figures),
        figures: figures
            .into_iter()
            .map(|figure| Measured {
                holds: figure.holds(),
                naive_fails: figure.naive_fails(),
                figure,
            })
            .collect(),
        test,
        reason,
        scene: case.scene,
        picture: case.picture,
    }
}

/// The name of the area that a case is in.
fn area(id: &str) -> &'static str {
    let home = AREAS
        .iter()
        .find(|(_, cases)| cases.iter().any(|case| case.id == id));
    home.map_or("", |(name, _)| name)
}

fn count(results: &[Run], verdict: Verdict) -> usize {
    results.iter().filter(|run| run.verdict == verdict).count()
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::Fails => "FAILS",
        Verdict::ByTest => "by test",
        Verdict::Absent => "absent",
    }
}

fn list(cases: &[&Case]) -> String {
    let mut area_shown = "";
    let mut lines = String::new();
    for case in cases {
        let area = area(case.id);
        if area != area_shown {
            lines += &format!("{area}\n");
            area_shown = area;
        }
        lines += &format!("  {:4} {}\n", case.id, case.title);
    }
    lines
}

/// What was counted, in one line.
fn summary(report: &Report) -> String {
    format!(
        "{} cases: {} hold, {} fail, {} held by a test, {} absent",
        report.cases,
        count(&report.results, Verdict::Holds),
        report.failed,
        count(&report.results, Verdict::ByTest),
        count(&report.results, Verdict::Absent),
    )
}

/// A line for each case and under it one for each figure, in columns, for a terminal.
fn table(report: &Report) -> String {
    let mut rows = vec![["case", "", "naive", "lightbox", "bound", "verdict"].map(str::to_owned)];
    for run in &report.results {
        let verdict = word(run.verdict).to_owned();
        rows.push([
            run.id.to_owned(),
            run.title.to_owned(),
            String::new(),
            String::new(),
            String::new(),
            verdict,
        ]);
        for Measured { figure, holds, .. } in &run.figures {
            rows.push([
                String::new(),
                format!("  {}", figure.what),
                figure.naive.map_or_else(String::new, number),
                number(figure.lightbox),
                figure.bound.to_string(),
                if *holds { "" } else { "  broken" }.to_owned(),
            ]);
        }
    }
    let widths: [usize; 6] = std::array::from_fn(|i| {
        let width = |row: &[String; 6]| row[i].chars().count();
        rows.iter().map(width).max().unwrap_or(0)
    });
    let mut text = String::new();
    for [id, what, naive, lightbox, bound, verdict] in &rows {
        let [a, b, c, d, e, _] = widths;
        let line =
            format!("{id:a$}  {what:b$}  {naive:>c$}  {lightbox:>d$}  {bound:e$}  {verdict}");
        text += line.trim_end();
        text.push('\n');
    }
    text + &summary(report) + "\n"
}

/// Writes the Markdown report and its pictures.
fn write(path: &Path, report: &Report) -> Result<(), String> {
    let cannot_write = |e: std::io::Error| format!("{}: cannot be written ({e})", path.display());
    let folder = path.with_file_name(PICTURES);
    if report.results.iter().any(|run| run.picture.is_some()) {
        fs::create_dir_all(&folder).map_err(cannot_write)?;
    }
    report
        .results
        .par_iter()
        .try_for_each(|run| pictures(run, &folder))?;
    fs::write(path, markdown(report)).map_err(cannot_write)
}

/// Draws a case's pictures, if it has any, as `ID-naive.png` and `ID-lightbox.png`.
fn pictures(run: &Run, folder: &Path) -> Result<(), String> {
    let Some(picture) = run.picture else {
        return Ok(());
    };
    for (side, name) in [(Side::Naive, "naive"), (Side::Lightbox, "lightbox")] {
        let file = folder.join(format!("{}-{name}.png", run.id));
        let replay = format!("lightbox lab {} -o", run.id);
        image_io::write(&file, &picture(side), ToneMap::default(), &replay)?;
    }
    Ok(())
}

/// The report. It holds nothing that differs from run to run, so that its history shows changes.
fn markdown(report: &Report) -> String {
    let mut text = format!(
        "# The stability lab, case by case\n\n\
         Written by `lightbox lab -o FILE.md`. {}.\n\n\
         | case | | verdict |\n|---|---|---|\n",
        summary(report)
    );
    for run in &report.results {
        let Run { id, title, .. } = run;
        // Anchors of headings, as GitHub makes them.
        let anchor = format!("{id} {title}").to_lowercase();
        let anchor: String = anchor
            .chars()
            .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
            .map(|c| if c == ' ' { '-' } else { c })
            .collect();
        let _ = writeln!(
            text,
            "| [{id}](#{anchor}) | {title} | {} |",
            word(run.verdict)
        );
    }
    let mut area_shown = "";
    for run in &report.results {
        if run.area != area_shown {
            let _ = write!(text, "\n## {}\n", run.area);
            area_shown = run.area;
        }
        section(&mut text, run);
    }
    text
}

fn section(text: &mut String, run: &Run) {
    let (id, title) = (run.id, run.title);
    let _ = write!(
        text,
        "\n### {id} {title}\n\n**How it fails.** {}\n\n**Instead.** {}\n\n",
        run.failure, run.cure
    );
    let _ = match (run.test, run.reason) {
        (Some(test), _) => writeln!(text, "**Verdict.** Held by the test `{test}`."),
        (_, Some(reason)) => writeln!(text, "**Verdict.** Nothing to hold: {reason}"),
        _ => writeln!(text, "**Verdict.** {}", word(run.verdict)),
    };
    if !run.figures.is_empty() {
        *text += "\n| | naive | lightbox | bound |\n|---|---|---|---|\n";
    }
    for Measured { figure, holds, .. } in &run.figures {
        let naive = figure.naive.map_or_else(|| "–".to_owned(), number);
        let mark = if *holds { "" } else { " (broken)" };
        let _ = writeln!(
            text,
            "| {} | {naive} | {}{mark} | {} |",
            figure.what,
            number(figure.lightbox),
            figure.bound
        );
    }
    if run.picture.is_some() {
        let _ = write!(
            text,
            "\n| naive | lightbox |\n|---|---|\n\
             | ![{id}, naive]({PICTURES}/{id}-naive.png) | ![{id}, lightbox]({PICTURES}/{id}-lightbox.png) |\n"
        );
    }
    if let Some(scene) = run.scene {
        let _ = write!(text, "\nTo look around in it: `lightbox {scene}`.\n");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(ids: &[&str]) -> LabArgs {
        LabArgs {
            ids: ids.iter().map(|id| (*id).to_owned()).collect(),
            list: false,
            output: None,
            json: false,
        }
    }

    #[test]
    fn a_case_is_shown_with_its_figures_and_the_status_is_its_verdict() {
        let outcome = run(&args(&["s01"])).unwrap();
        assert_eq!(outcome.status, 0);
        let lines: Vec<&str> = outcome.report.lines().collect();
        assert!(lines[1].starts_with("S01") && lines[1].ends_with("holds"));
        assert!(lines.len() >= 4, "{lines:?}");
        assert!(lines.last().unwrap().starts_with("1 cases: 1 hold"));

        // A failing case is shown and fails the command.
        let figure = Figure {
            what: "wrong",
            naive: Some(f64::NAN),
            lightbox: 1.0,
            bound: lightbox_core::lab::Bound::Exactly(0.0),
        };
        let mut failing = measure(find("S01").unwrap());
        failing.verdict = find("S01").unwrap().verdict(std::slice::from_ref(&figure));
        failing.figures = vec![Measured {
            holds: figure.holds(),
            naive_fails: figure.naive_fails(),
            figure,
        }];
        let report = Report {
            cases: 1,
            failed: count(std::slice::from_ref(&failing), Verdict::Fails),
            results: vec![failing],
        };
        assert_eq!(report.failed, 1);
        let text = table(&report);
        assert!(text.contains("FAILS") && text.contains("broken"), "{text}");
        let json: serde_json::Value = serde_json::from_str(&json_line(&report).unwrap()).unwrap();
        assert_eq!(json["failed"], 1);
        let figure = &json["results"][0]["figures"][0];
        assert_eq!(figure["bound"]["exactly"], 0.0);
        assert_eq!(figure["naive"], serde_json::Value::Null);
        assert_eq!(
            (&figure["holds"], &figure["naive_fails"]),
            (&false.into(), &true.into())
        );
    }

    #[test]
    fn a_wrong_name_gets_one_line_with_the_nearest() {
        let error = run(&args(&["S0I"])).unwrap_err();
        assert!(
            error.starts_with("S0I: no such case; did you mean \"S0"),
            "{error}"
        );
        let error = run(&LabArgs {
            output: Some("report.html".into()),
            ..args(&["S01"])
        })
        .unwrap_err();
        assert!(
            error.starts_with("report.html: ") && error.contains(".md"),
            "{error}"
        );
    }

    #[test]
    fn the_report_and_its_pictures_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.md");
        let with_picture = cases().find(|case| case.picture.is_some());
        let ids: Vec<&str> = [Some("S01"), with_picture.map(|case| case.id)]
            .into_iter()
            .flatten()
            .collect();
        run(&LabArgs {
            output: Some(path.clone()),
            ..args(&ids)
        })
        .unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert!(
            text.contains("### S01 ") && text.contains("## Spheres"),
            "{text}"
        );
        if let Some(case) = with_picture {
            for side in ["naive", "lightbox"] {
                let file = format!("lab/{}-{side}.png", case.id);
                assert!(
                    text.contains(&file) && folder.path().join(&file).exists(),
                    "{file}"
                );
            }
        }
    }
}
