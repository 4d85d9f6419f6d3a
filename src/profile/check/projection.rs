//! The projection's own keys; what it needs of camera, layout and part is in `fits` and `reach`.

use super::super::projection::LawName;
use super::super::reader::Need::{Optional, Required};
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, NumbersFormat, number, numbers};
use super::super::{ProjectionSpec, RadialLawSpec, RadialSpec, StripLawSpec, StripSpec};
use super::map::{self, MapKeys};
use super::panels::{self, PanelKeys};
use super::table::{self, POLE, Table, below_the_pole};
use super::view::{AzimuthalKeys, LAWS, azimuthal};
use super::{LARGE, SIGNED, is_large, is_signed, only};
use crate::geom::DVec3;
use crate::optics::{PosedTarget, RadialLawKind, Target};

/// A projection's figures, each with its place.
pub(super) struct ProjectionEntry<'t> {
    pub(super) section: Section<'t>,
    pub(super) keys: ProjectionKeys,
    pub(super) radius: Option<Located<f64>>,
    pub(super) plane: Option<Located<f64>>,
    /// In any pose.
    pub(super) posed: Option<PosedTarget>,
}

impl ProjectionEntry<'_> {
    /// Whether its law comes of a design.
    pub(super) fn is_best(&self) -> bool {
        let law = match &self.keys {
            ProjectionKeys::Strip { law, .. } => law.as_ref(),
            ProjectionKeys::Radial { .. }
            | ProjectionKeys::Azimuthal(_)
            | ProjectionKeys::Map(_)
            | ProjectionKeys::Panels(_) => None,
        };
        law == Some(&StripLawSpec::LeastCurl)
    }
}

/// The keys that differ between strip laws and radial laws.
pub(super) enum ProjectionKeys {
    Strip {
        law: Option<StripLawSpec>,
        azimuth: Option<Located<[f64; 2]>>,
        /// Lowest and highest.
        elevation: Option<Located<[f64; 2]>>,
    },
    Radial {
        law: Option<RadialLawSpec>,
        /// Polar angle at the inner rim, of a table always.
        inner: Option<Located<f64>>,
        outer: Option<Located<f64>>,
    },
    /// A perspective or fisheye view.
    Azimuthal(AzimuthalKeys),
    /// Directions or points as data; none without a sound file.
    Map(Option<MapKeys>),
    /// Views side by side.
    Panels(Vec<PanelKeys>),
}

pub(super) fn read<'t>(
    reader: &mut ProfileReader,
    root: &Section<'t>,
    posed: Option<PosedTarget>,
) -> Option<ProjectionEntry<'t>> {
    let hint = "[projection.cylindrical] is the paper's law; with [projection.mercator] an exact \
                mirror exists";
    if root.has("panel") {
        let (section, panels) = panels::read(reader, root)?;
        let keys = ProjectionKeys::Panels(panels);
        return Some(ProjectionEntry { section, keys, radius: None, plane: None, posed });
    }
    let read = reader
        .alternatives(root, "projection", hint)
        .into_iter()
        .filter_map(|(name, section)| {
            one(reader, name, LawName::find(name)?, section, posed.clone())
        })
        .collect();
    only(read)
}

fn one<'t>(
    reader: &mut ProfileReader,
    name: &'static str,
    law: LawName,
    section: Section<'t>,
    posed: Option<PosedTarget>,
) -> Option<ProjectionEntry<'t>> {
    let keys = match law {
        LawName::Table => table_keys(reader, &section)?,
        LawName::Strip(law) => {
            let azimuth = azimuth(reader, &section);
            let elevation = elevation(reader, &section, name, &law);
            ProjectionKeys::Strip { law: Some(law), azimuth, elevation }
        }
        LawName::Radial(law) => {
            let inner = inner_polar(reader, &section, law);
            let outer = outer_polar(reader, &section, law);
            ProjectionKeys::Radial { law: Some(RadialLawSpec::Named(law)), inner, outer }
        }
        LawName::Azimuthal(law) => {
            let laws = if law.is_some() { &LAWS[..1] } else { &LAWS[1..] };
            ProjectionKeys::Azimuthal(azimuthal(reader, &section, laws))
        }
        LawName::Map => {
            let viewpoint_mm = posed.as_ref().map_or(DVec3::ZERO, |target| target.viewpoint_mm());
            ProjectionKeys::Map(map::read(reader, &section, viewpoint_mm))
        }
    };
    let must = &format!("a number {LARGE}");
    let hint = "the radius of the cylinder that the picture shows, in millimetres";
    let radius = number(reader, &section, "target_radius_mm", Optional, must, hint, is_large);
    let hint = "the height of the plane that the picture shows, in millimetres; above 0 it is \
                on the camera's side";
    let plane = number(reader, &section, "target_plane_mm", Optional, SIGNED, hint, is_signed);
    if let (Some(radius), Some(plane)) = (radius, plane) {
        let path = &section.path;
        let message = format!("{path} must hold at most one target, found both of them");
        let hint = "target_radius_mm is a cylinder, target_plane_mm a plane; remove one of them";
        reader.complain(radius.at.max(plane.at), message, hint);
    }
    Some(ProjectionEntry { section, keys, radius, plane, posed })
}

/// The keys of a table, by what it is of.
fn table_keys(reader: &mut ProfileReader, section: &Section) -> Option<ProjectionKeys> {
    Some(match table::read(reader, section)? {
        Table::Strip(entries) => {
            let elevation = entries.as_ref().map(|entries| {
                let [highest, lowest] = table::ends(entries);
                Located { value: [lowest.value, highest.value], at: entries.at }
            });
            let law = entries.map(|entries| StripLawSpec::Table(entries.value));
            ProjectionKeys::Strip { law, azimuth: azimuth(reader, section), elevation }
        }
        Table::Radial(entries) => {
            let [inner, outer] = match &entries {
                Some(entries) => table::ends(entries).map(Some),
                None => [None; 2],
            };
            let law = entries.map(|entries| RadialLawSpec::Table(entries.value));
            ProjectionKeys::Radial { law, inner, outer }
        }
    })
}

fn azimuth(reader: &mut ProfileReader, section: &Section) -> Option<Located<[f64; 2]>> {
    let form = "a full turn is azimuth_deg = [-180, 180]";
    let azimuth = NumbersFormat {
        key: "azimuth_deg",
        parts: "[first, last]",
        each: "from -360 to 360",
        form,
        limit: form,
    };
    let range = numbers(reader, section, &azimuth, |f| (-360.0..=360.0).contains(&f))?;
    let path = section.path_of("azimuth_deg");
    rising(reader, &path, &range)?;
    let span = range.value[1] - range.value[0];
    if span > 360.0 {
        let message = format!("{path} must span at most 360 degrees, found {span}");
        let hint = "a panorama shows each direction once; a full turn is [-180, 180]";
        reader.complain(range.at, message, hint);
        return None;
    }
    Some(range)
}

fn elevation(
    reader: &mut ProfileReader,
    section: &Section,
    name: &str,
    law: &StripLawSpec,
) -> Option<Located<[f64; 2]>> {
    let limit = match law {
        StripLawSpec::Named(law) if law.pole_coordinate().is_none() => {
            format!("the {name} law reaches the pole only at infinity; use 89 or less, -89 or more")
        }
        _ => POLE.to_owned(),
    };
    let elevation = NumbersFormat {
        key: "elevation_deg",
        parts: "[lowest, highest]",
        each: "strictly between -90 and 90",
        form: "degrees above the horizon, as in elevation_deg = [-30, 30]",
        limit: &limit,
    };
    let range = numbers(reader, section, &elevation, below_the_pole)?;
    rising(reader, &section.path_of("elevation_deg"), &range)?;
    Some(range)
}

fn rising(reader: &mut ProfileReader, path: &str, range: &Located<[f64; 2]>) -> Option<()> {
    let [low, high] = range.value;
    if low < high {
        return Some(());
    }
    let message = format!("{path} must rise from first to last, found [{low}, {high}]");
    let hint = if low > high {
        format!("swap them: [{high}, {low}]")
    } else {
        "the two ends are the same, so the picture would be empty".to_owned()
    };
    reader.complain(range.at, message, &hint);
    None
}

fn inner_polar(
    reader: &mut ProfileReader,
    section: &Section,
    law: RadialLawKind,
) -> Option<Located<f64>> {
    if !law.has_two_parameters() {
        return None;
    }
    let hint = INNER_POLAR;
    let need = Optional;
    if law == RadialLawKind::Cylinder {
        let must = "strictly between 0 and 180";
        let inside = |f| 0.0 < f && f < 180.0;
        return number(reader, section, "inner_polar_deg", need, must, hint, inside);
    }
    let must = "0 or more and less than 180";
    number(reader, section, "inner_polar_deg", need, must, hint, |f| (0.0..180.0).contains(&f))
}

/// Hint at the meaning of the polar angle at the inner rim.
pub(super) const INNER_POLAR: &str =
    "the angle between the axis towards the camera and what the inner rim shows";

fn outer_polar(
    reader: &mut ProfileReader,
    section: &Section,
    law: RadialLawKind,
) -> Option<Located<f64>> {
    let (must, most, hint) = match law {
        RadialLawKind::Plane => (
            "strictly between 0 and 90",
            90.0,
            "the plane is on the camera's side, and at 90 degrees it is infinitely far out",
        ),
        _ => (
            "strictly between 0 and 180",
            180.0,
            "the angle between the axis towards the camera and what the outer rim shows; 90 is \
             the horizon",
        ),
    };
    let inside = |f| 0.0 < f && f < most;
    number(reader, section, "outer_polar_deg", Required, must, hint, inside)
}

impl ProjectionEntry<'_> {
    /// The panels, if it is of panels.
    pub(super) fn panels(&self) -> Option<&[PanelKeys]> {
        match &self.keys {
            ProjectionKeys::Panels(panels) => Some(panels),
            _ => None,
        }
    }

    pub(super) fn is_radial(&self) -> bool {
        matches!(self.keys, ProjectionKeys::Radial { .. })
    }

    /// Whether its law is a table.
    pub(super) fn is_table(&self) -> bool {
        match &self.keys {
            ProjectionKeys::Strip { law, .. } => matches!(law, Some(StripLawSpec::Table(_))),
            ProjectionKeys::Radial { law, .. } => matches!(law, Some(RadialLawSpec::Table(_))),
            ProjectionKeys::Azimuthal(_) | ProjectionKeys::Map(_) | ProjectionKeys::Panels(_) => {
                false
            }
        }
    }

    /// The key of the polar angle at the inner or outer rim, `named` where it is not a table's.
    pub(super) fn polar_path(&self, named: &str) -> String {
        if self.is_table() {
            let end = if named == "inner_polar_deg" { "first" } else { "last" };
            format!("the {end} of the degrees in {}", self.section.path_of("polar_deg"))
        } else {
            self.section.path_of(named)
        }
    }

    /// Surface that the picture shows.
    pub(super) fn target(&self) -> Target {
        match (self.radius, self.plane, &self.posed) {
            (Some(radius), ..) => Target::Cylinder { radius_mm: radius.value },
            (None, Some(plane), _) => Target::Plane { height_mm: plane.value },
            (None, None, Some(target)) => Target::Posed(target.clone()),
            (None, None, None) => Target::Infinity,
        }
    }

    /// The projection, if every figure of it is there; a disc has no inner rim.
    pub(super) fn finish(self, disc: bool) -> Option<ProjectionSpec> {
        let target = self.target();
        Some(match self.keys {
            ProjectionKeys::Strip { law, azimuth, elevation } => ProjectionSpec::Strip(StripSpec {
                law: law?,
                azimuth_deg: azimuth?.value,
                elevation_deg: elevation?.value,
                target,
            }),
            ProjectionKeys::Radial { law, inner, outer } => ProjectionSpec::Radial(RadialSpec {
                law: law?,
                inner_polar_deg: inner.filter(|_| !disc).map(|inner| inner.value),
                outer_polar_deg: outer?.value,
                target,
            }),
            ProjectionKeys::Azimuthal(keys) => ProjectionSpec::Azimuthal(keys.finish(target)?),
            ProjectionKeys::Map(keys) => ProjectionSpec::Map(keys?.finish(target)),
            ProjectionKeys::Panels(panels) => {
                let finish = |panel: PanelKeys| panel.finish(target.clone());
                let panels: Option<_> = panels.into_iter().map(finish).collect();
                ProjectionSpec::Panels(panels?)
            }
        })
    }
}
