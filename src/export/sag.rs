//! Sag table: places of the designed mirror and its normals there, for diamond turning and for
//! coordinate measuring machines.

use super::Label;
use super::text::{ByteCounter, lines};
use crate::geom::{DVec2, DVec3, Outline, ScanPath, ScanPattern, angle};
use crate::mirror::Mirror;
use crate::num::{cos, max_or_nan, sin};
use crate::parallel;
use std::f64::consts::PI;
use std::io::{self, Write};
use thiserror::Error;

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SagRow {
    /// A place of the mirror, mm.
    pub at: DVec3,
    /// Its unit normal there.
    pub normal: DVec3,
}

/// Reason why a table could not be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("line {line}: a row must hold six finite numbers, found {found:?}")]
pub struct SagError {
    /// Line, from 1.
    pub line: usize,
    /// What stands there, cut short.
    pub found: String,
}

/// Largest deviations of a table from a mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SagDeviation {
    /// Largest difference of Z, mm.
    pub height_mm: f64,
    /// Largest angle between normals, radians.
    pub normal_rad: f64,
}

/// Titles of the columns.
const TITLES: &str = "X_mm,Y_mm,Z_mm,NX,NY,NZ";
/// Points that are evaluated at a time.
const BATCH: usize = 1 << 16;
/// Points of a spiral that are listed together.
const TURN: usize = 1024;
/// Points of which [`sag_bytes`] counts all.
const COUNTED: f64 = 2e5;

/// Writes rows of X, Y, Z (mm) and the unit normal along `path`, as far as it lies on `mirror`, all
/// panels, with nine decimals: Z and normal are those of X and Y as they are written. The header
/// is of comments that begin with `#`, `notes` among them, and one line of titles. On the ridge of a
/// folded mirror the normals are the designed panel's.
///
/// # Errors
/// Whatever `out` returns, flushing included.
pub fn write_sag(
    out: &mut impl Write,
    mirror: &Mirror,
    path: &ScanPath,
    label: &Label,
    notes: &[String],
) -> io::Result<()> {
    header(out, path, label, notes)?;
    let mut rows = RowWriter { mirror, pending: Vec::new(), out };
    walk(path, mirror, |line| rows.add(line))?;
    rows.flush()?;
    out.flush()
}

fn header(
    out: &mut impl Write,
    path: &ScanPath,
    label: &Label,
    notes: &[String],
) -> io::Result<()> {
    let Label { profile, sha256, tolerances, .. } = label;
    writeln!(out, "# Morion: profile {}, sha256 {sha256}", Label::plain(profile))?;
    writeln!(out, "# millimetres; mesh files: {}", Label::plain(tolerances))?;
    writeln!(
        out,
        "# part frame: X right in the picture, Y up in it, Z towards the camera; base at Z = 0"
    )?;
    let ScanPath { pattern, pitch_mm, step_mm } = path;
    match pattern {
        ScanPattern::Raster => {
            writeln!(out, "# raster: lines along X, pitch {pitch_mm}, step {step_mm}")?;
        }
        ScanPattern::Spiral => {
            writeln!(out, "# spiral: about the axis inwards, pitch {pitch_mm}, step {step_mm}")?;
        }
    }
    for note in label.mounting.iter().chain(notes) {
        writeln!(out, "# {}", Label::plain(note))?;
    }
    writeln!(out, "{TITLES}")
}

/// The mirror's rows, evaluated many lines at a time.
struct RowWriter<'a, W> {
    mirror: &'a Mirror,
    pending: Vec<Vec<DVec2>>,
    out: &'a mut W,
}

impl<W: Write> RowWriter<'_, W> {
    fn add(&mut self, line: Vec<DVec2>) -> io::Result<()> {
        self.pending.push(line);
        if self.pending.iter().map(Vec::len).sum::<usize>() < BATCH {
            return Ok(());
        }
        self.flush()
    }

    fn flush(&mut self) -> io::Result<()> {
        let pending = std::mem::take(&mut self.pending);
        let found = parallel::map_slice(&pending, 1, |line| on_mirror(self.mirror, line));
        lines(self.out, &found.concat(), row)
    }
}

fn row(text: &mut Vec<u8>, SagRow { at, normal }: &SagRow) -> io::Result<()> {
    let [x, y, z] = at.to_array().map(nine);
    let [a, b, c] = normal.to_array().map(nine);
    writeln!(text, "{x:.9},{y:.9},{z:.9},{a:.9},{b:.9},{c:.9}")
}

/// Nine decimals, and no -0.
fn nine(x: f64) -> f64 {
    (x * 1e9).round() / 1e9 + 0.0
}

/// The rows of those places that lie on the mirror, in order.
fn on_mirror(mirror: &Mirror, line: &[DVec2]) -> Vec<SagRow> {
    let outline = mirror.full_outline();
    let inside = |&p: &DVec2| {
        let on = under(mirror, p).is_some_and(|q| outline.contains(q));
        on.then(|| DVec2::new(nine(p.x), nine(p.y)))
    };
    rows(mirror, &line.iter().filter_map(inside).collect::<Vec<_>>())
}

/// The chart's coordinates of the mirror's place at (X, Y).
fn under(mirror: &Mirror, p: DVec2) -> Option<DVec2> {
    mirror.intersect_camera_ray(&mirror.chart.parallel(), p)
}

/// The mirror's rows over `places`, of which each has one.
fn rows(mirror: &Mirror, places: &[DVec2]) -> Vec<SagRow> {
    let charted: Vec<DVec2> =
        places.iter().map(|&p| under(mirror, p).unwrap_or(DVec2::NAN)).collect();
    let points = mirror.eval_many(&charted);
    let row = |((p, q), point): ((&DVec2, DVec2), _)| SagRow {
        at: p.extend(mirror.position(q, &point).z),
        normal: mirror.normal(q, &point).normalize(),
    };
    places.iter().zip(charted).zip(points).map(row).collect()
}

/// Number of places of a scan, about; those beside the mirror count too.
#[must_use]
pub fn sag_points(path: &ScanPath, mirror: &Mirror) -> f64 {
    let MirrorExtent { lo, hi, radius } = MirrorExtent::of(mirror);
    let ScanPath { pattern, pitch_mm, step_mm } = *path;
    match pattern {
        ScanPattern::Raster => {
            let steps = (hi - lo) / DVec2::new(step_mm, pitch_mm);
            (steps.x + 1.0) * (steps.y + 1.0)
        }
        ScanPattern::Spiral => PI * radius * radius / (pitch_mm * step_mm),
    }
}

/// Hands the points of a scan to `visit`, a line at a time.
fn walk(
    path: &ScanPath,
    mirror: &Mirror,
    mut visit: impl FnMut(Vec<DVec2>) -> io::Result<()>,
) -> io::Result<()> {
    let MirrorExtent { lo, hi, radius } = MirrorExtent::of(mirror);
    let ScanPath { pattern, pitch_mm, step_mm } = *path;
    match pattern {
        ScanPattern::Raster => {
            // Not the edges alone: those of a mirror whose sides are curved hardly meet it.
            let [columns, rows] = [(hi - lo).x / step_mm, (hi - lo).y / pitch_mm]
                .map(|steps| ((steps * (1.0 - 1e-12)).ceil() as usize).max(2));
            let at = |k: usize, n: usize, lo: f64, hi: f64| match k {
                _ if k == n => hi,
                _ => lo + (hi - lo) * (k as f64 / n as f64),
            };
            (0..=rows).try_for_each(|j| {
                let y = at(j, rows, lo.y, hi.y);
                let point = |i: usize| DVec2::new(at(i, columns, lo.x, hi.x), y);
                visit((0..=columns).map(point).collect())
            })
        }
        ScanPattern::Spiral => {
            let inwards = pitch_mm / (2.0 * PI);
            let (mut angle, mut line) = (0.0, Vec::with_capacity(TURN));
            loop {
                let r = (radius - inwards * angle).max(0.0);
                line.push(DVec2::new(cos(angle), sin(angle)) * r);
                if line.len() == TURN {
                    visit(std::mem::replace(&mut line, Vec::with_capacity(TURN)))?;
                }
                if r == 0.0 {
                    return visit(line);
                }
                angle += step_mm / (r * r + inwards * inwards).sqrt();
            }
        }
    }
}

/// The rectangle and the circle about the axis around a mirror, in the part frame.
struct MirrorExtent {
    lo: DVec2,
    hi: DVec2,
    radius: f64,
}

impl MirrorExtent {
    /// Places along a side or around a rim, for mirrors whose sides are not straight.
    const PLACES: usize = 256;

    fn of(mirror: &Mirror) -> Self {
        let whole = mirror.full_outline();
        let bounds = whole.bounds();
        if mirror.chart.is_plan() {
            let (lo, hi) = (bounds.min, bounds.max);
            let radius = match whole {
                Outline::Ring { outer, .. } => outer,
                Outline::Rect(_) => lo.abs().max(hi.abs()).length(),
            };
            return Self { lo, hi, radius };
        }
        let share = |k: usize| k as f64 / Self::PLACES as f64;
        let rim: Vec<DVec2> = match whole {
            Outline::Ring { outer, .. } => (0..Self::PLACES)
                .map(|k| 2.0 * PI * share(k))
                .map(|angle| DVec2::new(cos(angle), sin(angle)) * outer)
                .collect(),
            Outline::Rect(rect) => (0..=Self::PLACES)
                .map(|k| rect.min + rect.size() * share(k))
                .flat_map(|p| {
                    [
                        DVec2::new(p.x, rect.min.y),
                        DVec2::new(p.x, rect.max.y),
                        DVec2::new(rect.min.x, p.y),
                        DVec2::new(rect.max.x, p.y),
                    ]
                })
                .collect(),
        };
        let points = mirror.eval_many(&rim);
        let places =
            rim.iter().zip(&points).map(|(&q, point)| mirror.position(q, point).truncate());
        let nothing = Self { lo: DVec2::MAX, hi: DVec2::MIN, radius: 0.0 };
        places.fold(nothing, |Self { lo, hi, radius }, p| Self {
            lo: lo.min(p),
            hi: hi.max(p),
            radius: radius.max(p.length()),
        })
    }
}

/// Foresees the length of what [`write_sag`] writes: to the byte for tables of up to some hundred
/// thousand rows, for longer ones by one that is coarser.
#[must_use]
pub fn sag_bytes(mirror: &Mirror, path: &ScanPath, label: &Label, notes: &[String]) -> u64 {
    let ScanPath { pattern, pitch_mm, step_mm } = *path;
    let points = mirror.full_outline().area() / (pitch_mm * step_mm);
    let times = (points / COUNTED).max(1.0).sqrt();
    let [mut head, mut all] = [ByteCounter::default(), ByteCounter::default()];
    let coarser = ScanPath { pattern, pitch_mm: times * pitch_mm, step_mm: times * step_mm };
    // Counting cannot fail.
    let _ = header(&mut head, path, label, notes);
    let _ = write_sag(&mut all, mirror, &coarser, label, notes);
    let rows = all.count().saturating_sub(head.count());
    head.count() + (rows as f64 * times * times) as u64
}

/// Reads the rows of a table.
///
/// # Errors
/// [`SagError`], the first one.
pub fn read_sag(bytes: &[u8]) -> Result<Vec<SagRow>, SagError> {
    let mut titles = true;
    let mut rows = Vec::new();
    for (k, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        if line.is_empty() || line.starts_with(b"#") {
            continue;
        }
        if std::mem::take(&mut titles) && line == TITLES.as_bytes() {
            continue;
        }
        let row = std::str::from_utf8(line).ok().and_then(|text| {
            let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
            let [x, y, z, a, b, c] = <[f64; 6]>::try_from(numbers.ok()?).ok()?;
            let row = SagRow { at: DVec3::new(x, y, z), normal: DVec3::new(a, b, c) };
            (row.at.is_finite() && row.normal.is_finite()).then_some(row)
        });
        let Some(row) = row else {
            let found = String::from_utf8_lossy(&line[..line.len().min(80)]).into_owned();
            return Err(SagError { line: k + 1, found });
        };
        rows.push(row);
    }
    Ok(rows)
}

/// Holds every row against `mirror` at the row's X and Y; a place that the mirror does not have is
/// infinitely far off.
#[must_use]
pub fn compare_sag(found: &[SagRow], mirror: &Mirror) -> SagDeviation {
    let worst = |chunk: &[SagRow]| {
        let places: Vec<DVec2> = chunk.iter().map(|row| row.at.truncate()).collect();
        let designed = rows(mirror, &places);
        chunk.iter().zip(designed).fold([0.0, 0.0], |[height, turned], (found, designed)| {
            let up = (found.at.z - designed.at.z).abs();
            let turn = angle(found.normal, designed.normal);
            [max_or_nan(height, up), max_or_nan(turned, turn)]
        })
    };
    let chunks = parallel::map_chunks(found, TURN, worst);
    let [height_mm, normal_rad] = chunks
        .into_iter()
        .fold([0.0, 0.0], |a, b| [max_or_nan(a[0], b[0]), max_or_nan(a[1], b[1])]);
    SagDeviation { height_mm, normal_rad }
}
