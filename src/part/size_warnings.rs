//! Warnings of parts and files that others will find too large, and of mirrors that the frame cuts off,
//! each with what to do instead.

use super::face::{added_to, forecast, limits};
use crate::design::Design;
use crate::geom::{Outline, Precision};
use crate::mesh::{LEAST_USED, Limits, mesh};
use crate::num::rounding::{two_digits_above, two_digits_below};
use crate::num::units::{Mm, Px};
use crate::profile::{CadFormat, FileFormat, Profile};
use crate::results::MeshFacts;
use std::f64::consts::PI;

/// The least number of triangles that draws a warning, and the least length of a file.
const MANY: usize = 1_000_000;
const LARGE: u64 = 100_000_000;
/// What is suggested stays this far below, so that a forecast may be off.
const BELOW: f64 = 0.93;
/// Most forecasts made to find a suggestion.
const FORECASTS: usize = 12;
/// How much finer each mesh is that is made to say why a budget is not used, and most of these.
const FINER: f64 = 0.98;
const FINER_MESHES: usize = 12;
/// The least share of a mirror outside the frame that draws a warning.
const CUT_OFF: f64 = 1e-3;

/// What suggestions are drawn from.
pub(crate) struct SizeWarnings<'a> {
    /// What was asked for.
    pub profile: &'a Profile,
    /// The mirror.
    pub design: &'a Design,
    /// Digits of the mesh.
    pub precision: Precision,
}

impl SizeWarnings<'_> {
    /// Warnings of a part of so many triangles and of files of so many bytes.
    pub(crate) fn on(&self, triangles: usize, files: &[(&str, u64)]) -> Vec<String> {
        let name = &self.profile.name;
        let mut warnings: Vec<String> = self.cut_off().into_iter().collect();
        if triangles >= MANY {
            let instead = self.instead(triangles, MANY as f64);
            let step = if self.profile.formats.contains(&FileFormat::Cad(CadFormat::Step)) {
                "mirror.step is there for them"
            } else {
                "add \"step\" to export.formats"
            };
            warnings.push(format!(
                "{name}: {triangles} triangles in all are a burden for many CAM programs; to stay \
                 under {MANY}, write {instead}. Shops that take STEP need no triangles: {step}"
            ));
        }
        for &(file, bytes) in files.iter().filter(|(_, bytes)| *bytes >= LARGE) {
            if file == CadFormat::Csv.file_name() {
                warnings.push(self.on_table(file, bytes));
                continue;
            }
            let most = triangles as f64 * LARGE as f64 / bytes as f64;
            let instead = self.instead(triangles, most);
            let [size, large] = [bytes, LARGE].map(|bytes| bytes as f64 / 1e6);
            warnings.push(format!(
                "{name}: {file} takes {size:.0} MB; to stay under {large} MB, write {instead}"
            ));
        }
        warnings
    }

    /// The warning of a budget of which less than [`LEAST_USED`] is used: what stands against a finer mesh, the next of
    /// which has been made already or not.
    pub(crate) fn unspent(&self, made: &MeshFacts, next_finer: Option<usize>) -> Option<String> {
        let most = made.max_triangles?;
        if made.triangles as f64 >= LEAST_USED * most as f64 {
            return None;
        }
        let why = match next_finer {
            Some(count) => format!("finer limits come to {count}"),
            None => self.finer(made, most),
        };
        Some(format!(
            "{}: {} of max_triangles = {most} are used; {why}",
            self.profile.name, made.triangles
        ))
    }

    /// What finer limits come to, up to the first that do not fit `most`.
    fn finer(&self, made: &MeshFacts, most: usize) -> String {
        let Design { mirror, camera, .. } = self.design;
        let (closing, view) = (made.triangles - made.optical_triangles, self.design.bounded_view());
        let (mut by, mut counts) = (1.0, Vec::new());
        while counts.len() < FINER_MESHES && counts.last().is_none_or(|&count| count <= most) {
            by *= FINER;
            let [chord_mm, facet_mm] = match view {
                Some(_) => [None, Some(camera.to_mm(Px(by * made.facet_px.bound)).0)],
                None => [Some(by * made.chord_um.bound * 1e-3), None],
            };
            let limits = Limits { chord_mm, facet_mm, precision: self.precision };
            match mesh(mirror, &camera.chart, view, limits) {
                Ok(face) => counts.push(face.mesh.triangles.len() + closing),
                Err(error) => return format!("a finer mesh cannot be made: {error}"),
            }
        }
        let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
        format!("finer limits come to {}", counts.join(", "))
    }

    /// The warning of a round mirror that reaches beyond the frame.
    fn cut_off(&self) -> Option<String> {
        let Design { mirror, camera, .. } = self.design;
        let Outline::Ring { inner, outer } = mirror.outline else { return None };
        if mirror.chart != camera.chart {
            return None;
        }
        let [columns, rows] = camera.pixels;
        let half = [columns, rows].map(|pixels| 0.5 * f64::from(pixels) * camera.pixel_mm);
        let seen = within(half, outer) - within(half, inner);
        let lost = 1.0 - seen / (PI * (outer * outer - inner * inner));
        let instead = match camera.chart.vergence {
            0.0 => {
                let side = columns.min(rows);
                format!("write pixels = [{side}, {side}], the middle of that sensor")
            }
            // The rim stays where it is, at the distance of the reference plane.
            vergence => {
                let distance_mm = outer / half[0].min(half[1]) / vergence;
                format!("write distance_mm = {:.1}", (10.0 * distance_mm).ceil() / 10.0)
            }
        };
        (lost >= CUT_OFF).then(|| {
            format!(
                "{}: the frame of {columns} x {rows} pixels cuts off {:.1} % of the mirror, whose disc \
                 is {:.0} pixels across; to see all of it, {instead}",
                self.profile.name,
                100.0 * lost,
                camera.to_px(Mm(2.0 * outer)).0,
            )
        })
    }

    /// The warning of a sag table of so many bytes: its rows are as one over pitch and step.
    fn on_table(&self, file: &str, bytes: u64) -> String {
        let name = &self.profile.name;
        let longer = (bytes as f64 / (BELOW * LARGE as f64)).sqrt();
        let scan = self.profile.sag.scan(self.profile.part.width_mm);
        let [pitch, step] = [scan.pitch_mm, scan.step_mm].map(|mm| two_digits_above(longer * mm));
        let [size, large] = [bytes, LARGE].map(|bytes| bytes as f64 / 1e6);
        format!(
            "{name}: {file} takes {size:.0} MB; to stay under {large} MB, write pitch_mm = {pitch} \
             and step_mm = {step} below [export.sag]"
        )
    }

    /// What to write into the profile for fewer triangles than `most`.
    fn instead(&self, triangles: usize, most: f64) -> String {
        let budget = format!("max_triangles = {}", two_digits_below(BELOW * most));
        if self.profile.mesh.max_triangles().is_some() {
            return budget;
        }
        match self.looser(triangles, BELOW * most) {
            Some(limits) => format!("{limits}, or {budget} in the place of limits"),
            None => budget,
        }
    }

    /// Looser limits at which at most `most` triangles are foreseen: of those that rule.
    fn looser(&self, triangles: usize, most: f64) -> Option<String> {
        let pixel = self.design.camera.pixel_mm;
        let own = limits(self.profile, self.design, self.precision);
        let count = |limits: Limits| {
            let foreseen = forecast(self.design, limits).ok()?;
            Some(foreseen.facets + added_to(&foreseen, self.design) as f64)
        };
        let alone = [Limits { facet_mm: None, ..own }, Limits { chord_mm: None, ..own }];
        let set = [own.chord_mm.is_some(), own.facet_mm.is_some()];
        let mut rules = set;
        if set == [true; 2] {
            let many = alone.map(|limits| count(limits).is_some_and(|count| count > most));
            if many != [false; 2] {
                rules = many;
            }
        }
        let mut ratio = triangles as f64 / most;
        for attempt in 1..=FORECASTS {
            if attempt == FORECASTS / 2 {
                rules = set;
            }
            // Triangles are as one over the chord, and as one over the square of the facet error.
            let [by_chord, by_facet] = [ratio, ratio.sqrt()];
            let chord_um = self.profile.mesh.chord_um().map(|um| two_digits_above(um * by_chord));
            let facet_px = self.profile.mesh.facet_px().map(|px| two_digits_above(px * by_facet));
            let mut limits = own;
            let mut words = Vec::new();
            if let (Some(um), true) = (chord_um, rules[0]) {
                limits.chord_mm = Some(um * 1e-3);
                words.push(format!("chord_um = {um}"));
            }
            if let (Some(px), true) = (facet_px, rules[1]) {
                limits.facet_mm = Some(px * pixel);
                words.push(format!("facet_px = {px}"));
            }
            let found = count(limits)?;
            if found <= most {
                return Some(words.join(" and "));
            }
            ratio *= (found / most).max(1.02);
        }
        None
    }
}

/// The area of the disc of this radius inside the rectangle with these half sides.
fn within([a, b]: [f64; 2], radius: f64) -> f64 {
    const STEPS: u32 = 1000;
    let reach = a.min(radius);
    let height = |k: u32| {
        let x = reach * (f64::from(k) + 0.5) / f64::from(STEPS);
        b.min((radius * radius - x * x).sqrt())
    };
    4.0 * reach / f64::from(STEPS) * (0..STEPS).map(height).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_in_a_frame_has_the_area_of_its_segments() {
        // A band of 3/4 of the diameter: 2 (h sqrt(1 - h^2) + asin h).
        let h: f64 = 0.75;
        let exact = 2.0 * (h * (1.0 - h * h).sqrt() + crate::num::asin(h));
        for half in [[1.0, h], [h, 1.0], [5.0, h]] {
            assert!((within(half, 1.0) / exact - 1.0).abs() < 1e-4, "{half:?}");
        }
        assert!((within([1.0, 1.0], 1.0) / PI - 1.0).abs() < 1e-4);
        assert_eq!(within([1.0, 1.0], 0.0), 0.0);
    }
}
