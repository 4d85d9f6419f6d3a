//! Layouts: where the image strip, the panel and the domain of the fit lie in the part.

use crate::geom::{DVec2, Rect};
use crate::num::radians;
use crate::optics::{Fold, Law, Orthographic, Strip};
use crate::profile::{self, Camera, Layout, PanelSource, Profile, Ridge};

/// The geometry that a profile fixes before anything is solved.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Image of the designed panel.
    pub strip: Strip,
    /// The panel to be made, mm; corners rounded to single precision, so that the rim of every
    /// file is exactly straight.
    pub panel: Rect,
    /// Where the sheet is fitted, mm: the panel, or for `section` the panorama it is cut from.
    pub domain: Rect,
    /// Which side of Y = 0 the panel lies on, for folded mirrors.
    pub fold: Option<Fold>,
    /// Whether problem and panel are symmetric in X.
    pub even_x: bool,
    /// The camera.
    pub camera: Orthographic,
}

impl Plan {
    /// Lays out `profile`.
    #[must_use]
    pub fn new(profile: &Profile) -> Self {
        let law = match profile.projection.law {
            profile::Law::Cylindrical => Law::Cylindrical,
            profile::Law::Mercator => Law::Mercator,
        };
        let Camera::Orthographic { pixels } = profile.camera;
        let width = profile.part.width_mm;
        let camera = Orthographic { pixels, pixel_mm: width / f64::from(pixels[0]) };
        let frame_height = camera.pixel_mm * f64::from(pixels[1]);
        let azimuth = profile.projection.azimuth_deg;
        let span = radians(azimuth[1] - azimuth[0]);
        let middle_deg = 0.5 * (azimuth[0] + azimuth[1]);

        // Azimuth across the part's width, and how many panels share the frame's height.
        let (across, panels, fill_frame) = match profile.layout {
            Layout::Strip { fill_frame } => (span, 1.0, fill_frame),
            Layout::Conquistador { fill_frame, .. } => (0.5 * span, 2.0, fill_frame),
        };
        let scale_mm = width / across;
        let z = profile.projection.elevation_deg.map(|e| law.image_of_elevation(radians(e)));
        let z_middle = 0.5 * (z[0] + z[1]);
        let height = if fill_frame { frame_height / panels } else { (z[1] - z[0]) * scale_mm };

        let (fold, below) = match profile.layout {
            Layout::Strip { .. } => (None, 0.5 * height),
            Layout::Conquistador { ridge: Ridge::Crest, .. } => (Some(Fold::Above), 0.0),
            Layout::Conquistador { ridge: Ridge::Valley, .. } => (Some(Fold::Below), height),
        };
        let exact = Rect {
            min: DVec2::new(-0.5 * width, -below),
            max: DVec2::new(0.5 * width, height - below),
        };
        let widening = match profile.layout {
            Layout::Conquistador { panel: PanelSource::Section, .. } => {
                DVec2::new(span / across, 1.0)
            }
            _ => DVec2::ONE,
        };
        let strip = Strip {
            law,
            scale_mm,
            azimuth: radians(middle_deg),
            z: z_middle - (0.5 * height - below) / scale_mm,
        };
        Self {
            strip,
            panel: Rect { min: single(exact.min), max: single(exact.max) },
            domain: Rect {
                min: exact.centre() - 0.5 * widening * exact.size(),
                max: exact.centre() + 0.5 * widening * exact.size(),
            },
            fold,
            // The field is (odd, even) in azimuth about the directions 0 and 180 degrees.
            even_x: middle_deg % 180.0 == 0.0,
            camera,
        }
    }
}

fn single(p: DVec2) -> DVec2 {
    p.as_vec2().as_dvec2()
}
