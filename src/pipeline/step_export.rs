//! The STEP file: written from splines, and held against the design once it was read back as a solid.

use super::Error;
use super::cad_export::{CadExport, CadFigures, CadFindings};
use super::form_study::{FormStudy, pmi_facts};
use crate::brep::Body;
use crate::design::Design;
use crate::export::step::{
    FittedBody, FittedMirror, Pmi, StepSchema, fit_splines, fit_tool, write_step,
};
use crate::export::{ByteCounter, Label};
use crate::forming::FormingTool;
use crate::geom::{DVec2, DVec3, Ray, angle};
use crate::mirror::Mirror;
use crate::part::Promise;
use crate::profile::{CadFormat, Profile, StepProtocol};
use crate::results::{FileFault, PmiFacts, StepBodyFacts, StepFacts};
use std::io::{self, Write};

/// Rays along each side of the outline by which a solid is held against the design.
const ACROSS: u32 = 64;
/// Distance from the design at which those rays begin, mm.
const BEFORE_MM: f64 = 50.0;
/// Distance from a tool's face at which rays square to it begin, mm: less than any cavity is wide.
const BESIDE_MM: f64 = 0.01;
/// What is between the places where a spline's error was measured: a dozen a span see all but a hundredth of it.
const BETWEEN: f64 = 1.02;
/// What coordinates of nine decimals and rounding of the crossing leave, mm.
const ROUNDING_MM: f64 = 2e-9;
/// What points and curves of a file may be apart, mm: what Morion's files say of themselves.
const UNCERTAINTY_MM: f64 = 1e-7;

/// The STEP file of a designed mirror.
pub(super) struct StepExport<'a> {
    design: &'a Design,
    fit: FittedMirror,
    /// Splines of the roof of a cavity.
    roof: Option<FittedMirror>,
    schema: StepSchema,
    /// What it says of datum features and tolerance.
    pmi: Option<PmiFacts>,
}

impl<'a> StepExport<'a> {
    /// Fits splines to the mirror of `design`.
    ///
    /// # Errors
    /// [`Error::Step`] when none suit it.
    pub(super) fn new(profile: &Profile, design: &'a Design) -> Result<Self, Error> {
        let fit = match &design.tool {
            Some(tool) => fit_tool(&design.mirror, tool),
            None => fit_splines(&design.mirror).and_then(|fit| {
                fit.check_land(design.border.as_ref())?;
                Ok(fit)
            }),
        };
        let fail = |source| Error::Step { profile: profile.name.clone(), source };
        let fit = fit.map_err(fail)?;
        let cavity = design.cavity.as_ref();
        let roof = cavity.map(|cavity| fit_splines(&cavity.roof)).transpose().map_err(fail)?;
        let (schema, pmi) = match profile.step {
            StepProtocol::Ap214 => (StepSchema::Ap214, None),
            StepProtocol::Ap242 => {
                let limit = FormStudy::new(design).and_then(|study| study.limit());
                let facts = pmi_facts(design, limit.as_ref());
                let profile_mm = facts.surface_profile_mm;
                (StepSchema::Ap242(Pmi { datums: design.datums(), profile_mm }), Some(facts))
            }
        };
        Ok(Self { design, fit, roof, schema, pmi })
    }

    /// The errors that the file may have.
    fn promise(&self) -> Promise {
        let chord_mm = BETWEEN * self.fit.error_mm + ROUNDING_MM;
        Promise { chord_mm, ..Promise::of_profile(&self.design.profile) }
    }
}

/// What a solid has of a design that it is `limit_mm` off at most, and what it lacks.
pub(super) fn compared(
    body: &Body,
    design: &Design,
    limit_mm: f64,
) -> (StepBodyFacts, Vec<FileFault>) {
    let (off, size_mm) = match &design.tool {
        Some(tool) => (SurfaceDepartures::of_tool(body, &design.mirror, tool), tool.size_mm),
        None => (SurfaceDepartures::of(body, &design.mirror), design.mounting.size_mm),
    };
    let (facts, (_, designed_mm3)) = (body.facts(), design.made_body());
    let mut faults = Vec::new();
    if off.missed > 0 {
        faults.push(FileFault::Missed { missed: off.missed, rays: off.rays });
    }
    if !(off.along_normal_mm <= limit_mm) {
        faults.push(FileFault::SurfaceError { off_mm: off.along_normal_mm, limit_mm });
    }
    // Every face may be off by so much, and those of a cavity are no larger.
    let [x, y, z] = size_mm;
    let boxes = if design.cavity.is_some() { 2.0 } else { 1.0 };
    let allowed = (limit_mm + UNCERTAINTY_MM) * boxes * 2.0 * (x * y + y * z + z * x);
    if !((facts.volume_mm3 - designed_mm3).abs() <= allowed) {
        faults.push(FileFault::VolumeError { found_mm3: facts.volume_mm3, designed_mm3 });
    }
    let facts = StepBodyFacts {
        faces: facts.faces,
        edges: facts.edges,
        gap_nm: facts.gap_mm * 1e6,
        volume_mm3: facts.volume_mm3,
        rays: off.rays,
        surface_error_nm: off.along_normal_mm * 1e6,
        normal_error_rad: off.normal_rad,
    };
    (facts, faults)
}

impl CadExport for StepExport<'_> {
    fn format(&self) -> CadFormat {
        CadFormat::Step
    }

    fn write(&self, mut out: &mut dyn Write, label: &Label) -> io::Result<()> {
        let body = FittedBody { mirror: &self.fit, roof: self.roof.as_ref() };
        write_step(&mut out, body, self.design.made_body().0, &self.schema, label)
    }

    fn bytes(&self, label: &Label) -> u64 {
        let mut bytes = ByteCounter::default();
        self.write(&mut bytes, label).map_or(0, |()| bytes.count())
    }

    fn check(&self, bytes: &[u8]) -> CadFindings {
        let promise = self.promise();
        let (body, facts, faults) = match Body::read(bytes) {
            Ok(body) => {
                let (facts, faults) = compared(&body, self.design, promise.chord_mm);
                // The camera sees what is formed on a tool, not the tool.
                let seen = self.design.tool.is_none().then_some((body, promise));
                (seen, Some(facts), faults)
            }
            Err(error) => (None, None, vec![FileFault::Unreadable(error.to_string())]),
        };
        let facts = StepFacts {
            fit_error_nm: self.fit.error_mm * 1e6,
            control_points: self.fit.size(),
            pmi: self.pmi.clone(),
            body: facts,
        };
        CadFindings { faults, figures: Some(CadFigures::Step(facts)), body }
    }
}

/// How far a solid is from a designed mirror, on rays from the camera.
#[derive(Default)]
struct SurfaceDepartures {
    /// Number of rays.
    rays: usize,
    /// Number of those that miss the solid.
    missed: usize,
    /// Largest distance along the design's normal, mm.
    along_normal_mm: f64,
    /// Largest angle between the normals, radians.
    normal_rad: f64,
}

impl SurfaceDepartures {
    /// Of rays in a grid over the mirror's outline, none of which is on a line between panels of the middle.
    fn of(body: &Body, mirror: &Mirror) -> Self {
        let mut all = Self::default();
        for places in grid(mirror) {
            for (&q, place) in places.iter().zip(mirror.eval_many(&places)) {
                let at = mirror.position(q, &place);
                let direction = mirror.chart.ray(q, 0.0).direction;
                let ray = Ray { origin: at - direction * BEFORE_MM, direction };
                all.add(body, &ray, (at, mirror.normal(q, &place).normalize()));
            }
        }
        all
    }

    /// The same of rays square to the face of a tool, from just outside.
    fn of_tool(body: &Body, mirror: &Mirror, tool: &FormingTool) -> Self {
        let surface = tool.surface(mirror);
        let mut all = Self::default();
        for q in grid(mirror).concat() {
            let place = mirror.extended_surface(q);
            let at = tool.from_part(surface.beside(&place));
            let normal = tool.outward(place.normal());
            let ray = Ray { origin: at + BESIDE_MM * normal, direction: -normal };
            all.add(body, &ray, (at, normal));
        }
        all
    }

    /// Adds a ray that meets the mirror at a place with such a normal.
    fn add(&mut self, body: &Body, ray: &Ray, (at, normal): (DVec3, DVec3)) {
        self.rays += 1;
        let Some(hit) = body.nearest_hit(ray, 0.0, f64::INFINITY) else {
            self.missed += 1;
            return;
        };
        let off = (ray.at(hit.t) - at).dot(normal).abs();
        self.along_normal_mm = self.along_normal_mm.max(off);
        self.normal_rad = self.normal_rad.max(angle(hit.normal, normal));
    }
}

/// Places in lines of a grid over the mirror's outline, none of which is on a line between panels of the middle.
fn grid(mirror: &Mirror) -> Vec<Vec<DVec2>> {
    let outline = mirror.full_outline();
    let bounds = outline.bounds();
    let share = |k: u32, beside: f64| (f64::from(k) + beside) / f64::from(ACROSS);
    let place = |column: u32, row: u32| {
        bounds.min + bounds.size() * DVec2::new(share(column, 0.37), share(row, 0.41))
    };
    let line = |row: u32| -> Vec<DVec2> {
        (0..ACROSS).map(|column| place(column, row)).filter(|&q| outline.aims(q)).collect()
    };
    (0..ACROSS).map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::super::mesh_files::labelled;
    use super::*;
    use crate::design::design;

    /// What the check of the panoramic mirror's STEP file says once its text is changed so.
    fn faults(change: impl FnOnce(&str) -> String) -> Vec<FileFault> {
        let text = include_bytes!("../../profiles/panoramic.toml");
        let profile = Profile::parse("panoramic", "panoramic.toml", text).unwrap();
        let design = design(&profile).unwrap();
        let export = StepExport::new(&profile, &design).unwrap();
        let mut bytes = Vec::new();
        export.write(&mut bytes, &labelled(&design, String::new())).unwrap();
        let text = change(std::str::from_utf8(&bytes).unwrap());
        export.check(text.as_bytes()).faults
    }

    #[test]
    fn what_is_written_is_what_is_designed() {
        assert_eq!(faults(str::to_owned), []);
    }

    /// Between the places where its error was measured this spline is a hundredth farther off.
    #[test]
    fn a_spline_keeps_its_promise_between_the_places_of_the_fit() {
        let text = "
            camera.orthographic.pixels = [13, 20]
            mount = { fold_deg = -22.1, towards_deg = 2.216 }
            projection.perspective = { hfov_deg = 27.03, target_radius_mm = 21.61 }
            layout.rectangle = {}
            method.fixed-surface = { degree = 8, minimax = false }
            part = { width_mm = 3.265, base_mm = 0.3915, border_mm = 1.221, corner_radius_mm = 0.3716 }
            mesh = { chord_um = 1.109, facet_px = 1.408 }
            export.formats = [\"step\"]
        ";
        let profile = Profile::parse("narrow", "narrow.toml", text.as_bytes()).unwrap();
        let design = design(&profile).unwrap();
        let export = StepExport::new(&profile, &design).unwrap();
        let mut bytes = Vec::new();
        export.write(&mut bytes, &labelled(&design, String::new())).unwrap();
        let CadFindings { faults, figures, .. } = export.check(&bytes);
        assert_eq!(faults, []);
        let Some(CadFigures::Step(StepFacts { fit_error_nm, body: Some(body), .. })) = figures
        else {
            panic!("no figures")
        };
        assert!(body.surface_error_nm > fit_error_nm + 1e6 * ROUNDING_MM, "{body:?}");
    }

    #[test]
    fn a_control_point_moved_by_ten_nanometres_is_off_the_design() {
        let off = faults(|text| {
            let coordinates = |line: &str| -> Option<Vec<f64>> {
                let list = line.split_once("=CARTESIAN_POINT('',(")?.1.strip_suffix("));")?;
                list.split(',').map(|number| number.parse().ok()).collect()
            };
            let points = text.lines().filter_map(|line| Some((line, coordinates(line)?)));
            let is_on_top = |p: &[f64]| p.iter().all(|x| x.abs() > 0.1);
            let middle = |p: &[f64]| p[0].abs() + p[1].abs();
            let (line, p) = points
                .filter(|(_, p)| is_on_top(p))
                .min_by(|(_, a), (_, b)| middle(a).total_cmp(&middle(b)))
                .unwrap();
            let head = line.split_once('=').unwrap().0;
            let moved =
                format!("{head}=CARTESIAN_POINT('',({},{},{:.10}));", p[0], p[1], p[2] + 1e-5);
            text.replacen(line, &moved, 1)
        });
        assert!(matches!(off[..], [FileFault::SurfaceError { .. }]), "{off:?}");
    }

    #[test]
    fn a_part_in_centimetres_is_off_the_design() {
        let off = faults(|text| text.replacen(".MILLI.", ".CENTI.", 1));
        assert!(matches!(off[..], [.., FileFault::VolumeError { .. }]), "{off:?}");
    }
}
