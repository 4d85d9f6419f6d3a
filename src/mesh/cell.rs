//! The lattice cell that suits each place: how large, how long, and which way round.
//!
//! With vertices on the mirror the fewest facets are (DESIGN's bounds): on bowls equilateral
//! triangles in the metric of the curvature; on saddles, for the chord, squares in that metric,
//! turned from the principal directions by half of atan(1/2), for then all four edges of a square
//! and both of its diagonals reach the tolerance at once; on saddles, for the image, right
//! triangles with legs along the directions that are conjugate in the curvature and perpendicular
//! in the image, for then a facet shows what the mirror shows in the middle of its longest edge.

use super::needs::{Needs, Place, SLENDER};
use crate::geom::{DVec2, Outline};
use glam::DMat2;
use rayon::prelude::*;

/// Growth of neighbouring cells.
const GRADE: f64 = 0.3;
/// Largest cell, in sizes of the domain.
const LARGEST: f64 = 1.0;
/// Steps between nodes along the domain's sides.
const SIDE: usize = 48;
/// Half of atan(1/2): its cosine and sine.
const TURN: DVec2 = DVec2::new(0.973_248_989_474_818_7, 0.229_752_920_547_268_07);
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
pub enum Kind {
    /// Equilateral triangles in the metric of the curvature.
    Triangles,
    /// Equilateral triangles in the metric of the image.
    ImageTriangles,
    /// Squares in the metric of the curvature, turned from the principal directions.
    Squares,
    /// Squares in the metric of the image along conjugate directions.
    ImageSquares,
}

impl Kind {
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
    fn room(self, needs: &Needs, place: &Place, shape: &DMat2) -> f64 {
        let ways = self.ways();
        let [a, b] = [*shape * ways[0], *shape * ways[1]];
        let room = needs.room(place, a, b);
        if ways.len() == 6 { room } else { room.max(needs.room(place, a, a + b)) }
    }

    /// The cell's map from unit steps, of any size.
    fn shape(self, place: &Place) -> DMat2 {
        let h = &place.curvature;
        let curvature = Symmetric { xx: h.xx, xy: h.xy, yy: h.yy };
        let image = || place.per_slope * curvature.matrix();
        match self {
            Self::Triangles => curvature.spread().1,
            Self::ImageTriangles => {
                let k = image();
                Symmetric::of(k.transpose() * k).spread().1
            }
            Self::Squares => {
                let (lengths, _) = curvature.spread();
                let turn = DMat2::from_cols(TURN, TURN.perp());
                curvature.axes() * DMat2::from_diagonal(lengths) * turn
            }
            Self::ImageSquares => {
                // K = A H has K e_k of unit length for e_k = A' y_k / s_k, with A H A' y = s y.
                let a = place.per_slope;
                let both = Symmetric::of(a * curvature.matrix() * a.transpose());
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
struct Symmetric {
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Symmetric {
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
pub struct Cells<'a> {
    /// What they must do.
    pub needs: &'a Needs,
    /// The lattice.
    pub kind: Kind,
    /// Fine cells to the side of one of these.
    pub parts: usize,
    aim: f64,
    /// What suits the nodes alone, as they are asked.
    alone: Vec<Alone>,
    /// The fine lattice's at the nodes.
    nodes: Vec<DMat2>,
    fit: DVec2,
}

/// What suits one place, whatever its neighbours want.
#[derive(Debug, Clone, Copy)]
struct Alone {
    /// The cell, of any size.
    shape: DMat2,
    /// The square root of its area.
    size: f64,
    /// By how much it may be enlarged.
    room: f64,
}

impl<'a> Cells<'a> {
    /// The cells of the kind of which the fewest will do, `aim` times as large as the limits allow
    /// facets of the quadratic model to be.
    pub fn new(needs: &'a Needs, outline: &Outline, aim: f64, most: f64) -> Self {
        let make = |kind: Kind| {
            let nodes: Vec<DVec2> = needs.domain().grid(SIDE, SIDE).map(|(q, _)| q).collect();
            let alone = |&q: &DVec2| {
                let place = needs.at(q);
                let shape = kind.shape(&place);
                let size = shape.determinant().abs().sqrt();
                Alone { shape, size, room: kind.room(needs, &place, &shape) }
            };
            let alone = nodes.par_iter().map(alone).collect();
            let mut cells =
                Self { needs, kind, parts: 1, aim, alone, nodes: Vec::new(), fit: DVec2::ONE };
            cells.grade();
            let count = cells.count(outline);
            (cells, count)
        };
        let better = |a: (Self, f64), b: (Self, f64)| if b.1 < a.1 { b } else { a };
        let kinds: &[Kind] = if needs.sees() { &Kind::ALL } else { &Kind::BLIND };
        let made: Vec<_> = kinds.par_iter().copied().map(make).collect();
        let (mut cells, count) = made.into_iter().reduce(better).expect("there are kinds");
        cells.parts = ((count / most).sqrt().round() as usize).max(1);
        if cells.parts > 1 {
            cells.grade();
        }
        cells.settle();
        cells
    }

    /// The share of the limits that facets of the model take.
    pub fn aim(&self) -> f64 {
        self.aim
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
    pub fn sides(&self, place: &Place) -> [DVec2; 2] {
        let shape = self.kind.shape(place);
        [shape * self.kind.ways()[0], shape * self.kind.ways()[1]]
    }

    /// About how many fine facets cover the outline's part in the domain.
    pub fn count(&self, outline: &Outline) -> f64 {
        let domain = self.needs.domain();
        let nodes = domain.grid(SIDE, SIDE).zip(&self.nodes);
        let inside = nodes.filter(|((q, _), _)| outline.contains(*q));
        let area = |cell: &DMat2| cell.determinant().abs() * self.kind.area();
        inside.map(|((_, share), cell)| 2.0 * share / area(cell)).sum()
    }

    /// The map from unit steps to those of the lattice at `q`.
    pub fn at(&self, q: DVec2) -> DMat2 {
        let (k, f) = self.corner(q);
        let own = self.nodes[k];
        let [right, up, across] =
            [k + 1, k + SIDE + 1, k + SIDE + 2].map(|k| self.turned(self.nodes[k], &own));
        let low = own + (right - own) * f.x;
        let high = up + (across - up) * f.x;
        DMat2::from_diagonal(self.fit * self.parts as f64) * (low + (high - low) * f.y)
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

    /// The node before `q`, and how far `q` is on the way to the next ones.
    fn corner(&self, q: DVec2) -> (usize, DVec2) {
        let (domain, last) = (self.needs.domain(), SIDE as f64);
        let share =
            ((q - domain.min) / domain.size() * last).clamp(DVec2::ZERO, DVec2::splat(last));
        // Truncation is floor for what is not negative, and quicker.
        let [i, j] = share.to_array().map(|x| (x as usize).min(SIDE - 1));
        (j * (SIDE + 1) + i, share - DVec2::new(i as f64, j as f64))
    }

    /// Limits the cells so that neighbours are of similar size.
    fn grade(&mut self) {
        const SLACK: f64 = 1.05;
        let width = SIDE + 1;
        let domain = self.needs.domain();
        let parts = self.parts as f64;
        let cap = LARGEST * domain.size().min_element() / parts;
        let size = |alone: &Alone| {
            let size = self.aim * alone.room * alone.size;
            if size < cap { size } else { cap }
        };
        let mut table: Vec<f64> = self.alone.iter().map(size).collect();
        let step = domain.size() / SIDE as f64;
        let grow = DVec2::new(step.x, step.y) * (GRADE / parts);
        for forward in [true, false, true, false] {
            let last = table.len() - 1;
            for k in 0..=last {
                let k = if forward { k } else { last - k };
                let (i, j) = (k % width, k / width);
                let mut least = table[k];
                if i > 0 {
                    least = least.min(table[k - 1] + grow.x);
                }
                if i < SIDE {
                    least = least.min(table[k + 1] + grow.x);
                }
                if j > 0 {
                    least = least.min(table[k - width] + grow.y);
                }
                if j < SIDE {
                    least = least.min(table[k + width] + grow.y);
                }
                table[k] = least;
            }
        }
        let node = |(alone, largest): (&Alone, f64)| {
            let &Alone { shape, size, room } = alone;
            let (room, largest) = (self.aim * room, SLACK * largest);
            // A place that asks for nothing, or of which nothing is known, takes what others leave.
            let scale = if room * size < largest { room } else { largest / size };
            let cell = shape * scale;
            if cell.is_finite() { cell } else { DMat2::from_diagonal(DVec2::splat(largest)) }
        };
        self.nodes = self.alone.iter().zip(table).map(node).collect();
    }

    /// Shrinks the cells by a little so that whole numbers fit along the domain's lower and left
    /// sides.
    fn settle(&mut self) {
        const STEPS: usize = 64;
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
        self.fit = DVec2::new(x / x.ceil().max(1.0), y / y.ceil().max(1.0));
    }
}
