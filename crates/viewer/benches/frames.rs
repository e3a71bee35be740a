//! How long the window takes for a frame while it renders at full load: the real window, driven by a
//! script for a minute that orbits, drags every slider and resizes. What is counted is all the
//! window's thread does for a frame (layout, gestures, tessellation, uploads and drawing) but for
//! waiting in the swap of buffers; where the system tells it, also the processor time that the thread
//! had for a frame, the swap included, which a busy machine changes little. Then the processor time that a paused and a finished picture take
//! in ten seconds. `cargo bench -p lightbox --bench frames [-- SCENE]`, on a display of 1400×1100.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui::{
    Context, Event, FullOutput, Key, Modifiers, Plugin, PointerButton, Pos2, RawInput, Rect, Ui,
    ViewportCommand,
};
use lightbox::app::App;
use lightbox::session::Activity;

/// Seconds of each third of the script.
const THIRD: f64 = 20.0;

/// Largest size of the window, points.
const SIZE: [f32; 2] = [1360.0, 1060.0];

/// How long a window at rest is watched, seconds.
const WATCHED: u64 = 10;

fn main() {
    let named = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let scene = named.unwrap_or_else(|| "builtin:teddy-diffuse.toml".into());
    let viewport = egui::ViewportBuilder::default().with_inner_size(SIZE);
    let options = eframe::NativeOptions {
        viewport,
        ..Default::default()
    };
    println!("{scene}");
    let create: eframe::AppCreator<'_> = Box::new(move |context| {
        let ctx = &context.egui_ctx;
        let sliders = Sliders::default();
        ctx.add_plugin(sliders.clone());
        let app = App::new(ctx, Some(PathBuf::from(&scene)))?;
        Ok(Box::new(Driver {
            app,
            sliders,
            stage: Stage::Opening,
            since: Instant::now(),
            times: Default::default(),
            busy: Default::default(),
            before: None,
            uploaded: [0; 2],
            held: None,
        }))
    });
    if let Err(e) = eframe::run_native("lightbox-frames", options, create) {
        eprintln!("skipped: the window needs a display ({e})");
    }
}

/// Where the sliders are, found as a screen reader finds them; and bytes that went to the graphics
/// card, and in how many frames.
#[derive(Clone, Default)]
struct Sliders(Arc<Mutex<Vec<(String, Rect)>>>, Arc<[AtomicU64; 2]>);

impl Sliders {
    fn get(&self) -> Vec<(String, Rect)> {
        let found = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        found.clone()
    }

    fn uploaded(&self) -> [u64; 2] {
        [0, 1].map(|i| self.1[i].load(Ordering::Relaxed))
    }
}

impl Plugin for Sliders {
    fn debug_name(&self) -> &'static str {
        "sliders"
    }

    fn output_hook(&mut self, _: &Context, output: &mut FullOutput) {
        let deltas = output.textures_delta.set.values().flatten();
        let bytes = deltas.map(|delta| {
            let [width, height] = delta.image.size();
            4 * (width * height) as u64
        });
        let bytes: u64 = bytes.sum();
        for (sum, part) in self.1.iter().zip([bytes, u64::from(bytes > 0)]) {
            sum.fetch_add(part, Ordering::Relaxed);
        }
        let Some(update) = &output.platform_output.accesskit_update else {
            return;
        };
        let sliders = update.nodes.iter().filter_map(|(_, node)| {
            let bounds = node.bounds().filter(|_| node.role() == Role::Slider)?;
            let corner = |x: f64, y: f64| Pos2::new(x as f32, y as f32);
            let rect =
                Rect::from_min_max(corner(bounds.x0, bounds.y0), corner(bounds.x1, bounds.y1));
            Some((node.label().unwrap_or_default().to_owned(), rect))
        });
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = sliders.collect();
    }
}

/// What the script is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    Opening,
    Selecting,
    Orbiting,
    Dragging,
    Resizing,
    Settling,
    Growing,
    Pausing,
    Paused,
    Finishing,
    Done,
    Over,
}

struct Driver {
    app: App,
    sliders: Sliders,
    stage: Stage,
    since: Instant,
    /// Seconds of each frame, by what was done.
    times: [Vec<f64>; 3],
    /// Seconds of the processor for each, the swap included.
    busy: [Vec<f64>; 3],
    /// What the thread had of the processor when the frame began.
    before: Option<f64>,
    /// Bytes that had gone to the graphics card when the picture was left alone, and in how many frames.
    uploaded: [u64; 2],
    /// Where the pointer holds something.
    held: Option<Pos2>,
}

impl Driver {
    fn enter(&mut self, stage: Stage) {
        (self.stage, self.since) = (stage, Instant::now());
    }

    fn press(&mut self, raw: &mut RawInput, at: Pos2) {
        raw.events.push(Event::PointerMoved(at));
        raw.events.push(button(at, true));
        self.held = Some(at);
    }

    fn release(&mut self, raw: &mut RawInput) {
        if let Some(at) = self.held.take() {
            raw.events.push(button(at, false));
        }
    }

    /// Input of a frame.
    fn act(&mut self, ctx: &Context, raw: &mut RawInput) {
        let elapsed = self.since.elapsed().as_secs_f64();
        let middle = Pos2::new(500.0, 520.0);
        match self.stage {
            Stage::Opening => {
                let status = self.app.session().status();
                if status.activity == Activity::Rendering && elapsed > 3.0 {
                    self.press(raw, middle);
                    ctx.enable_accesskit();
                    self.enter(Stage::Selecting);
                }
            }
            Stage::Selecting => {
                self.release(raw);
                if elapsed > 1.0 {
                    ctx.disable_accesskit();
                    self.press(raw, middle);
                    self.enter(Stage::Orbiting);
                }
            }
            Stage::Orbiting => {
                let (sin, cos) = (elapsed * 2.0).sin_cos();
                let at = middle + egui::vec2(150.0 * sin as f32, 100.0 * (1.0 - cos as f32));
                raw.events.push(Event::PointerMoved(at));
                self.held = Some(at);
                if elapsed > THIRD {
                    self.release(raw);
                    self.enter(Stage::Dragging);
                }
            }
            Stage::Dragging => self.drag(raw, elapsed),
            Stage::Resizing => {
                let share = 0.75 + 0.25 * (elapsed * 1.5).cos() as f32;
                let size = egui::vec2(SIZE[0] * share, SIZE[1] * share);
                ctx.send_viewport_cmd(ViewportCommand::InnerSize(size));
                if elapsed > THIRD {
                    self.report();
                    ctx.send_viewport_cmd(ViewportCommand::InnerSize(SIZE.into()));
                    self.enter(Stage::Settling);
                }
            }
            Stage::Settling if elapsed > 2.0 => {
                self.uploaded = self.sliders.uploaded();
                self.enter(Stage::Growing);
            }
            Stage::Growing if elapsed > WATCHED as f64 => {
                let [bytes, frames] = self.sliders.uploaded();
                println!(
                    "growing: {:.1} MB and {:.1} uploads per second to the graphics card",
                    (bytes - self.uploaded[0]) as f64 * 1e-6 / elapsed,
                    (frames - self.uploaded[1]) as f64 / elapsed
                );
                self.enter(Stage::Pausing);
            }
            Stage::Settling | Stage::Growing => {}
            Stage::Pausing => {
                raw.events.push(space());
                self.watch(ctx, Stage::Paused);
            }
            Stage::Finishing => {
                if elapsed < 0.1 {
                    raw.events.push(space());
                    self.since -= Duration::from_secs(1);
                } else if self.held.is_none() {
                    let samples = self.sliders.get();
                    let samples = samples.iter().find(|(name, _)| name == "Samples");
                    if let Some((_, rect)) = samples {
                        self.press(raw, rect.left_center() + egui::vec2(2.0, 0.0));
                    }
                } else if self.app.session().status().activity == Activity::Done {
                    self.release(raw);
                    self.watch(ctx, Stage::Done);
                }
            }
            Stage::Paused | Stage::Done => {}
            Stage::Over => ctx.send_viewport_cmd(ViewportCommand::Close),
        }
    }

    /// Drags each slider from end to end and back, one after another from below: the dear end of
    /// depth and samples comes last.
    fn drag(&mut self, raw: &mut RawInput, elapsed: f64) {
        let sliders = self.sliders.get();
        let each = THIRD / sliders.len().max(1) as f64;
        let along = elapsed / each;
        let Some((_, rect)) = sliders.iter().rev().nth(along as usize) else {
            self.release(raw);
            return self.enter(Stage::Resizing);
        };
        let share = 0.5 + 0.5 * (along.fract() * std::f64::consts::TAU).cos();
        let at = rect.left_center() + egui::vec2(rect.width() * share as f32, 0.0);
        let is_next = self.held.is_some_and(|held| held.y != at.y);
        if is_next {
            self.release(raw);
        } else if self.held.is_none() {
            self.press(raw, at);
        } else {
            raw.events.push(Event::PointerMoved(at));
            self.held = Some(at);
        }
    }

    fn report(&self) {
        let heading = ["", "frames", "median", "99 %", "worst"];
        let [what, frames, median, most, worst] = heading;
        println!(
            "{what:<12}{frames:>8}{median:>9}{most:>9}{worst:>9}  ms of a frame, without the swap"
        );
        let [all, busy] = [&self.times, &self.busy].map(|times| times.concat());
        let rows = ["orbiting", "dragging", "resizing"].iter().zip(&self.times);
        let busy = [(&"processor", &busy)].into_iter();
        let busy = busy.filter(|(_, times)| !times.is_empty());
        for (name, times) in rows.chain([(&"all", &all)]).chain(busy) {
            let mut times = times.clone();
            times.sort_by(f64::total_cmp);
            let at = |share: f64| {
                let i = (times.len().saturating_sub(1) as f64 * share) as usize;
                times.get(i).map_or(f64::NAN, |t| t * 1e3)
            };
            let [median, most, worst] = [0.5, 0.99, 1.0].map(at);
            println!(
                "{name:<12}{:>8}{median:>9.2}{most:>9.2}{worst:>9.2}",
                times.len()
            );
        }
    }

    /// Watches the window rest.
    fn watch(&mut self, ctx: &Context, stage: Stage) {
        self.enter(stage);
        let ctx = ctx.clone();
        let watch = move || {
            // What was begun comes to its end first.
            std::thread::sleep(Duration::from_secs(3));
            let before = processor_seconds();
            std::thread::sleep(Duration::from_secs(WATCHED));
            let what = format!("{stage:?}").to_lowercase();
            match before.zip(processor_seconds()) {
                Some((before, after)) => println!(
                    "{what}: {:.2} s of processor time in {WATCHED} s",
                    after - before
                ),
                None => println!("{what}: this system does not tell the processor time"),
            }
            ctx.data_mut(|d| d.insert_temp(egui::Id::NULL, true));
            ctx.request_repaint();
        };
        let thread = std::thread::Builder::new().name("watch".into());
        thread.spawn(watch).expect("a thread");
    }
}

impl eframe::App for Driver {
    fn raw_input_hook(&mut self, ctx: &Context, raw: &mut RawInput) {
        self.act(ctx, raw);
    }

    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        // That of the frame before, which is the same stage but for three frames of thousands.
        let place = match self.stage {
            Stage::Orbiting => Some(0),
            Stage::Dragging => Some(1),
            Stage::Resizing => Some(2),
            _ => None,
        };
        if let (Some(i), Some(seconds)) = (place, frame.info().cpu_usage) {
            self.times[i].push(f64::from(seconds));
        }
        let now = thread_seconds();
        if let (Some(i), Some(now), Some(before)) = (place, now, self.before) {
            self.busy[i].push(now - before);
        }
        self.before = now;
        self.app.ui(ui, frame);
        let watched = ui.data_mut(|d| d.remove_temp::<bool>(egui::Id::NULL));
        match (self.stage, watched) {
            (Stage::Paused, Some(true)) => self.enter(Stage::Finishing),
            (Stage::Done, Some(true)) => self.enter(Stage::Over),
            _ => {}
        }
        if !matches!(self.stage, Stage::Paused | Stage::Done) {
            ui.ctx().request_repaint();
        }
    }
}

fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    }
}

fn space() -> Event {
    Event::Key {
        key: Key::Space,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::NONE,
    }
}

/// Of this thread since its start.
fn thread_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(stat.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9)
}

/// Of all threads since the start.
fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name in brackets may have spaces.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |i: usize| fields.get(i)?.parse::<f64>().ok();
    // In hundredths of a second on every Linux.
    Some((ticks(11)? + ticks(12)?) / 100.0)
}
