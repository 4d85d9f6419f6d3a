//! The lattice cell that suits each place: how large, how long, and which way round.
//!
//! With vertices on the mirror the fewest facets are (docs/theory.md, T42 to T44): on bowls
//! equilateral triangles in the metric of the curvature; on saddles, for the chord, squares in that
//! metric, turned from the principal directions by half of atan(1/2), for then all four edges of a
//! square and both of its diagonals reach the tolerance at once; on saddles, for the image, right
//! triangles with legs along the directions that are conjugate in the curvature and perpendicular
//! in the image, for then a facet shows what the mirror shows in the middle of its longest edge.

use super::field::{LocalModel, SLENDER, SizingField};
use crate::geom::{DVec2, Outline};
use crate::parallel;
use glam::DMat2;
use std::sync::Arc;

/// Growth of neighbouring cells.
const GRADE: f64 = 0.3;
/// Largest cell, in sizes of the domain.
const LARGEST: f64 = 1.0;
/// Steps between nodes along the domain's sides, and while the kind of lattice is chosen.
const SIDE: usize = 48;
const ROUGH_SIDE: usize = 24;
/// Half of atan(1/2): its cosine and sine.
const TURN: DVec2 = DVec2::new(0.973_248_989_474_818_7, 0.229_752_920_547_268_07);
/// Nodes that a thread looks at at a time, at least.
const CHUNK: usize = 64;
const SIN_60: f64 = 0.866_025_403_784_438_6;
const SQUARE: [DVec2; 4] = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
const HEXAGON: [DVec2; 6] = [
    DVec2::X,
    DVec2::new(0.5, SIN_60),
    DVec2::new(-0.5, SIN_60),
    DVec2::NEG_X,
    DVec2::new(-0.5, -SIN_60),
    DVec2::new(0.5, -SIN_60),
];

/// Kinds of lattices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LatticeKind {
    /// Equilateral triangles in the metric of the curvature.
    Triangles,
    /// Equilateral triangles in the metric of the image.
    ImageTriangles,
    /// Squares in the metric of the curvature, turned from the principal directions.
    Squares,
    /// Squares in the metric of the image along conjugate directions.
    ImageSquares,
}

impl LatticeKind {
    const ALL: [Self; 4] =
        [Self::Triangles, Self::Squares, Self::ImageTriangles, Self::ImageSquares];
    /// Those for a mirror without an image.
    const BLIND: [Self; 2] = [Self::Triangles, Self::Squares];

    /// The steps to a point's neighbours, in cells.
    pub fn ways(self) -> &'static [DVec2] {
        match self {
            Self::Triangles | Self::ImageTriangles => &HEXAGON,
            Self::Squares | Self::ImageSquares => &SQUARE,
        }
    }

    /// Whether its directions are the image's, which turn the most.
    pub fn turns(self) -> bool {
        self == Self::ImageSquares
    }

    /// Area of two facets, in cells.
    fn area(self) -> f64 {
        if self.ways().len() == 6 { SIN_60 } else { 1.0 }
    }

    /// By how much a cell may be enlarged at a place.
    fn room(self, needs: &SizingField, place: &LocalModel, shape: &DMat2) -> f64 {
        let ways = self.ways();
        let [a, b] = [*shape * ways[0], *shape * ways[1]];
        let room = needs.room(place, a, b);
        if ways.len() == 6 { room } else { room.max(needs.room(place, a, a + b)) }
    }

    /// The cell's map from unit steps, of any size.
    fn shape(self, place: &LocalModel) -> DMat2 {
        let h = &place.curvature;
        let curvature = SymmetricMatrix { xx: h.xx, xy: h.xy, yy: h.yy };
        let image = || place.per_slope * curvature.matrix();
        match self {
            Self::Triangles => curvature.spread().1,
            Self::ImageTriangles => {
                let k = image();
                SymmetricMatrix::of(k.transpose() * k).spread().1
            }
            Self::Squares => {
                let (lengths, _) = curvature.spread();
                let turn = DMat2::from_cols(TURN, TURN.perp());
                curvature.axes() * DMat2::from_diagonal(lengths) * turn
            }
            Self::ImageSquares => {
                // K = A H has K e_k of unit length for e_k = A' y_k / s_k, with A H A' y = s y.
                let a = place.per_slope;
                let both = SymmetricMatrix::of(a * curvature.matrix() * a.transpose());
                let sides = a.transpose() * both.axes();
                let s = both.values().abs();
                let [x, y] = [sides.x_axis / s.x, sides.y_axis / s.y];
                let longest = SLENDER * x.length().min(y.length());
                let cell =
                    DMat2::from_cols(x.clamp_length_max(longest), y.clamp_length_max(longest));
                // Not mirrored.
                let side = if cell.determinant() < 0.0 { -1.0 } else { 1.0 };
                DMat2::from_cols(cell.x_axis, cell.y_axis * side)
            }
        }
    }
}

/// A symmetric matrix.
#[derive(Debug, Clone, Copy)]
struct SymmetricMatrix {
    xx: f64,
    xy: f64,
    yy: f64,
}

impl SymmetricMatrix {
    fn of(m: DMat2) -> Self {
        Self { xx: m.x_axis.x, xy: 0.5 * (m.x_axis.y + m.y_axis.x), yy: m.y_axis.y }
    }

    fn matrix(&self) -> DMat2 {
        DMat2::from_cols(DVec2::new(self.xx, self.xy), DVec2::new(self.xy, self.yy))
    }

    /// Eigenvalues, the larger first.
    fn values(&self) -> DVec2 {
        let mean = 0.5 * (self.xx + self.yy);
        let half = DVec2::new(0.5 * (self.xx - self.yy), self.xy).length();
        DVec2::new(mean + half, mean - half)
    }

    /// Unit eigenvectors, as columns in the order of the values.
    fn axes(&self) -> DMat2 {
        let half = 0.5 * (self.xx - self.yy);
        let radius = DVec2::new(half, self.xy).length();
        let first = if half >= 0.0 {
            DVec2::new(radius + half, self.xy)
        } else {
            DVec2::new(self.xy, radius - half)
        };
        let first = first.normalize_or(DVec2::X);
        DMat2::from_cols(first, first.perp())
    }

    /// |M|^-1/2 with its length limited: its eigenvalues, and itself.
    fn spread(&self) -> (DVec2, DMat2) {
        let sizes = self.values().abs();
        let least = sizes.max_element() / (SLENDER * SLENDER);
        let lengths = sizes.max(DVec2::splat(least)).map(|s| 1.0 / s.sqrt());
        let axes = self.axes();
        (lengths, axes * DMat2::from_diagonal(lengths) * axes.transpose())
    }
}

/// The cells of one panel.
#[derive(Clone)]
pub struct FrameField<'a> {
    /// What they must do.
    pub needs: &'a SizingField,
    /// The lattice.
    pub kind: LatticeKind,
    /// Fine cells to the side of one of these.
    pub parts: usize,
    aim: f64,
    /// Steps between nodes along the domain's sides.
    side: usize,
    /// What suits the nodes alone, as they are asked.
    alone: Arc<Vec<UngradedCell>>,
    /// The fine lattice's at the nodes.
    nodes: Vec<DMat2>,
    /// Between each four nodes, bilinear: at the first, and what x, y and x y add.
    between: Arc<Vec<[DMat2; 4]>>,
    fit: DVec2,
}

/// What suits one place, whatever its neighbours want.
#[derive(Debug, Clone, Copy)]
struct UngradedCell {
    /// The cell, of any size.
    shape: DMat2,
    /// The square root of its area.
    size: f64,
    /// By how much it may be enlarged.
    room: f64,
}

impl<'a> FrameField<'a> {
    /// The cells of the kind of which the fewest will do, `aim` times as large as the limits allow
    /// facets of the quadratic model to be.
    pub fn new(needs: &'a SizingField, outline: &Outline, aim: f64, most: f64) -> Self {
        let rough =
            |&kind: &LatticeKind| (kind, Self::graded(needs, kind, aim, ROUGH_SIDE).count(outline));
        let better = |a: (LatticeKind, f64), b: (LatticeKind, f64)| if b.1 < a.1 { b } else { a };
        let kinds: &[LatticeKind] =
            if needs.sees() { &LatticeKind::ALL } else { &LatticeKind::BLIND };
        let counts = parallel::map_slice(kinds, 1, rough);
        let (kind, _) = counts.into_iter().reduce(better).expect("there are kinds");
        let mut cells = Self::graded(needs, kind, aim, SIDE);
        let count = cells.count(outline);
        // Up to 1.7 times as many where they need not be cut, half as many where in two to the side.
        cells.parts = (((count / most).sqrt() - 0.3).ceil() as usize).max(1);
        if cells.parts > 1 {
            cells.grade();
        }
        cells.settle();
        cells
    }

    /// The cells of one kind, as they come; not yet ready to be looked up between nodes.
    fn graded(needs: &'a SizingField, kind: LatticeKind, aim: f64, side: usize) -> Self {
        let nodes: Vec<DVec2> = needs.domain().grid(side, side).map(|(q, _)| q).collect();
        let alone = |&q: &DVec2| {
            let place = needs.at(q);
            let shape = kind.shape(&place);
            let size = shape.determinant().abs().sqrt();
            UngradedCell { shape, size, room: kind.room(needs, &place, &shape) }
        };
        let mut cells = Self {
            needs,
            kind,
            parts: 1,
            aim,
            side,
            alone: Arc::new(parallel::map_slice(&nodes, CHUNK, alone)),
            nodes: Vec::new(),
            between: Arc::default(),
            fit: DVec2::ONE,
        };
        cells.grade();
        cells
    }

    /// The share of the limits that facets of the model take.
    pub fn aim(&self) -> f64 {
        self.aim
    }

    /// The same with what fitting whole numbers of cells to the sides changed, along each axis.
    pub fn taken(&self) -> DVec2 {
        self.fit * self.aim
    }

    /// Takes `by` times as many fine cells to the side of each.
    pub fn coarsen(&mut self, by: usize) {
        self.parts *= by;
        self.grade();
        self.settle();
    }

    /// Makes the cells `aim` times as large as the limits allow.
    pub fn rescale(&mut self, aim: f64) {
        self.aim = aim;
        self.grade();
        self.settle();
    }

    /// Two sides of a facet at a place.
    pub fn sides(&self, place: &LocalModel) -> [DVec2; 2] {
        let shape = self.kind.shape(place);
        [shape * self.kind.ways()[0], shape * self.kind.ways()[1]]
    }

    /// About how many fine facets cover the outline's part in the domain.
    pub fn count(&self, outline: &Outline) -> f64 {
        let domain = self.needs.domain();
        let nodes = domain.grid(self.side, self.side).zip(&self.nodes);
        let inside = nodes.filter(|((q, _), _)| outline.contains(*q));
        let area = |cell: &DMat2| cell.determinant().abs() * self.kind.area();
        inside.map(|((_, share), cell)| 2.0 * share / area(cell)).sum()
    }

    /// The map from unit steps to those of the lattice at `q`.
    pub fn at(&self, q: DVec2) -> DMat2 {
        let (k, f) = self.corner(q);
        let [own, by_x, by_y, by_both] = &self.between[k];
        let cell = *own + *by_x * f.x + (*by_y + *by_both * f.x) * f.y;
        let scale = self.fit * self.parts as f64;
        DMat2::from_cols(cell.x_axis * scale, cell.y_axis * scale)
    }

    /// The same, turned about so that it continues `before`.
    pub fn following(&self, q: DVec2, before: &DMat2) -> DMat2 {
        self.turned(self.at(q), before)
    }

    /// The same cell, turned about so that it is most like `other`.
    fn turned(&self, cell: DMat2, other: &DMat2) -> DMat2 {
        // How alike `other` the cell is when its first side is turned to a way is linear in the way.
        let c = cell.transpose() * *other;
        let way = DVec2::new(c.x_axis.x + c.y_axis.y, c.x_axis.y - c.y_axis.x);
        let alike = |to: &&DVec2| to.dot(way);
        let better = |a, b| if alike(&b) > alike(&a) { b } else { a };
        let way = self.kind.ways().iter().reduce(better).expect("ways");
        cell * DMat2::from_cols(*way, way.perp())
    }

    /// Steps along the rim at `q` in direction `way`, in lengths of `way`: of a cell, or what the
    /// limits leave to an edge.
    pub fn step(&self, q: DVec2, way: DVec2) -> f64 {
        let step = 1.0 / (self.at(q).inverse() * way).length();
        let place = self.needs.at(q);
        step.min(self.aim * self.parts as f64 * self.needs.edge_room(&place, way))
    }

    /// Between which nodes `q` is, and how far on the way from the first to the others.
    fn corner(&self, q: DVec2) -> (usize, DVec2) {
        let (domain, last) = (self.needs.domain(), self.side as f64);
        let share =
            ((q - domain.min) / domain.size() * last).clamp(DVec2::ZERO, DVec2::splat(last));
        // Truncation is floor for what is not negative, and quicker.
        let [i, j] = share.to_array().map(|x| (x as usize).min(self.side - 1));
        (j * self.side + i, share - DVec2::new(i as f64, j as f64))
    }

    /// Limits the cells so that neighbours are of similar size.
    fn grade(&mut self) {
        const SLACK: f64 = 1.05;
        let (side, width) = (self.side, self.side + 1);
        let domain = self.needs.domain();
        let parts = self.parts as f64;
        let cap = LARGEST * domain.size().min_element() / parts;
        let size = |alone: &UngradedCell| {
            let size = self.aim * alone.room * alone.size;
            if size < cap { size } else { cap }
        };
        let mut table: Vec<f64> = self.alone.iter().map(size).collect();
        let grow = domain.size() / side as f64 * (GRADE / parts);
        let less = |a: f64, b: f64| if a < b { a } else { b };
        let limit = |table: &mut [f64], i: usize, j: usize| {
            let k = j * width + i;
            let mut least = table[k];
            if i > 0 {
                least = less(table[k - 1] + grow.x, least);
            }
            if i < side {
                least = less(table[k + 1] + grow.x, least);
            }
            if j > 0 {
                least = less(table[k - width] + grow.y, least);
            }
            if j < side {
                least = less(table[k + width] + grow.y, least);
            }
            table[k] = least;
        };
        for _ in 0..2 {
            for j in 0..width {
                (0..width).for_each(|i| limit(&mut table, i, j));
            }
            for j in (0..width).rev() {
                (0..width).rev().for_each(|i| limit(&mut table, i, j));
            }
        }
        let node = |(alone, largest): (&UngradedCell, f64)| {
            let &UngradedCell { shape, size, room } = alone;
            let (room, largest) = (self.aim * room, SLACK * largest);
            // A place that asks for nothing, or of which nothing is known, takes what others leave.
            let scale = if room * size < largest { room } else { largest / size };
            let cell = shape * scale;
            if cell.is_finite() { cell } else { DMat2::from_diagonal(DVec2::splat(largest)) }
        };
        self.nodes = self.alone.iter().zip(table).map(node).collect();
    }

    /// Makes the cells ready to be looked up, and smaller by so little that whole numbers of them fit
    /// along the domain's lower and left sides.
    fn settle(&mut self) {
        const STEPS: usize = 64;
        const FITTED: f64 = 1e-9;
        let side = self.side;
        let between = |k: usize| {
            let k = k / side * (side + 1) + k % side;
            let own = self.nodes[k];
            let [right, up, across] =
                [k + 1, k + side + 1, k + side + 2].map(|k| self.turned(self.nodes[k], &own));
            [own, right - own, up - own, across - up - (right - own)]
        };
        self.between = Arc::new(parallel::map(side * side, CHUNK, between));
        self.fit = DVec2::ONE;
        let domain = self.needs.domain();
        let size = domain.size();
        let count = |way: DVec2, length: f64| -> f64 {
            let step = length / STEPS as f64;
            (0..STEPS)
                .map(|k| {
                    let q = domain.min + way * (step * (k as f64 + 0.5));
                    (self.at(q).inverse() * way * step).length()
                })
                .sum()
        };
        let (x, y) = (count(DVec2::X, size.x), count(DVec2::Y, size.y));
        // What has been fitted already is not to grow by one for its rounding.
        let whole = |x: f64| (x - FITTED).ceil().max(1.0);
        self.fit = DVec2::new(x / whole(x), y / whole(y));
    }
}
