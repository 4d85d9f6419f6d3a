//! Figures of unwrapped photos for the report.

use super::unwrap_picture::FramedPicture;
use crate::optics::StripLaw;
use crate::profile::Profile;
use crate::publish::StagedFile;
use crate::results::{
    FileFacts, GroundFacts, PanoramaFacts, PhotoFacts, SCHEMA, UnwrapReport, ViewFacts,
};
use crate::unwrap::Panorama;
use std::path::Path;

/// Facts of a file that was written with these bytes.
pub(super) fn file_facts(staged: &StagedFile, format: &str, bytes: &[u8]) -> FileFacts {
    FileFacts {
        name: staged.name().to_owned(),
        format: format.into(),
        bytes: bytes.len() as u64,
        sha256: staged.sha256().to_owned(),
    }
}

/// The report on photos that were unwrapped to a picture, without map, frames, files and warnings; `way`: of the panorama.
pub(super) fn report_on(
    profile: &Profile,
    photo: PhotoFacts,
    pose: Option<&Path>,
    (framed, way): (&FramedPicture, &'static str),
) -> UnwrapReport {
    let mut report = UnwrapReport {
        schema: SCHEMA,
        profile: profile.into(),
        photo,
        frames: None,
        pose: pose.map(|path| path.display().to_string()),
        panorama: None,
        view: None,
        ground: None,
        map: None,
        files: Vec::new(),
        warnings: Vec::new(),
    };
    let pixels = framed.size();
    match framed {
        FramedPicture::Panorama(panorama) => report.panorama = Some(panorama_facts(panorama, way)),
        FramedPicture::View(angles, _) => {
            report.view = Some(ViewFacts {
                pixels,
                azimuth_deg: angles.azimuth_deg,
                elevation_deg: angles.elevation_deg,
                field_deg: angles.field_deg,
            });
        }
        FramedPicture::Ground(floor) => {
            report.ground = Some(GroundFacts {
                pixels,
                height_mm: floor.z_mm,
                range_mm: floor.plane().range_mm,
                mm_per_px: floor.mm_per_px(),
                corner_mm: floor.seen_from_mirror().corner(),
                row_mm: floor.row_seen_mm(),
            });
        }
    }
    report
}

fn panorama_facts(panorama: &Panorama, way: &'static str) -> PanoramaFacts {
    PanoramaFacts {
        way,
        projection: law_name(&panorama.law),
        pixels: panorama.size,
        azimuth_deg: panorama.azimuth_deg(),
        elevation_deg: panorama.elevation_deg(),
    }
}

fn law_name(law: &StripLaw) -> &'static str {
    match law {
        StripLaw::Cylindrical => "cylindrical",
        StripLaw::Mercator => "mercator",
        StripLaw::Equirectangular => "equirectangular",
        StripLaw::EqualArea => "equal-area",
        StripLaw::Tabulated(_) => "table",
    }
}
