//! Triangles, time and memory of the mesher against the tolerance: `cargo bench --bench mesh`.
//!
//! Every mesh is made in a process of its own, so that nothing is left in its heap by another.

#[path = "../tests/it/support/surfaces.rs"]
mod surfaces;

use morion::internals::geom::{Outline, Precision};
use morion::internals::mesh::Face;
use morion::internals::mirror::{Mirror, Surface};
use morion::internals::num::log;
use serde_json::{Value, json};
use std::error::Error;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use surfaces::{Case, ENOUGH, Listed, Rule, listed};

// As the program's own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const USAGE: &str = "\
cargo bench --bench mesh -- [OPTIONS]

    --to N          largest number of triangles, up to 1e7 [default: 1e6]
    --runs K        of each mesh, at most; the fastest counts [default: 5]
    --only NAME     one surface
    --quick         up to 1e5 triangles, two runs
    --economy       the table of economy alone
    --write FOLDER  meshes and surfaces for other programs instead, chord governed
    --chord-um UM   their tolerance [default: 1]
";

/// Numbers of triangles grow by this.
const STEP: f64 = 3.162_277_660_168_379_5;
const FIRST: f64 = 1e4;
/// Repeating a mesh ends here.
const LONGEST_REPEAT: Duration = Duration::from_secs(8);
/// Times of smaller meshes are mostly overhead, and no part of the fit.
const FITTED: f64 = 5e4;

struct Options {
    to: f64,
    runs: usize,
    only: Option<String>,
    economy: bool,
    write: Option<String>,
    chord_um: f64,
    /// Index and limit of the one mesh that this process is to make.
    one: Option<(usize, f64)>,
}

impl Options {
    fn parse() -> Result<Self, String> {
        let mut options = Self {
            to: 1e6,
            runs: 5,
            only: None,
            economy: false,
            write: None,
            chord_um: 1.0,
            one: None,
        };
        let mut arguments = std::env::args().skip(1);
        let mut quick = true;
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
            let number = |text: String| text.parse().map_err(|_| format!("{text} is no number"));
            match name.as_str() {
                "--to" => options.to = number(value()?)?,
                "--runs" => options.runs = number(value()?)?.max(1.0) as usize,
                "--only" => options.only = Some(value()?),
                "--economy" => options.economy = true,
                "--quick" => (options.to, options.runs) = (1e5, 2),
                "--write" => options.write = Some(value()?),
                "--chord-um" => options.chord_um = number(value()?)?,
                "--one" => options.one = Some((number(value()?)? as usize, number(value()?)?)),
                "--bench" => quick = false,
                _ => return Err(format!("{name}?\n\n{USAGE}")),
            }
        }
        // Without cargo's `--bench` this is a test that it runs.
        if quick && options.one.is_none() {
            (options.to, options.runs) = (FIRST, 1);
        }
        Ok(options)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse().unwrap_or_else(|complaint| {
        eprintln!("{complaint}");
        std::process::exit(2)
    });
    let mut surfaces: Vec<(usize, Listed)> = listed().into_iter().enumerate().collect();
    if let Some((index, limit)) = options.one {
        println!("{}", measure(&surfaces[index].1.case(), limit, options.runs));
        return Ok(());
    }
    if let Some(only) = &options.only {
        surfaces.retain(|(_, listed)| listed.name == only);
        if surfaces.is_empty() {
            return Err(format!("no surface is called {only}").into());
        }
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    if let Some(folder) = &options.write {
        let chord = surfaces.into_iter().filter(|(_, listed)| listed.rule == Rule::Chord);
        let cases: Vec<Case> = chord.map(|(_, listed)| listed.case()).collect();
        return write(&cases, Path::new(folder), 1e-3 * options.chord_um, options.runs);
    }
    println!("morion {}, {cores} logical cores\n", env!("CARGO_PKG_VERSION"));
    if !options.economy {
        for (index, listed) in &surfaces {
            sweep(*index, &listed.case(), &options)?;
        }
    }
    if options.to >= ENOUGH {
        economy(surfaces.into_iter().map(|(_, listed)| listed));
    }
    Ok(())
}

/// Meshes at one limit; the first of the runs tells the memory.
fn measure(case: &Case, limit: f64, runs: usize) -> Value {
    let began = Instant::now();
    // The threads are there before the memory is counted.
    rayon::broadcast(|_| ());
    let before = memory("VmRSS:");
    let (mut best, mut peak) = (f64::INFINITY, None);
    let mut outcome = Value::Null;
    for run in 0..runs {
        let (seconds, made) = timed(|| case.mesh(limit, Precision::Double));
        if run == 0 {
            peak = memory("VmHWM:").zip(before).map(|(peak, before)| peak - before);
        }
        best = best.min(seconds);
        outcome = match made {
            Ok(face) => json!({
                "triangles": face.mesh.triangles.len(),
                "over": case.over(&face, limit),
                "bound_mm": proven(case, &face),
            }),
            Err(error) => return json!({ "error": error.to_string() }),
        };
        if began.elapsed() > LONGEST_REPEAT {
            break;
        }
    }
    outcome["seconds"] = json!(best);
    outcome["peak_bytes"] = json!(peak);
    outcome
}

/// The proven bound of the error that governs, mm.
fn proven(case: &Case, face: &Face) -> f64 {
    match case.rule {
        Rule::Chord => face.bound.chord_mm,
        Rule::Facet => face.bound.facet_mm,
    }
}

fn timed<T>(make: impl FnOnce() -> T) -> (f64, T) {
    let began = Instant::now();
    let made = make();
    (began.elapsed().as_secs_f64(), made)
}

/// One of this process's figures of memory, bytes, where the system tells it.
fn memory(figure: &str) -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(figure))?;
    let kilobytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kilobytes)
}

/// [`measure`] in a new process.
fn measure_in_child(index: usize, limit: f64, runs: usize) -> Result<Value, Box<dyn Error>> {
    let arguments =
        ["--one", &index.to_string(), &format!("{limit:e}"), "--runs", &runs.to_string()];
    let child =
        Command::new(std::env::current_exe()?).args(arguments).stderr(Stdio::inherit()).output()?;
    match child.status.success() {
        true => Ok(serde_json::from_slice(&child.stdout)?),
        false => Ok(json!({ "error": child.status.to_string() })),
    }
}

/// The table of one surface.
fn sweep(index: usize, case: &Case, options: &Options) -> Result<(), Box<dyn Error>> {
    println!("{}, {} governed\n", case.name, case.rule.name());
    println!("| limit um | N | N / least | bound / limit | s | million / s | peak bytes / N |");
    println!("|---|---|---|---|---|---|---|");
    let mut limit = case.usual_mm;
    // The first mesh only tells where to start.
    let probe = measure_in_child(index, limit, 1)?;
    let mut found = probe["triangles"].as_f64().unwrap_or(FIRST);
    let mut wanted = FIRST;
    let mut points = Vec::new();
    while wanted <= options.to * 1.01 {
        limit = case.rule.towards(limit, found, wanted);
        let made = measure_in_child(index, limit, options.runs)?;
        if let Some(error) = made["error"].as_str() {
            println!("| {:.3e} | {error} | | | | | |", 1e3 * limit);
            break;
        }
        let figure = |name: &str| made[name].as_f64();
        let known = |name: &str| figure(name).ok_or(format!("no {name}"));
        found = known("triangles")?;
        let seconds = known("seconds")?;
        let or_dash = |value: Option<f64>, digits: usize| {
            value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
        };
        println!(
            "| {:.3e} | {found} | {} | {:.4} | {seconds:.4} | {:.2} | {} |",
            1e3 * limit,
            or_dash(figure("over"), 3),
            known("bound_mm")? / limit,
            1e-6 * found / seconds,
            or_dash(figure("peak_bytes").map(|peak| peak / found), 0),
        );
        points.push((log(found), log(seconds)));
        wanted *= STEP;
    }
    points.retain(|point| point.0 > log(FITTED));
    match points.len() {
        0 | 1 => println!(),
        _ => println!("\ntime ~ N^{:.3}\n", exponent(&points)),
    }
    Ok(())
}

/// The slope of the straight line nearest to the points.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let x = points.iter().map(|p| p.0).sum::<f64>() / count;
    let y = points.iter().map(|p| p.1).sum::<f64>() / count;
    let across: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    across / points.iter().map(|p| (p.0 - x) * (p.0 - x)).sum::<f64>()
}

/// The surfaces that have a target, against it.
fn economy(surfaces: impl Iterator<Item = Listed>) {
    println!("Economy, for files in single precision, {ENOUGH:.0} triangles or more\n");
    println!("| surface | rule | limit um | N | N / least | target | |");
    println!("|---|---|---|---|---|---|---|");
    for listed in surfaces {
        let (name, rule) = (listed.name, listed.rule.name());
        let Some(most) = listed.most else { continue };
        let case = listed.case();
        let (limit, face) = match case.enough() {
            Ok(made) => made,
            Err(error) => {
                println!("| {name} | {rule} | | {error} | | {most:.2} | missed |");
                continue;
            }
        };
        let over = case.over(&face, limit).unwrap_or(f64::NAN);
        let word = if over <= most { "met" } else { "missed" };
        let count = face.mesh.triangles.len();
        let um = 1e3 * limit;
        println!("| {name} | {rule} | {um:.4} | {count} | {over:.3} | {most:.2} | {word} |");
    }
}

/// Writes the chord-governed sheets and their meshes, one panel each, into `folder`.
fn write(cases: &[Case], folder: &Path, limit: f64, runs: usize) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let mut surfaces = Vec::new();
    for case in cases {
        let Surface::Tensor(sheet) = &case.mirror.surface else { continue };
        let Outline::Rect(rect) = case.mirror.outline else { continue };
        let mut best = f64::INFINITY;
        let mut face = None;
        for _ in 0..runs {
            let (seconds, made) = timed(|| case.mesh(limit, Precision::Double));
            best = best.min(seconds);
            face = Some(made?);
        }
        let face = face.ok_or("no runs")?;
        let panels = face.mesh.triangles.len() as f64 / face.designed as f64;
        let (rows, columns) = sheet.series.shape();
        let row = |i: usize| (0..columns).map(|j| sheet.series.coefficient(i, j)).collect();
        let coefficients: Vec<Vec<f64>> = (0..rows).map(row).collect();
        surfaces.push(json!({
            "name": case.name,
            "rect": [rect.min.to_array(), rect.max.to_array()],
            "centre": sheet.centre.to_array(),
            "half": sheet.half.to_array(),
            "scale_mm": sheet.scale_mm,
            "z_mm": offset(&case.mirror),
            "coefficients": coefficients,
            "limit_mm": limit,
            "least": case.least(&face, limit).map(|least| least / panels),
            "triangles": face.designed,
            "bound_mm": face.bound.chord_mm,
            "seconds": best,
        }));
        ply(&folder.join(format!("{}.ply", case.name)), &face)?;
    }
    fs::write(folder.join("surfaces.json"), serde_json::to_string(&surfaces)?)?;
    Ok(())
}

/// Z of the mirror less what its series gives, mm.
fn offset(mirror: &Mirror) -> f64 {
    let q = mirror.outline.bounds().centre();
    let point = mirror.surface.at(q);
    mirror.position(q, &point).z - point.f
}

/// The designed panel as binary PLY with every digit.
fn ply(path: &Path, face: &Face) -> std::io::Result<()> {
    let panel = &face.mesh.triangles[..face.designed];
    let mut out = BufWriter::new(File::create(path)?);
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "element vertex {}", face.mesh.vertices.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    writeln!(out, "element face {}", panel.len())?;
    writeln!(out, "property list uchar uint vertex_indices\nend_header")?;
    for digit in face.mesh.vertices.iter().flat_map(|v| v.to_array()) {
        out.write_all(&digit.to_le_bytes())?;
    }
    for triangle in panel {
        out.write_all(&[3])?;
        for corner in triangle {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    out.flush()
}
