//! What the pages of a build and of a verification show of the part.

use crate::design::{Design, own_errors_px};
use crate::export::{Label, write_glb};
use crate::geom::{DVec2, Precision};
use crate::optics::ThinnedFrame;
use crate::part::closed;
use crate::raster::FalseColourMap;
use crate::render::{AxialPlane, PartSection, SideView, coarse_mesh, pixel_errors, shaded_view};
use crate::report::{PartFigures, curl_map, design_error_map, pixel_error_map, spot_map};
use crate::results::SharpnessFacts;
use crate::solid::Solid;
#[cfg(feature = "studio")]
use crate::trace::{CameraTrace, Obstacles, Outcome, RayEnd};
use crate::trace::{PixelTrace, Scene, TraceStrip};
use crate::verdict::sharpness::{SpotSizes, spot_sizes};
#[cfg(feature = "studio")]
use std::sync::Arc;

/// The part's figures from a coarse mesh of its own, none where it has none: of a tool what is formed beside the camera, the
/// tool by itself.
pub(crate) fn part_figures(design: &Design, label: &Label) -> Option<PartFigures> {
    let part = coarse_part(design)?;
    let made = match design.tool {
        Some(_) => &closed(design, &coarse_mesh(&design.mirror)?, Precision::Single).ok()?,
        None => &part,
    };
    let glb = glb(made, label)?;
    let section = |plane| PartSection::new(made.mesh(), plane);
    let sections = [AxialPlane::X0, AxialPlane::Y0].map(section);
    let side_view = SideView::new(design, part.mesh());
    let still = still(made)?;
    Some(PartFigures { glb, still, side_view, sections: sections.to_vec() })
}

/// The closed part around a coarse mesh, for pictures; none where it cannot be closed.
pub(crate) fn coarse_part(design: &Design) -> Option<Solid> {
    coarse_solid(design, Precision::Single).ok()
}

/// The same with the digits of a precision, or why it cannot be closed.
pub(super) fn coarse_solid(design: &Design, precision: Precision) -> Result<Solid, String> {
    let face = coarse_mesh(&design.mirror).ok_or("the walls between its panels cross")?;
    let solid = match design.tool {
        Some(_) => Solid::from_face(&face, design.features(), precision),
        None => closed(design, &face, precision),
    };
    solid.map_err(|error| error.to_string())
}

/// A part as GLB.
pub(crate) fn glb(part: &Solid, label: &Label) -> Option<Vec<u8>> {
    let mut glb = Vec::new();
    write_glb(&mut glb, part, label).ok()?;
    Some(glb)
}

/// The picture of a part where nothing can be turned, PNG.
pub(crate) fn still(part: &Solid) -> Option<Vec<u8>> {
    shaded_view(&Scene::new(part.mesh().clone())).to_png().ok()
}

/// For each of so many columns and rows of pixels in the camera's frame whether the part or an obstacle is in the way of what it sees: of
/// the coarse part that a page turns. None where the part has no mesh.
#[cfg(feature = "studio")]
pub(crate) fn shadowed(design: &Design, pixels: [u32; 2]) -> Option<Vec<bool>> {
    let obstacles = Obstacles::new(&design.obstacles, design.view.as_ref()).map(Arc::new);
    let scene = Scene::new(coarse_part(design)?.mesh().clone()).among(obstacles);
    let camera = design.camera.with_pixels(pixels);
    let (ends, _) = CameraTrace::new(&scene, &camera, scene.above_mm()).run();
    let is_hidden =
        |end: &RayEnd| matches!(end.outcome, Outcome::Shadowed(_) | Outcome::Obstructed(_));
    Some(ends.iter().map(is_hidden).collect())
}

/// Most columns of a map on a page.
pub(super) const MAP_COLUMNS: u32 = 400;

/// Pixel errors of the pixels of a map, px; none where nothing is seen.
pub(super) struct ErrorMap {
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// One a pixel; empty where nothing was traced.
    pub errors: Vec<Option<f64>>,
}

impl ErrorMap {
    /// The map; none without a projection.
    pub(super) fn drawn(&self, design: &Design) -> Option<FalseColourMap> {
        let is_known = design.view.is_some() && !self.errors.is_empty();
        is_known.then(|| pixel_error_map(self.pixels, &self.errors))
    }
}

/// The pixel errors of a traced frame, thinned to a map.
pub(super) struct ErrorMapBuilder {
    thinned: ThinnedFrame,
    pixel_mm: f64,
    errors: Vec<Option<f64>>,
}

impl ErrorMapBuilder {
    /// Of the frame of the camera of `design`, with so many columns at most.
    pub(super) fn new(design: &Design, columns: u32) -> Self {
        let thinned = ThinnedFrame::at_most(design.camera.pixels, columns);
        Self { thinned, pixel_mm: design.camera.pixel_mm, errors: Vec::new() }
    }

    /// Adds a strip.
    pub(super) fn add(&mut self, strip: &TraceStrip) {
        let error = |pixel: &PixelTrace| {
            Some(pixel.errors?.image_mm / self.pixel_mm).filter(|px| px.is_finite())
        };
        let pixels = self.thinned.thin(strip.rows.clone(), &strip.pixels);
        self.errors.extend(pixels.map(error));
    }

    /// The errors, or, where nothing was traced, those of the designed mirror.
    pub(super) fn finish_or_smooth(mut self, design: &Design) -> ErrorMap {
        if self.errors.is_empty() && design.view.is_some() {
            self.errors = pixel_errors(design, self.thinned);
        }
        self.finish()
    }

    /// The errors.
    pub(super) fn finish(self) -> ErrorMap {
        ErrorMap { pixels: self.thinned.pixels(), errors: self.errors }
    }
}

/// Most columns of the map of a design's errors, which change little from pixel to pixel.
const DESIGN_MAP_COLUMNS: u32 = 800;

/// The map of the designed mirror's pixel errors over the frame; none without a projection.
pub(super) fn design_errors(design: &Design) -> Option<FalseColourMap> {
    design.view.as_ref()?;
    let thinned = ThinnedFrame::at_most(design.camera.pixels, DESIGN_MAP_COLUMNS);
    Some(design_error_map(thinned.pixels(), &pixel_errors(design, thinned), &design.facts))
}

/// Most columns of the map of a picture's curl, which changes little from pixel to pixel.
const CURL_MAP_COLUMNS: u32 = 200;

/// The map of the curl of the slopes that the picture asks for; none without a projection.
pub(super) fn curl(design: &Design) -> Option<FalseColourMap> {
    let Design { mirror, camera, .. } = design;
    let view = design.view.as_ref()?;
    let thinned = ThinnedFrame::at_most(camera.pixels, CURL_MAP_COLUMNS);
    let columns: Vec<usize> = thinned.columns().collect();
    let image = |x: usize, y: usize| camera.image_point(x as f64 + 0.5, y as f64 + 0.5);
    let row = |y: usize| columns.iter().map(move |&x| image(x, y));
    let images: Vec<DVec2> = thinned.rows(0..camera.pixels[1] as usize).flat_map(row).collect();
    Some(curl_map(thinned.pixels(), &own_errors_px(mirror, camera, view, &images)))
}

/// The map of the spots' sizes over the frame; none where no pixel has one.
pub(crate) fn sharpness_map(
    design: &Design,
    sharpness: Option<&SharpnessFacts>,
) -> Option<FalseColourMap> {
    Some(drawn_spots(&spot_sizes(design, sharpness?)?))
}

/// The map of sizes of spots.
pub(crate) fn drawn_spots(found: &SpotSizes) -> FalseColourMap {
    spot_map(found.pixels, &found.sizes_px, &found.quantiles, "size of the spots, px")
}
