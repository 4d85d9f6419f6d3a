//! The unit of a file of a mesh, which seldom states it.

use super::reference_surface::ReferenceSurface;
use crate::geom::{Border, DVec3, TriMesh};
use crate::mirror::Mirror;

/// A unit of length that files of meshes use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetres.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches.
    In,
    /// Micrometres.
    Um,
}

impl LengthUnit {
    /// All units; where several suit equally well, the first does.
    pub const ALL: [Self; 5] = [Self::Mm, Self::Cm, Self::M, Self::In, Self::Um];

    /// Its symbol.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
            Self::In => "in",
            Self::Um => "um",
        }
    }

    /// The unit of that symbol.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.name() == name)
    }

    /// Its English name.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Mm => "millimetre",
            Self::Cm => "centimetre",
            Self::M => "metre",
            Self::In => "inch",
            Self::Um => "micrometre",
        }
    }

    /// Its length, mm.
    #[must_use]
    pub fn mm(self) -> f64 {
        match self {
            Self::Mm => 1.0,
            Self::Cm => 10.0,
            Self::M => 1000.0,
            Self::In => 25.4,
            Self::Um => 1e-3,
        }
    }

    /// Brings coordinates in this unit to mm; those in mm keep every bit.
    pub fn convert(self, mesh: &mut TriMesh) {
        if self != Self::Mm {
            mesh.vertices.iter_mut().for_each(|v| *v *= self.mm());
        }
    }
}

/// Range of a part's size, whatever its pose: the distance of nearly all of its surface from its middle,
/// mm. The least is that of the mirror alone, the largest that of the part with its border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeRange {
    least: f64,
    most: f64,
}

/// Share of the vertices within a mesh's size: outliers are beyond.
const NEARLY_ALL: f64 = 0.9;
/// Meshes may have their vertices closer together in the middle.
const DENSER: f64 = 0.8;
/// Factor by which a size may be out of the range.
const OFF: f64 = 1.25;

impl SizeRange {
    /// Of a part of `mirror`, with `stock` around it.
    #[must_use]
    pub fn of(mirror: &Mirror, stock: Option<&Border>) -> Self {
        let reference = ReferenceSurface::new(mirror);
        let (mut reach, mut top) = (0.0_f64, 0.0_f64);
        for line in mirror.full_outline().samples(8) {
            let places: Vec<_> = line.iter().map(|s| s.0).collect();
            for (q, point) in places.iter().zip(mirror.eval_many(&places)) {
                let at = mirror.position(*q, &point);
                reach = reach.max(at.truncate().length());
                top = top.max(at.z);
            }
        }
        for corner in stock.iter().flat_map(|stock| stock.contour.polygon()) {
            reach = reach.max(corner.length());
        }
        Self { least: DENSER * reference.radius, most: crate::num::hypot(reach, 0.5 * top) }
    }

    /// The unit that makes `mesh` a part of this size, and whether one does; mm otherwise.
    #[must_use]
    pub fn unit(&self, mesh: &TriMesh) -> (LengthUnit, bool) {
        let size = size(&mesh.vertices);
        let off = |unit: LengthUnit| {
            let mm = size * unit.mm();
            (self.least / mm).max(mm / self.most).max(1.0)
        };
        let suits = |unit: &LengthUnit| off(*unit) <= OFF;
        let best =
            LengthUnit::ALL.into_iter().filter(suits).min_by(|a, b| off(*a).total_cmp(&off(*b)));
        best.map_or((LengthUnit::Mm, false), |unit| (unit, true))
    }

    /// How many times too large a mesh in millimetres is, if it is too large or too small (below 1): as a
    /// ratio of that unit to the millimetre where one explains it, else roughly.
    #[must_use]
    pub fn size_factor(&self, mesh: &TriMesh) -> Option<(f64, Option<LengthUnit>)> {
        let size = size(&mesh.vertices);
        let off = |factor: f64| (factor * self.least / size).max(size / (factor * self.most));
        if !(size > 0.0 && off(1.0) > OFF) {
            return None;
        }
        let factors = LengthUnit::ALL
            .into_iter()
            .flat_map(|unit| [(unit.mm(), unit), (1.0 / unit.mm(), unit)]);
        let suits = factors.filter(|&(factor, _)| off(factor) <= OFF);
        let best = suits.min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
        let about = size / (self.least * self.most).sqrt();
        Some(best.map_or((about, None), |(factor, unit)| (factor, Some(unit))))
    }
}

/// The distance of nearly all places from the median of their coordinates.
fn size(places: &[DVec3]) -> f64 {
    if places.is_empty() {
        return 0.0;
    }
    let at = |mut numbers: Vec<f64>, share: f64| {
        let rank = (share * (numbers.len() - 1) as f64) as usize;
        *numbers.select_nth_unstable_by(rank, f64::total_cmp).1
    };
    let middle =
        DVec3::from_array([0, 1, 2].map(|k| at(places.iter().map(|p| p[k]).collect(), 0.5)));
    at(places.iter().map(|p| (*p - middle).length()).collect(), NEARLY_ALL)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_told_by_size_and_none_where_none_suits() {
        let place = |k: u32| DVec3::new(f64::from(k % 61) - 30.0, f64::from(k / 61) - 22.0, 9.0);
        let vertices: Vec<DVec3> = (0..61 * 45).map(place).collect();
        let known = SizeRange { least: DENSER * 30.0, most: 38.0 };
        let scaled = |factor: f64| TriMesh {
            vertices: vertices.iter().map(|v| *v * factor).collect(),
            triangles: Vec::new(),
        };
        for unit in LengthUnit::ALL {
            for factor in [0.85, 1.0, 1.2] {
                let (found, clear) = known.unit(&scaled(factor / unit.mm()));
                assert_eq!((found, clear), (unit, true), "{factor}");
            }
            let mut mesh = scaled(1.0 / unit.mm());
            unit.convert(&mut mesh);
            assert!((mesh.vertices[7] - vertices[7]).length() < 1e-13);
            assert_eq!(LengthUnit::named(unit.name()), Some(unit));
        }
        for factor in [5.0, 0.2] {
            assert_eq!(known.unit(&scaled(factor)), (LengthUnit::Mm, false));
        }
        assert_eq!(known.unit(&TriMesh::default()), (LengthUnit::Mm, false));
        assert_eq!(known.size_factor(&scaled(1.0)), None);
        for (factor, unit) in
            [(25.4, LengthUnit::In), (1.0 / 25.4, LengthUnit::In), (10.0, LengthUnit::Cm)]
        {
            assert_eq!(known.size_factor(&scaled(factor)), Some((factor, Some(unit))));
        }
        let (about, unit) = known.size_factor(&scaled(4.0)).unwrap();
        assert!((about / 4.0 - 1.0).abs() < 0.3 && unit.is_none(), "{about}");
    }
}
