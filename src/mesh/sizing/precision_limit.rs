//! Refusal of limits that rounding to single precision alone exceeds (theory, T48).

use super::field::SizingField;
use super::local_model::{LocalModel, rounding_along_ray};
use super::tuning::TUNING;
use crate::geom::{DVec2, Outline, Rect};
use crate::mesh::bound::tuning::TUNING as BOUND_TUNING;
use crate::mesh::error::MeshError;
use crate::mirror::Mirror;
use crate::num::sort_by_number;

impl SizingField {
    /// Checks that single precision alone keeps the chord limit.
    ///
    /// # Errors
    /// [`MeshError::PrecisionLimit`] at the place where rounding moves a vertex farthest.
    pub(crate) fn check_chord_rounding(&self, mirror: &Mirror) -> Result<(), MeshError> {
        let Some(limit) = self.limits.chord_mm else { return Ok(()) };
        let worse = |a: (f64, DVec2), b: (f64, DVec2)| if b.0 > a.0 { b } else { a };
        let inside = self.cell_centres().filter(|&q| mirror.outline.contains(q));
        let roughly = inside.map(|q| (self.at(q).rounding_mm, q)).reduce(worse);
        let Some((mut attained, mut at)) = roughly else { return Ok(()) };
        if attained < limit && limit * BOUND_TUNING.least_rounding_left < attained {
            let precision = self.limits.precision;
            let rounding = |(q, way)| (rounding_along_ray(mirror, q, way, precision), q);
            let places =
                self.flattest_places(mirror).map(|q| (q, None)).chain(self.side_places(mirror));
            (attained, at) = places.map(rounding).fold((attained, at), worse);
        }
        if attained < limit {
            return Ok(());
        }
        Err(MeshError::PrecisionLimit { at, chord_mm: Some(attained), facet_mm: None })
    }

    /// Places along the domain's sides, with the direction in which vertices there may be snapped: under parallel rays
    /// along the side, which changes no digit but those of Z.
    fn side_places(&self, mirror: &Mirror) -> impl Iterator<Item = (DVec2, Option<DVec2>)> {
        let Rect { min, max } = self.domain();
        let is_plain = mirror.chart.is_plan() && matches!(mirror.outline, Outline::Rect(_));
        let places = TUNING.places_per_side;
        let count = if is_plain { places } else { 0 };
        (0..count).flat_map(move |k| {
            let at = min + (max - min) * (k as f64 / (places - 1) as f64);
            let [along_x, along_y] = [DVec2::X, DVec2::Y].map(Some);
            [
                (DVec2::new(at.x, min.y), along_x),
                (DVec2::new(at.x, max.y), along_x),
                (DVec2::new(min.x, at.y), along_y),
                (DVec2::new(max.x, at.y), along_y),
            ]
        })
    }

    /// Places in the cells of the table where the mirror is flattest: there, over less than a cell, snapping does not
    /// help.
    fn flattest_places(&self, mirror: &Mirror) -> impl Iterator<Item = DVec2> {
        let steep = |q: DVec2| mirror.slope(q, &mirror.surface.at(q)).length();
        let mut cells: Vec<(f64, DVec2)> = self.cell_centres().map(|q| (steep(q), q)).collect();
        sort_by_number(&mut cells, |cell| cell.0);
        cells.truncate(TUNING.flattest_cells);
        let half = 0.5 * self.domain().size() / TUNING.table_cells as f64;
        let cell = move |(_, q): (f64, DVec2)| Rect { min: q - half, max: q + half };
        let outline = mirror.outline;
        let side = TUNING.places_per_cell;
        cells
            .into_iter()
            .flat_map(move |found| cell(found).grid(side, side).map(|(q, _)| q).collect::<Vec<_>>())
            .filter(move |&q| outline.contains(q))
    }

    /// Checks that rounding does not tilt facets with two edges as `edges` says by more than the facet limit allows,
    /// over half of the mirror. (Snapping may save the facets of some places.)
    ///
    /// # Errors
    /// [`MeshError::PrecisionLimit`] at the place of the median.
    pub(crate) fn check_facet_tilt(
        &self,
        outline: &Outline,
        edges: impl Fn(&LocalModel) -> [DVec2; 2],
    ) -> Result<(), MeshError> {
        let Some(limit) = self.limits.facet_mm else { return Ok(()) };
        let least = |q: DVec2| {
            let model = self.at(q);
            let [a, b] = edges(&model);
            let error = model.facet_squared(a, b).sqrt();
            (2.0 * (error * TUNING.likely_tilt * model.tilt(a, b)).sqrt(), q)
        };
        let inside = self.cell_centres().filter(|&q| outline.contains(q));
        let mut found: Vec<(f64, DVec2)> = inside.map(least).filter(|f| f.0.is_finite()).collect();
        sort_by_number(&mut found, |found| found.0);
        match found.get(found.len() / 2) {
            Some(&(attained, at)) if attained >= limit => {
                Err(MeshError::PrecisionLimit { at, chord_mm: None, facet_mm: Some(attained) })
            }
            _ => Ok(()),
        }
    }
}
