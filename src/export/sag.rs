//! Sag table: places of the designed mirror and its normals there, for diamond turning and for
//! coordinate measuring machines.

use super::Label;
use super::text::{ByteCounter, lines};
use crate::geom::{DVec2, DVec3, Outline, ScanPath, ScanPattern, angle};
use crate::mirror::Mirror;
use crate::num::{cos, max_or_nan, sin};
use crate::parallel;
use std::borrow::Cow;
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
    /// The panel that it is on, from 1, of a mirror with steps between panels; none of others.
    pub panel: Option<usize>,
}

/// Reason why a table could not be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "line {line}: a row must hold six finite numbers and the panel, if there are panels, found {found:?}"
)]
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

/// Titles of the columns, and of what follows where there are steps between panels.
const TITLES: &str = "X_mm,Y_mm,Z_mm,NX,NY,NZ";
const PANEL_TITLE: &str = ",panel";
/// Points that are evaluated at a time.
const BATCH: usize = 1 << 16;
/// Points of a spiral that are listed together.
const TURN: usize = 1024;
/// Points of which [`sag_bytes`] counts all.
const COUNTED: f64 = 2e5;

/// Writes rows of X, Y, Z (mm) and the unit normal along `path`, as far as it lies on `mirror`, all
/// panels, with nine decimals: Z and normal are those of X and Y as they are written. The header
/// is of comments that begin with `#`, `notes` among them, and one line of titles. On the ridge of a
/// folded mirror the normals are the designed panel's. Panels with steps between them are scanned one after the other, and
/// their rows end with the panel's number.
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
    header(out, mirror, path, label, notes)?;
    for (panel, mirror) in scanned(mirror) {
        let mut rows = RowWriter { mirror: &mirror, panel, pending: Vec::new(), out };
        walk(path, &mirror, |line| rows.add(line))?;
        rows.flush()?;
    }
    out.flush()
}

/// The mirrors that are scanned one after the other: the panels with steps between them, each with its number, or all of
/// the mirror.
fn scanned(mirror: &Mirror) -> Vec<(Option<usize>, Cow<'_, Mirror>)> {
    if !mirror.has_steps() {
        return vec![(None, Cow::Borrowed(mirror))];
    }
    let panels = mirror.panels().into_iter().enumerate();
    panels.map(|(k, panel)| (Some(k + 1), Cow::Owned(panel))).collect()
}

fn header(
    out: &mut impl Write,
    mirror: &Mirror,
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
    writeln!(out, "{TITLES}{}", if mirror.has_steps() { PANEL_TITLE } else { "" })
}

/// The mirror's rows, evaluated many lines at a time.
struct RowWriter<'a, W> {
    mirror: &'a Mirror,
    panel: Option<usize>,
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
        let on_line = |line: &Vec<DVec2>| on_mirror(self.mirror, self.panel, line);
        let found = parallel::map_slice(&pending, 1, on_line);
        lines(self.out, &found.concat(), row)
    }
}

fn row(text: &mut Vec<u8>, SagRow { at, normal, panel }: &SagRow) -> io::Result<()> {
    let [x, y, z] = at.to_array().map(nine);
    let [a, b, c] = normal.to_array().map(nine);
    write!(text, "{x:.9},{y:.9},{z:.9},{a:.9},{b:.9},{c:.9}")?;
    match panel {
        Some(panel) => writeln!(text, ",{panel}"),
        None => writeln!(text),
    }
}

/// Nine decimals, and no -0.
fn nine(x: f64) -> f64 {
    (x * 1e9).round() / 1e9 + 0.0
}

/// The rows of those places that lie on the mirror, in order.
fn on_mirror(mirror: &Mirror, panel: Option<usize>, line: &[DVec2]) -> Vec<SagRow> {
    let outline = mirror.full_outline();
    let inside = |&p: &DVec2| {
        let on = under(mirror, p).is_some_and(|q| outline.contains(q));
        on.then(|| DVec2::new(nine(p.x), nine(p.y)))
    };
    rows(mirror, panel, &line.iter().filter_map(inside).collect::<Vec<_>>())
}

/// Z of the mirror over each of these places, mm; none beside it.
#[must_use]
pub fn sag_heights(mirror: &Mirror, places: &[DVec2]) -> Vec<Option<f64>> {
    let panels = scanned(mirror);
    let height = |p: &DVec2| {
        let mut rows = panels.iter().flat_map(|(k, mirror)| on_mirror(mirror, *k, &[*p]));
        rows.next().map(|row| row.at.z)
    };
    places.iter().map(height).collect()
}

/// The chart's coordinates of the mirror's place at (X, Y).
fn under(mirror: &Mirror, p: DVec2) -> Option<DVec2> {
    mirror.intersect_camera_ray(&mirror.chart.parallel(), p)
}

/// The mirror's rows over `places`, of which each has one.
fn rows(mirror: &Mirror, panel: Option<usize>, places: &[DVec2]) -> Vec<SagRow> {
    let charted: Vec<DVec2> =
        places.iter().map(|&p| under(mirror, p).unwrap_or(DVec2::NAN)).collect();
    let points = mirror.eval_many(&charted);
    let row = |((p, q), point): ((&DVec2, DVec2), _)| SagRow {
        at: p.extend(mirror.position(q, &point).z),
        normal: mirror.normal(q, &point).normalize(),
        panel,
    };
    places.iter().zip(charted).zip(points).map(row).collect()
}

/// Number of places of a scan, about; those beside the mirror count too.
#[must_use]
pub fn sag_points(path: &ScanPath, mirror: &Mirror) -> f64 {
    scanned(mirror).iter().map(|(_, mirror)| points_of_one(path, mirror)).sum()
}

/// The same of one scan.
fn points_of_one(path: &ScanPath, mirror: &Mirror) -> f64 {
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
    let _ = header(&mut head, mirror, path, label, notes);
    let _ = write_sag(&mut all, mirror, &coarser, label, notes);
    let rows = all.count().saturating_sub(head.count());
    head.count() + (rows as f64 * times * times) as u64
}

/// Reads the rows of a table.
///
/// # Errors
/// [`SagError`], the first one.
pub fn read_sag(bytes: &[u8]) -> Result<Vec<SagRow>, SagError> {
    let (mut titles, mut has_panels) = (true, false);
    let mut rows = Vec::new();
    for (k, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        if line.is_empty() || line.starts_with(b"#") {
            continue;
        }
        if std::mem::take(&mut titles)
            && let Some(rest) = line.strip_prefix(TITLES.as_bytes())
        {
            has_panels = rest == PANEL_TITLE.as_bytes();
            if has_panels || rest.is_empty() {
                continue;
            }
        }
        let row = std::str::from_utf8(line).ok().and_then(|text| {
            let (text, panel) = match has_panels {
                true => {
                    let (text, panel) = text.rsplit_once(',')?;
                    (text, Some(panel.parse().ok()?))
                }
                false => (text, None),
            };
            let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
            let [x, y, z, a, b, c] = <[f64; 6]>::try_from(numbers.ok()?).ok()?;
            let row = SagRow { at: DVec3::new(x, y, z), normal: DVec3::new(a, b, c), panel };
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

/// Holds every row against `mirror`, of a mirror with steps the row's panel, at the row's X and Y; a place or a panel that
/// the mirror does not have is infinitely far off.
#[must_use]
pub fn compare_sag(found: &[SagRow], mirror: &Mirror) -> SagDeviation {
    let scanned = scanned(mirror);
    let of_panel = |rows: &[SagRow]| {
        let known = scanned.iter().find(|(panel, _)| *panel == rows[0].panel);
        let Some((panel, mirror)) = known else { return [f64::INFINITY; 2] };
        let places: Vec<DVec2> = rows.iter().map(|row| row.at.truncate()).collect();
        let designed = self::rows(mirror, *panel, &places);
        rows.iter().zip(designed).fold([0.0, 0.0], |[height, turned], (found, designed)| {
            let up = (found.at.z - designed.at.z).abs();
            let turn = angle(found.normal, designed.normal);
            [max_or_nan(height, up), max_or_nan(turned, turn)]
        })
    };
    let larger = |a: [f64; 2], b: [f64; 2]| [max_or_nan(a[0], b[0]), max_or_nan(a[1], b[1])];
    let worst = |chunk: &[SagRow]| {
        chunk.chunk_by(|a, b| a.panel == b.panel).map(of_panel).fold([0.0, 0.0], larger)
    };
    let chunks = parallel::map_chunks(found, TURN, worst);
    let [height_mm, normal_rad] = chunks.into_iter().fold([0.0, 0.0], larger);
    SagDeviation { height_mm, normal_rad }
}
