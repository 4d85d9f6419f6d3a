//! What is known of a file of unknown making: its units, where it lay, and its form error, as text and
//! as a picture.

use super::map::{Colour, Map, diverging};
use super::text::digits;
use crate::align::{Alignment, FormError, FormMap, Free, Unit};
use crate::num::degrees;
use crate::raster::EncodingError;
use serde::Serialize;

/// The unit of a file's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct UnitFacts {
    /// Its symbol.
    pub name: &'static str,
    /// How many mm it has.
    pub mm_per_unit: f64,
    /// `declared` by the file, `asked`, `by size`, or `assumed` where no unit makes the file as large as
    /// the part.
    pub chosen: &'static str,
}

impl UnitFacts {
    /// `unit`, and how it was chosen.
    #[must_use]
    pub fn new(unit: Unit, chosen: &'static str) -> Self {
        Self { name: unit.name(), mm_per_unit: unit.mm(), chosen }
    }

    pub(super) fn line(&self) -> String {
        let Self { name, mm_per_unit, chosen } = self;
        format!("{name} ({chosen}): coordinates times {mm_per_unit} are millimetres")
    }
}

/// How a file was brought into the part frame: place in mm -> turned about the origin -> shifted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlignmentFacts {
    /// Axis of the turn times its angle, degrees.
    pub turn_deg: [f64; 3],
    /// The same turn as a unit quaternion.
    pub quaternion_xyzw: [f64; 4],
    /// mm.
    pub shift_mm: [f64; 3],
    /// Whether the facets showed the camera their backs.
    pub turned_over: bool,
    /// RMS distance of the vertices from the mirror, outliers left out, um.
    pub rms_um: f64,
    /// Share of the face around vertices that are outliers.
    pub outliers: f64,
    /// Share of the mirror that the others stand for.
    pub covered: f64,
    /// Vertices that the pose rests on.
    pub vertices: usize,
    /// Steps of the fit.
    pub steps: usize,
    /// How much worse the worst direction is determined than the best.
    pub condition: f64,
    /// Motions that move the mirror along itself; in these the file was left as it was.
    pub free: Vec<Free>,
}

impl AlignmentFacts {
    /// The facts of `alignment`.
    #[must_use]
    pub fn new(alignment: &Alignment) -> Self {
        let pose = &alignment.pose;
        Self {
            turn_deg: pose.turn().to_array().map(degrees),
            quaternion_xyzw: pose.rotation.to_array(),
            shift_mm: pose.shift.to_array(),
            turned_over: alignment.turned_over,
            rms_um: alignment.rms_mm * 1e3,
            outliers: alignment.outliers,
            covered: alignment.covered,
            vertices: alignment.vertices,
            steps: alignment.steps,
            condition: alignment.condition,
            free: alignment.free.clone(),
        }
    }

    pub(super) fn lines(&self) -> Vec<String> {
        // Four decimals, and no zero with a sign.
        let place = |v: [f64; 3]| {
            let [x, y, z] = v.map(|x| (1e4 * x).round() / 1e4 + 0.0);
            format!("({x:.4}, {y:.4}, {z:.4})")
        };
        let over = if self.turned_over { ", its facets turned over" } else { "" };
        let mut lines = vec![
            format!(
                "turned by {} deg, then shifted by {} mm{over}",
                place(self.turn_deg),
                place(self.shift_mm)
            ),
            format!(
                "{} vertices on {:.1} % of the mirror, {} um rms; {:.1} % outliers; condition {:.1}",
                self.vertices,
                100.0 * self.covered,
                digits(self.rms_um),
                100.0 * self.outliers,
                self.condition
            ),
        ];
        for Free { direction, through_mm } in &self.free {
            let along = place(direction.to_array());
            let motion = match through_mm {
                Some(at) => format!("a turn about {along} through {} mm", place(at.to_array())),
                None => format!("a shift along {along}"),
            };
            lines.push(format!("the mirror does not show {motion}: it is not fitted"));
        }
        lines
    }
}

/// The form error in words.
pub(super) fn error_line(error: &FormError) -> String {
    let FormError { all, without_outliers: inner, outliers, .. } = error;
    let [pv, rms, lowest, highest] = [all.pv, all.rms, all.lowest, all.highest].map(digits);
    let mut line = format!("{pv} um PV, {rms} um rms ({lowest} to {highest})");
    if *outliers > 0.0 {
        let [pv, rms] = [inner.pv, inner.rms].map(digits);
        line += &format!("; {pv} PV, {rms} rms without {:.1} % outliers", 100.0 * outliers);
    }
    line
}

/// Where nothing is known.
const NOTHING: Colour = [110, 110, 114];

/// The map of the form error as the camera would see it, as PNG: red above the design, blue below,
/// grey where nothing is known, with a scale that reaches as far as the map does without outliers.
///
/// # Errors
/// A sensor without pixels cannot be drawn.
pub fn form_picture(map: &FormMap, error: Option<&FormError>) -> Result<Vec<u8>, EncodingError> {
    let limit = error.map_or(1.0, limit);
    let colour = |mm: &f64| {
        if mm.is_nan() { NOTHING } else { diverging(0.5 + 0.5e3 * mm / limit) }
    };
    let tick = |share: f64| if share == 0.0 { "0".into() } else { format!("{:+}", share * limit) };
    let title = error.map_or("nothing measured".into(), |error| {
        let [pv, rms] = [error.all.pv, error.all.rms].map(digits);
        format!("form error, um: {pv} PV, {rms} rms")
    });
    let map = Map {
        pixels: map.pixels,
        colours: map.mm.iter().map(colour).collect(),
        title,
        ramp: diverging,
        ticks: [-1.0, -0.5, 0.0, 0.5, 1.0].map(tick).to_vec(),
        keys: vec![(NOTHING, "nothing known".into())],
    };
    map.png()
}

/// The next round number, um, that is not less than any departure but the outliers'.
fn limit(error: &FormError) -> f64 {
    let most = error.without_outliers.highest.max(-error.without_outliers.lowest);
    let round = |k: i32| format!("{}e{}", [1, 2, 5][k.rem_euclid(3) as usize], k.div_euclid(3));
    let limits = (-18..18).filter_map(|k| round(k).parse().ok());
    limits.into_iter().find(|limit: &f64| *limit >= most).unwrap_or(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        for (most, exact) in
            [(0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (4.0, 5.0), (60.0, 100.0), (3e-4, 5e-4)]
        {
            let mm = vec![-1e-3 * most, 0.5e-3 * most, f64::NAN];
            let error = FormMap { pixels: [3, 1], mm }.error().unwrap();
            assert_eq!(limit(&error), exact, "{most}");
        }
    }

    #[test]
    fn the_picture_holds_the_map_and_a_scale() {
        let map = FormMap { pixels: [2, 1], mm: vec![1e-3, f64::NAN] };
        let png = form_picture(&map, map.error().as_ref()).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        // Each pixel a square; the first as high as it gets, the second unknown.
        let middle = |k: usize| 3 * (info.width as usize * (2 * k + 1) / 4);
        assert_eq!(info.width, 640);
        assert_eq!(rgb[middle(0)..][..3], diverging(1.0));
        assert_eq!(rgb[middle(1)..][..3], NOTHING);
        assert!(form_picture(&FormMap { pixels: [2, 1], mm: vec![f64::NAN; 2] }, None).is_ok());
    }
}
