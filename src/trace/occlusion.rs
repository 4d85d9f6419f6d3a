//! Proof that reflected rays are unoccluded, for whole packets of them.
//!
//! A line from outside a closed mesh and back to it crosses as many facets inwards as outwards. So a
//! reflected ray, which starts outside, meets nothing if every facet that it could meet shows it its
//! back: no crossing inwards balances one outwards. Facets that it passes above cannot be met. Both are
//! decided for the cells of a quadtree over the plane, from the greatest height in each and bounds of
//! the normals (docs/theory.md, T52).

use super::closed_mesh::is_closed;
use crate::brep::SurfacePiece;
use crate::geom::{DVec2, DVec3, TriMesh};
use crate::parallel;

/// Facets per smallest cell that the tree aims at.
const FACETS_PER_CELL: f64 = 64.0;
/// Least and largest number of smallest cells.
const CELLS: [f64; 2] = [256.0, 1e6];
/// Least cosine between a ray and the normal of a facet whose back it certainly sees: rounding is far
/// below it.
const LEAST_COSINE: f64 = 1e-3;
/// Facets of a chunk sorted by one thread, whatever the number of threads.
const CHUNK: usize = 1 << 16;
/// Share of the mesh's size by which cells are enlarged: rounding is far below it.
const MARGIN: f64 = 1e-9;

/// Bounds of the facets of one class in a cell: their height, and a box around their normals.
#[derive(Debug, Clone, Copy)]
struct NormalCone {
    /// Greatest Z, mm.
    top: f64,
    /// Least and largest components of the unit normals.
    normals: [DVec3; 2],
}

/// Bounds of the facets in a cell, apart for those facing up, sideways and down.
type FacetClasses = [NormalCone; 3];

impl NormalCone {
    /// Bounds of no facet.
    const EMPTY: Self = Self {
        top: f64::NEG_INFINITY,
        normals: [DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY)],
    };

    /// Widens the bounds by those of other facets.
    #[inline]
    fn extend(&mut self, other: &Self) {
        self.top = if other.top > self.top { other.top } else { self.top };
        widen(&mut self.normals, other.normals);
    }
}

/// Widens the bounds of a cell by those of another.
#[inline]
fn gather(into: &mut FacetClasses, from: &FacetClasses) {
    into.iter_mut().zip(from).for_each(|(into, from)| into.extend(from));
}

/// The cells of one size of the quadtree.
#[derive(Debug, Clone)]
struct Level {
    /// Side of a cell, mm.
    cell: f64,
    /// Columns and rows.
    count: [usize; 2],
    /// Bounds of the facets that fit cells of this size and not the next smaller ones.
    own: Vec<FacetClasses>,
    /// Bounds of these and of all smaller facets.
    all: Vec<FacetClasses>,
}

/// A packet of rays: a box around their origins and one around their directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct RayPacket {
    /// Least and largest coordinates of the origins, mm.
    pub from: [DVec3; 2],
    /// Least and largest components of the unit directions.
    pub along: [DVec3; 2],
    /// A sum that is finite as long as all coordinates are.
    check: f64,
}

impl RayPacket {
    /// A packet of no ray.
    pub(super) const EMPTY: Self = Self {
        from: [DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY)],
        along: [DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY)],
        check: 0.0,
    };

    /// Adds the ray from `at` along `direction`.
    #[inline]
    pub(super) fn add(&mut self, at: DVec3, direction: DVec3) {
        widen(&mut self.from, [at; 2]);
        widen(&mut self.along, [direction; 2]);
        // A distance that is not finite shows in Z, of parallel rays in Z alone; a sum stays so.
        self.check += at.z + direction.element_sum();
    }

    /// Least and largest distance at which a ray of the packet can be over a box, mm; `None` if no ray is.
    #[inline]
    fn over(&self, lo: DVec2, hi: DVec2) -> Option<[f64; 2]> {
        let (mut first, mut last) = (0.0f64, f64::INFINITY);
        for axis in 0..2 {
            // From the side of least coordinates, the farthest ray must have come as far as the box,
            // and the nearest one must not have passed it.
            let sides = [
                (lo[axis] - self.from[1][axis], self.along[1][axis]),
                (self.from[0][axis] - hi[axis], -self.along[0][axis]),
            ];
            for (away, speed) in sides {
                if speed > 0.0 {
                    first = first.max(away / speed);
                } else if speed < 0.0 {
                    last = last.min(away / speed);
                } else if away > 0.0 {
                    return None;
                }
            }
        }
        (first <= last).then_some([first, last])
    }

    /// Whether every ray, at these distances, passes above the facets of a cell or sees their backs.
    #[inline]
    fn passes(&self, facets: &FacetClasses, [first, last]: [f64; 2], margin: f64) -> bool {
        let climb = self.along[0].z;
        let z = self.from[0].z + climb * if climb < 0.0 { last } else { first };
        facets.iter().all(|cone| cone.top + margin < z || self.least_cosine(cone) > LEAST_COSINE)
    }

    /// Lower bound of the cosine between rays and normals.
    #[inline]
    fn least_cosine(&self, cone: &NormalCone) -> f64 {
        let ([a, b], [m, n]) = (self.along, cone.normals);
        let least = (a * m).min(a * n).min(b * m).min(b * n);
        least.x + least.y + least.z
    }
}

/// Widens a box so that it holds another.
#[inline]
fn widen([least, most]: &mut [DVec3; 2], [lo, hi]: [DVec3; 2]) {
    // (As one machine instruction each; NaN is left out.)
    let lesser = |a: f64, b: f64| if a < b { a } else { b };
    let greater = |a: f64, b: f64| if a > b { a } else { b };
    *least = DVec3::new(lesser(lo.x, least.x), lesser(lo.y, least.y), lesser(lo.z, least.z));
    *most = DVec3::new(greater(hi.x, most.x), greater(hi.y, most.y), greater(hi.z, most.z));
}

/// A quadtree over a closed mesh that proves packets of reflected rays unoccluded.
#[derive(Debug, Clone)]
pub(super) struct OcclusionProof {
    /// Lower corner of the first cell, mm: a whole number of smallest cells from X = Y = 0, so that a
    /// fold there is a border of cells.
    origin: DVec2,
    /// Smallest cells first; the last level has one cell.
    levels: Vec<Level>,
    /// Enlargement of cells against rounding, mm.
    margin: f64,
}

impl OcclusionProof {
    /// The quadtree over `mesh`, which may be known to be `closed`; `None` where it is not, for then the argument
    /// fails.
    pub(super) fn new(mesh: &TriMesh, closed: bool) -> Option<Self> {
        let (lo, hi) = mesh.bounds()?;
        let wanted = mesh.triangles.len() as f64 / FACETS_PER_CELL;
        let cells = CellGrid::over([lo, hi], wanted)?;
        let facet = |triangle: &[u32; 3]| {
            FacetBounds::of_facet(triangle.map(|v| mesh.vertices[v as usize]))
        };
        let (levels, closed) =
            parallel::join(|| cells.levels(&mesh.triangles, facet), || closed || is_closed(mesh));
        closed.then_some(Self { origin: cells.origin, levels, margin: cells.margin })
    }

    /// The quadtree over a closed body of curved pieces between `bounds`.
    pub(super) fn of_closed(pieces: &[SurfacePiece], bounds: [DVec3; 2]) -> Option<Self> {
        let cells = CellGrid::over(bounds, pieces.len() as f64)?;
        let levels = cells
            .levels(pieces, |piece| FacetBounds { bounds: piece.bounds, normals: piece.normals });
        Some(Self { origin: cells.origin, levels, margin: cells.margin })
    }

    /// Whether no ray of `packet` meets a facet. The rays must start on the outer side of facets, where
    /// these can be seen from outside the mesh.
    pub(super) fn is_unoccluded(&self, packet: &RayPacket) -> bool {
        packet.check.is_finite() && self.cell_is_clear(self.levels.len() - 1, [0, 0], packet)
    }

    /// Whether the packet meets no facet in a cell of a level.
    fn cell_is_clear(&self, level: usize, at: [usize; 2], packet: &RayPacket) -> bool {
        let Level { cell, count, own, all } = &self.levels[level];
        let lo = self.origin + DVec2::new(at[0] as f64, at[1] as f64) * *cell;
        let widened = DVec2::splat(self.margin);
        let Some(span) = packet.over(lo - widened, lo + DVec2::splat(*cell) + widened) else {
            return true;
        };
        let k = at[1] * count[0] + at[0];
        if packet.passes(&all[k], span, self.margin) {
            return true;
        }
        if level == 0 || !packet.passes(&own[k], span, self.margin) {
            return false;
        }
        let finer = self.levels[level - 1].count;
        let [columns, rows] = [0, 1].map(|k| 2 * at[k]..(2 * at[k] + 2).min(finer[k]));
        rows.flat_map(|j| columns.clone().map(move |i| [i, j]))
            .all(|at| self.cell_is_clear(level - 1, at, packet))
    }
}

/// Bounds of a facet, or of a piece of a curved face: of its places, mm, and of its unit normals.
#[derive(Debug, Clone, Copy)]
struct FacetBounds {
    bounds: [DVec3; 2],
    normals: [DVec3; 2],
}

impl FacetBounds {
    #[inline]
    fn of_facet([a, b, c]: [DVec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        let unit = normal / normal.length();
        let all = DVec3::ONE;
        let normals = if unit.is_finite() { [unit; 2] } else { [-all, all] };
        Self { bounds: [a.min(b).min(c), a.max(b).max(c)], normals }
    }

    /// Number of its class: facing up, sideways or down.
    #[inline]
    fn class(&self) -> usize {
        let [lo, hi] = self.normals;
        if lo.z > 0.1 {
            0
        } else if hi.z < -0.1 {
            2
        } else {
            1
        }
    }
}

/// Where the cells of the quadtree lie.
struct CellGrid {
    origin: DVec2,
    cell: f64,
    margin: f64,
    /// Side of the cells, and the numbers of columns and rows, of every level.
    sizes: Vec<(f64, [usize; 2])>,
}

impl CellGrid {
    /// About so many cells between bounds; `None` where these are not finite.
    fn over([lo, hi]: [DVec3; 2], wanted: f64) -> Option<Self> {
        let size = (hi - lo).truncate().max(DVec2::splat(1e-6 * (hi - lo).max_element()));
        let wanted = wanted.clamp(CELLS[0], CELLS[1]);
        // Few digits, so that multiples are exact.
        let cell = f64::from_bits((size.x * size.y / wanted).sqrt().to_bits() >> 44 << 44);
        let origin = (lo.truncate() / cell).floor() * cell;
        let margin = MARGIN * lo.abs().max(hi.abs()).max_element();
        if !(cell > 0.0 && margin.is_finite()) {
            return None;
        }
        let mut sizes =
            vec![(cell, [0, 1].map(|k| ((hi.truncate() - origin)[k] / cell) as usize + 1))];
        while let Some(&(cell, [columns, rows])) = sizes.last()
            && columns.max(rows) > 1
        {
            sizes.push((2.0 * cell, [columns.div_ceil(2), rows.div_ceil(2)]));
        }
        Some(Self { origin, cell, margin, sizes })
    }

    /// The levels of the quadtree over facets.
    fn levels<T: Sync>(
        &self,
        facets: &[T],
        bounds: impl Fn(&T) -> FacetBounds + Sync,
    ) -> Vec<Level> {
        let empty = || -> Vec<Vec<FacetClasses>> {
            let cells = self.sizes.iter().map(|(_, [columns, rows])| columns * rows);
            cells.map(|cells| vec![[NormalCone::EMPTY; 3]; cells]).collect()
        };
        let size = CHUNK.max(facets.len().div_ceil(4));
        let sorted = parallel::map_chunks(facets, size, |chunk| {
            let mut own = empty();
            for facet in chunk {
                self.sort(&bounds(facet), &mut own);
            }
            own
        });
        let own = sorted.into_iter().reduce(|mut a, b| {
            for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
                gather(a, b);
            }
            a
        });
        let mut levels: Vec<Level> = Vec::with_capacity(self.sizes.len());
        for (&(cell, count), own) in self.sizes.iter().zip(own.unwrap_or_else(empty)) {
            let mut all = own.clone();
            if let Some(Level { count: [columns, _], all: finer, .. }) = levels.last() {
                for (k, facets) in finer.iter().enumerate() {
                    gather(&mut all[k / columns / 2 * count[0] + k % columns / 2], facets);
                }
            }
            levels.push(Level { cell, count, own, all });
        }
        levels
    }

    /// Adds a facet to the cells that it touches in the first level where these are four at most.
    #[inline]
    fn sort(&self, facet: &FacetBounds, own: &mut [Vec<FacetClasses>]) {
        let [columns, rows] = self.sizes[0].1;
        let [lo, hi] = facet.bounds;
        let first = (lo.truncate() - self.origin) / self.cell;
        let last = (hi.truncate() - self.origin) / self.cell;
        // A facet that ends on a border does not count in the cell beyond: cells are enlarged when asked.
        let index = |x: f64, count: usize| (x as usize).min(count - 1);
        let before = |x: f64, count: usize| {
            let k = index(x, count);
            if k > 0 && k as f64 == x { k - 1 } else { k }
        };
        let (mut first, mut last) = (
            [index(first.x, columns), index(first.y, rows)],
            [before(last.x, columns), before(last.y, rows)],
        );
        let mut level = 0;
        while last[0] > first[0] + 1 || last[1] > first[1] + 1 {
            first = first.map(|k| k / 2);
            last = last.map(|k| k / 2);
            level += 1;
        }
        let (class, cone) = (facet.class(), NormalCone { top: hi.z, normals: facet.normals });
        for j in first[1]..=last[1].max(first[1]) {
            for i in first[0]..=last[0].max(first[0]) {
                own[level][j * self.sizes[level].1[0] + i][class].extend(&cone);
            }
        }
    }
}
