//! Figures of a part: the part itself, its side view, what the camera sees, and maps over the frame.

use super::least_error::least_error_sentence;
use super::page::{Figure, image, map_figure, part_figure, sections_figure, side_view_figure};
use crate::design::LeastError;
use crate::profile::CadFormat;
use crate::raster::{EncodingError, FalseColourMap};
use crate::render::{PartSection, SideView};
use crate::results::{SharpnessFacts, TraceFacts, error_px, three_digits};

/// What a page shows of a part.
#[derive(Default)]
pub struct BuildFigures<'a> {
    /// The part; none where it has no mesh.
    pub part: Option<PartFigures>,
    /// What the camera sees of the test world, as PNG.
    pub preview: &'a [u8],
    /// Pixel errors over the frame; none without a projection.
    pub errors: Option<FalseColourMap>,
    /// Curl of the wanted slopes over the frame; none without a projection.
    pub curl: Option<&'a FalseColourMap>,
    /// Sizes of spots over the frame; none where no pixel has one.
    pub spots: Option<FalseColourMap>,
}

/// What a page shows of a part's shape, from a coarse mesh of it.
pub struct PartFigures {
    /// The mesh as a file in the format glb.
    pub glb: Vec<u8>,
    /// A picture of the part, as PNG.
    pub still: Vec<u8>,
    /// The part, the camera, and the rays at the ends of the picture.
    pub side_view: SideView,
    /// Cross-sections.
    pub sections: Vec<PartSection>,
}

impl BuildFigures<'_> {
    /// The figures in the order of the page, with what to conclude from each.
    ///
    /// # Errors
    /// What the encoder of pictures reports.
    pub(super) fn on_page(
        &self,
        traces: &[TraceFacts],
        sharpness: Option<&SharpnessFacts>,
        made: &str,
        least: Option<&LeastError>,
    ) -> Result<Vec<Figure>, EncodingError> {
        let mut figures = Vec::new();
        if let Some(part) = &self.part {
            figures.push(part_figure(&part.glb, &part.still, made));
        }
        let has_mesh = traces.iter().any(|trace| trace.file != CadFormat::Step.file_name());
        figures.push(preview(self.preview, has_mesh));
        if let Some(part) = &self.part {
            figures.extend(side_view_figure(&part.side_view));
            figures.extend(sections_figure(&part.sections));
        }
        if let Some(map) = &self.errors {
            let about =
                about_errors(traces) + " Those of the designed mirror are in design_error.png.";
            figures.push(map_figure("Pixel error, px", map, about)?);
        }
        if let Some(map) = self.curl {
            figures.push(map_figure("Curl of the wanted slopes, px", map, about_curl(least))?);
        }
        if let Some(map) = &self.spots {
            figures.push(map_figure("Size of the spots, px", map, about_spots(sharpness))?);
        }
        Ok(figures)
    }
}

/// The picture of the test world: in the first mesh file, or else in the designed mirror.
fn preview(png: &[u8], has_mesh: bool) -> Figure {
    let alt = "What the camera sees in the mirror of a world marked in azimuth and elevation";
    let mirror =
        if has_mesh { "mirror of the file" } else { "designed mirror, without its shadows" };
    Figure {
        title: "What the camera sees".into(),
        body: image(png, "preview", alt),
        caption: format!(
            "The test world in the {mirror}: lines every 15 degrees with their azimuth and \
             elevation, sky above, ground below; black where the camera sees no mirror."
        ),
    }
}

/// What to conclude from a map of pixel errors.
pub(super) fn about_errors(traces: &[TraceFacts]) -> String {
    let found = traces.first().and_then(|trace| trace.errors.pixel_error_px);
    found.map_or("No pixel shows what it should.".into(), |found| {
        let [rms, p95, max] = [found.rms, found.p95, found.max].map(error_px);
        format!(
            "By how much each pixel of the frame shows something else than it should: RMS {rms} px, 95th percentile {p95} \
             px, largest {max} px."
        )
    })
}

/// What to conclude from a map of the curl.
fn about_curl(least: Option<&LeastError>) -> String {
    let conclusion = least.map_or("Nothing is known of the picture as a whole.".into(), |least| {
        format!("The picture as a whole: {}.", least_error_sentence(least))
    });
    format!(
        "How far a square of a tenth of the frame's width around each pixel is off for itself, RMS, whatever the rest of \
         the mirror does: 0 everywhere where a mirror without error exists. Bright places are those to leave out or to \
         give a panel of their own. {conclusion}"
    )
}

fn about_spots(sharpness: Option<&SharpnessFacts>) -> String {
    let lens = sharpness.map(|facts| facts.given.as_ref().unwrap_or(&facts.best));
    lens.map_or(String::new(), |lens| {
        let [across, up] = lens.resolved;
        format!(
            "Size of the spot that a point of the world makes, through {}. 95 % are at most {} px: the picture \
             resolves about {across} x {up} spots.",
            lens.lens(),
            three_digits(lens.sharp.spot_px)
        )
    })
}
