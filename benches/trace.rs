//! Rays per second of the witness: `cargo bench --bench trace`.
//!
//! A pair is a camera ray with the shadow test of its reflected ray: rays given; outcome, facet and
//! direction out.

use morion::internals::brep::Body;
use morion::internals::design::{Design, design};
use morion::internals::export::step::{StepSchema, fit_splines, write_step};
use morion::internals::export::{Label, read_stl, write_stl};
use morion::internals::geom::{DVec3, Precision, Ray, TriMesh};
use morion::internals::mesh::{Limits, mesh};
use morion::internals::optics::{Calibration, Distortion};
use morion::internals::pipeline::load;
use morion::internals::profile::{CalibrationFile, LensModel, Profile};
use morion::internals::solid::Solid;
use morion::internals::trace::{
    BodyScene, CameraTrace, Obstacles, Outcome, RayEnd, Scene, TraceCounts,
};
use std::error::Error;
use std::fs::{self, File};
use std::hint::black_box;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

// As the program's own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const USAGE: &str = "\
cargo bench --bench trace -- [OPTIONS]

    --profile NAME  shipped profile or profile file [default: conquistador]
    --stl FILE      the profile's mirror as a build wrote it [default: made in memory]
    --step FILE     curved faces in the place of a mesh: those of the profile's STEP file as a build wrote it, or made in
                    memory for `-`
    --runs K        the fastest counts [default: 9]
    --dump FOLDER   mesh, rays and what became of them for other programs, as plain little-endian
                    numbers: vertices.f64, triangles.u32 (none of curved faces), rays.f64 (origin, direction), found.f64
                    (outcome: 0 reflected, 1 missed, 2 shadowed, 3 back face, 4 + k behind the
                    profile's obstacle k, from 0; facet; distance; direction), and morion.txt with our times
    --calibration FILE
                    reads a calibration of a camera, and nothing else: of the pixels in FOLDER/pixels.f64
                    (x, y in OpenCV's convention) the rays X / Z, Y / Z in FOLDER/rays.f64, and what was read in
                    FOLDER/calibration.f64 (width, height, fx, fy, cx, cy in Morion's convention, and the
                    distortion coefficients in OpenCV's order)
    --model MODEL   of the calibration: opencv or fisheye [default: what the file says]
";

struct Options {
    profile: String,
    stl: Option<String>,
    step: Option<String>,
    runs: usize,
    dump: Option<String>,
    calibration: Option<String>,
    model: Option<LensModel>,
}

impl Options {
    fn parse() -> Result<Self, String> {
        let mut options = Self {
            profile: "conquistador".into(),
            stl: None,
            step: None,
            runs: 9,
            dump: None,
            calibration: None,
            model: None,
        };
        let mut arguments = std::env::args().skip(1);
        let mut measured = false;
        while let Some(name) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{name} needs a value"));
            match name.as_str() {
                "--profile" => options.profile = value()?,
                "--stl" => options.stl = Some(value()?),
                "--runs" => {
                    let runs = value()?;
                    options.runs = runs.parse().map_err(|_| format!("{runs} is no number"))?;
                }
                "--dump" => options.dump = Some(value()?),
                "--calibration" => options.calibration = Some(value()?),
                "--model" => {
                    options.model = Some(match value()?.as_str() {
                        "opencv" => LensModel::OpenCv,
                        "fisheye" => LensModel::Fisheye,
                        other => return Err(format!("{other} is no model")),
                    });
                }
                "--step" => options.step = Some(value()?),
                "--bench" => measured = true,
                _ => return Err(format!("{name}?\n\n{USAGE}")),
            }
        }
        // Without cargo's `--bench` this is a test that it runs.
        if !measured {
            options.runs = 1;
        }
        options.runs = options.runs.max(1);
        Ok(options)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse().unwrap_or_else(|complaint| {
        eprintln!("{complaint}");
        std::process::exit(2)
    });
    if let Some(calibration) = &options.calibration {
        let folder = options.dump.as_ref().ok_or("--calibration needs --dump")?;
        return rays(calibration, options.model, Path::new(folder));
    }
    if let Some(step) = &options.step {
        return curved(&options, step);
    }
    let (design, mesh) = made(&options.profile, options.stl.as_deref())?;
    let [columns, rows] = design.camera.pixels;
    println!("{}: {} triangles, {columns} x {rows} rays", options.profile, mesh.triangles.len());
    let obstacles = Obstacles::new(&design.obstacles, design.view.as_ref()).map(Arc::new);
    let among = |mesh: TriMesh| Scene::new(mesh).among(obstacles.clone());
    let scene = among(mesh);
    let top = scene.above_mm();
    let mut lines = Vec::new();
    let mut found = Vec::new();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        pool.install(|| {
            let copy = || scene.mesh().clone();
            let plain = || among(copy());
            let general = least(options.runs, copy, |mesh| {
                black_box(Scene::new(mesh.clone()));
            });
            lines.push(format!("build_general_{threads} {general:.3} ms"));
            let trace = CameraTrace::new(&scene, &design.camera, top);
            let (mut ends, counts) = trace.run();
            let first = least(options.runs, plain, |scene| {
                black_box(CameraTrace::new(scene, &design.camera, top).run_into(&mut ends));
            });
            let next = least(
                options.runs,
                || (),
                |()| {
                    black_box(trace.run_into(&mut ends));
                },
            );
            lines.push(format!("build_proofs_{threads} {:.3} ms", (first - next).max(0.0)));
            let all = trace.without_shortcuts();
            let slow = least(options.runs.min(3), || (), |()| drop(black_box(all.run())));
            let pairs = ends.len() as f64;
            let rate = |ms: f64| pairs / ms * 1e-3;
            lines.push(format!("pairs_{threads} {:.3} M/s ({next:.3} ms)", rate(next)));
            lines.push(format!("pairs_without_shortcuts_{threads} {:.3} M/s", rate(slow)));
            if threads == 1 {
                let TraceCounts { rasterized, searched, proven, followed } = counts;
                println!(
                    "{rasterized} rasterized, {searched} searched; {proven} proven, {followed} followed"
                );
            }
            found = ends;
        });
    }
    let times = lines.join("\n") + "\n";
    print!("{times}");
    if let Some(folder) = &options.dump {
        let trace = CameraTrace::new(&scene, &design.camera, top);
        dump(Path::new(folder), Some(scene.mesh()), (&trace, &found))?;
        fs::write(Path::new(folder).join("morion.txt"), times)?;
    }
    Ok(())
}

/// Times of the rays against the curved faces of a STEP file of the profile.
fn curved(options: &Options, step: &str) -> Result<(), Box<dyn Error>> {
    let design = design(&load(&options.profile)?)?;
    let mut bytes = Vec::new();
    if step == "-" {
        let fit = fit_splines(&design.mirror)?;
        write_step(
            &mut bytes,
            &fit,
            design.features(),
            &StepSchema::Ap214,
            &label(&design.profile),
        )?;
    } else {
        bytes = fs::read(step).map_err(|error| format!("{step}: {error}"))?;
    }
    let obstacles = Obstacles::new(&design.obstacles, design.view.as_ref()).map(Arc::new);
    let scene = BodyScene::new(Body::read(&bytes)?, obstacles);
    let [columns, rows] = design.camera.pixels;
    let pieces = scene.body().pieces().len();
    println!("{}: {pieces} pieces of curved faces, {columns} x {rows} rays", options.profile);
    let trace = CameraTrace::new(&scene, &design.camera, scene.above_mm());
    let (mut ends, counts) = trace.run();
    println!("{} proven, {} followed", counts.proven, counts.followed);
    let mut lines = Vec::new();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        pool.install(|| {
            let ms = least(
                options.runs,
                || (),
                |()| {
                    black_box(trace.run_into(&mut ends));
                },
            );
            let rate = ends.len() as f64 / ms * 1e-3;
            lines.push(format!("curved_pairs_{threads} {rate:.3} M/s ({ms:.3} ms)"));
        });
    }
    let times = lines.join("\n") + "\n";
    print!("{times}");
    if let Some(folder) = &options.dump {
        dump(Path::new(folder), None, (&trace, &ends))?;
        fs::write(Path::new(folder).join("morion.txt"), times)?;
    }
    Ok(())
}

/// The words of a file.
fn label(profile: &Profile) -> Label {
    Label {
        profile: profile.name.clone(),
        sha256: profile.sha256.clone(),
        tolerances: String::new(),
        mounting: Vec::new(),
    }
}

/// The mesh of the STL file that the profile makes, or of one that was written, as it is read back.
fn made(profile: &str, stl: Option<&str>) -> Result<(Design, TriMesh), Box<dyn Error>> {
    let profile = &load(profile)?;
    let design = design(profile)?;
    if let Some(stl) = stl {
        let bytes = fs::read(stl).map_err(|error| format!("{stl}: {error}"))?;
        return Ok((design, read_stl(&bytes)?.mesh));
    }
    let limits = Limits {
        chord_mm: profile.mesh.chord_um().map(|um| um * 1e-3),
        facet_mm: profile.mesh.facet_px().map(|px| px * design.camera.pixel_mm),
        precision: Precision::Single,
    };
    let face = mesh(&design.mirror, &design.camera.chart, design.view.as_ref(), limits)?;
    let solid = Solid::from_face(&face.mesh, design.features(), Precision::Single)?;
    let mut bytes = Vec::new();
    write_stl(&mut bytes, &solid, &label(profile))?;
    Ok((design, read_stl(&bytes)?.mesh))
}

/// The least time of `runs` in ms, each with something new.
fn least<T>(runs: usize, new: impl Fn() -> T, mut run: impl FnMut(&T)) -> f64 {
    let times = (0..runs).map(|_| {
        let with = new();
        let start = Instant::now();
        run(&with);
        start.elapsed().as_secs_f64() * 1e3
    });
    times.fold(f64::INFINITY, f64::min)
}

fn dump(
    folder: &Path,
    mesh: Option<&TriMesh>,
    (trace, found): (&CameraTrace, &[RayEnd]),
) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let numbers = |name: &str, all: &mut dyn Iterator<Item = f64>| numbers(folder, name, all);
    if let Some(mesh) = mesh {
        numbers("vertices.f64", &mut mesh.vertices.iter().flat_map(DVec3::to_array))?;
        let triangles: Vec<u8> =
            mesh.triangles.iter().flatten().flat_map(|vertex| vertex.to_le_bytes()).collect();
        fs::write(folder.join("triangles.u32"), triangles)?;
    }
    let [columns, rows] = trace.pixels();
    let rays = (0..columns * rows).map(|k| trace.ray(k % columns, k / columns));
    numbers(
        "rays.f64",
        &mut rays.flat_map(|Ray { origin, direction }| {
            origin.to_array().into_iter().chain(direction.to_array())
        }),
    )?;
    let outcome = |outcome: Outcome| match outcome {
        Outcome::Hit => 0.0,
        Outcome::Missed => 1.0,
        Outcome::Shadowed(_) => 2.0,
        Outcome::BackFace => 3.0,
        Outcome::Obstructed(number) => 4.0 + f64::from(number),
    };
    numbers(
        "found.f64",
        &mut found.iter().flat_map(|seen| {
            let facet = if seen.facet == RayEnd::NO_FACET { -1.0 } else { f64::from(seen.facet) };
            let [x, y, z] = seen.direction.to_array();
            [outcome(seen.outcome), facet, seen.t, x, y, z]
        }),
    )
}

fn numbers(
    folder: &Path,
    name: &str,
    all: &mut dyn Iterator<Item = f64>,
) -> Result<(), Box<dyn Error>> {
    let mut out = BufWriter::new(File::create(folder.join(name))?);
    for number in all {
        out.write_all(&number.to_le_bytes())?;
    }
    Ok(out.flush()?)
}

/// What is read of a calibration, and the rays of the pixels in `folder`.
fn rays(file: &str, model: Option<LensModel>, folder: &Path) -> Result<(), Box<dyn Error>> {
    let read = CalibrationFile::parse(&fs::read(file)?)?;
    let calibration = read.calibration(model, None)?;
    calibration.check()?;
    let Calibration { pixels, focal_px, principal_px, distortion } = calibration;
    let coefficients = match distortion {
        Distortion::None => Vec::new(),
        Distortion::BrownConrady { radial: [k1, k2, far @ ..], tangential, prism } => {
            [&[k1, k2], &tangential[..], &far, &prism].concat()
        }
        Distortion::KannalaBrandt { radial } => radial.to_vec(),
    };
    let frame = pixels.map(f64::from).into_iter().chain(focal_px).chain(principal_px);
    numbers(folder, "calibration.f64", &mut frame.chain(coefficients))?;
    let bytes = fs::read(folder.join("pixels.f64"))?;
    let (numbers_read, _) = bytes.as_chunks::<8>();
    let (pixels, _) = numbers_read.as_chunks::<2>();
    let ray = |pixel: &[[u8; 8]; 2]| calibration.ray(pixel.map(|x| f64::from_le_bytes(x) + 0.5));
    let rays = pixels.iter().map(ray).collect::<Result<Vec<_>, _>>()?;
    numbers(folder, "rays.f64", &mut rays.into_iter().flatten())
}
