//! The frame field: size, shape and direction of the lattice cell at every place of a panel, graded and interpolated.

use super::field::SizingField;
use super::lattice::LatticeKind;
use super::local_model::LocalModel;
use super::tuning::TUNING;
use crate::geom::{DVec2, Outline};
use crate::parallel;
use glam::DMat2;
use std::sync::Arc;

/// Nodes that a thread takes at a time, at least: some microseconds of work.
const CHUNK: usize = 64;
/// Share of a cell by which a fitted number of cells may exceed a whole one by rounding.
const FITTED: f64 = 1e-9;

/// Lattice cells over one panel.
#[derive(Clone)]
pub(crate) struct FrameField {
    /// The sizing field that they follow.
    pub sizing: SizingField,
    /// Kind of the lattice.
    pub kind: LatticeKind,
    /// Fine cells to the side of one of these (coarse) cells.
    pub parts: usize,
    relative_size: f64,
    /// Node intervals along the domain's sides.
    side: usize,
    /// The cells that suit the nodes before grading.
    ungraded: Arc<Vec<UngradedCell>>,
    /// The fine cells at the nodes.
    nodes: Vec<DMat2>,
    /// Bilinear interpolation between each four nodes: the first cell, and the coefficients of x, y and x y.
    between: Arc<Vec<[DMat2; 4]>>,
    fit: DVec2,
}

/// The cell that suits one place, whatever suits its neighbours.
#[derive(Debug, Clone, Copy)]
struct UngradedCell {
    /// The cell, of any size.
    shape: DMat2,
    /// Square root of its area.
    size: f64,
    /// Factor by which it may be enlarged.
    enlargement: f64,
}

impl FrameField {
    /// The cells of the kind of which the fewest will do, with facets of the quadratic model `relative_size` times as
    /// large as the limits allow; of fine cells about `most` facets, and coarse ones of equal parts beyond that.
    pub(crate) fn new(
        sizing: &SizingField,
        outline: &Outline,
        relative_size: f64,
        most: f64,
    ) -> Self {
        let rough = |&kind: &LatticeKind| {
            let graded = Self::graded(sizing, kind, relative_size, TUNING.nodes_for_kind);
            (kind, graded.facet_count(outline))
        };
        let better = |a: (LatticeKind, f64), b: (LatticeKind, f64)| if b.1 < a.1 { b } else { a };
        let kinds: &[LatticeKind] =
            if sizing.limits_image() { &LatticeKind::ALL } else { &LatticeKind::BY_CURVATURE };
        let counts = parallel::map_slice(kinds, 1, rough);
        let (kind, _) = counts.into_iter().reduce(better).expect("there are kinds");
        let mut cells = Self::graded(sizing, kind, relative_size, TUNING.nodes);
        let count = cells.facet_count(outline);
        cells.parts = (((count / most).sqrt() - TUNING.parts_rounding).ceil() as usize).max(1);
        if cells.parts > 1 {
            cells.grade();
        }
        cells.prepare_lookup();
        cells
    }

    /// The graded cells of one kind, not yet ready to be looked up between nodes.
    fn graded(sizing: &SizingField, kind: LatticeKind, relative_size: f64, side: usize) -> Self {
        let nodes: Vec<DVec2> = sizing.domain().grid(side, side).map(|(q, _)| q).collect();
        let ungraded = |&q: &DVec2| {
            let model = sizing.at(q);
            let shape = kind.cell(&model);
            let size = shape.determinant().abs().sqrt();
            UngradedCell { shape, size, enlargement: kind.enlargement(sizing, &model, &shape) }
        };
        let mut cells = Self {
            sizing: sizing.clone(),
            kind,
            parts: 1,
            relative_size,
            side,
            ungraded: Arc::new(parallel::map_slice(&nodes, CHUNK, ungraded)),
            nodes: Vec::new(),
            between: Arc::default(),
            fit: DVec2::ONE,
        };
        cells.grade();
        cells
    }

    /// Size of the facets of the quadratic model, relative to the one that the limits allow.
    pub(crate) fn relative_size(&self) -> f64 {
        self.relative_size
    }

    /// Relative size along each axis after whole numbers of cells were fitted to the sides.
    pub(crate) fn fitted_size(&self) -> DVec2 {
        self.fit * self.relative_size
    }

    /// Takes `by` times as many fine cells to the side of each.
    pub(crate) fn coarsen(&mut self, by: usize) {
        self.parts *= by;
        self.grade();
        self.prepare_lookup();
    }

    /// Makes the cells `relative_size` times as large as the limits allow.
    pub(crate) fn rescale(&mut self, relative_size: f64) {
        self.relative_size = relative_size;
        self.grade();
        self.prepare_lookup();
    }

    /// Two edges of a facet at a place, of any size.
    pub(crate) fn facet_edges(&self, model: &LocalModel) -> [DVec2; 2] {
        let cell = self.kind.cell(model);
        [cell * self.kind.steps()[0], cell * self.kind.steps()[1]]
    }

    /// Estimated number of fine facets that cover the outline's part in the domain.
    pub(crate) fn facet_count(&self, outline: &Outline) -> f64 {
        let domain = self.sizing.domain();
        let nodes = domain.grid(self.side, self.side).zip(&self.nodes);
        let inside = nodes.filter(|((q, _), _)| outline.contains(*q));
        let area = |cell: &DMat2| cell.determinant().abs() * self.kind.area();
        inside.map(|((_, share), cell)| 2.0 * share / area(cell)).sum()
    }

    /// The coarse cell at `q`: the map from unit steps to steps of the lattice.
    pub(crate) fn at(&self, q: DVec2) -> DMat2 {
        let (k, f) = self.interval(q);
        let [own, by_x, by_y, by_both] = &self.between[k];
        let cell = *own + *by_x * f.x + (*by_y + *by_both * f.x) * f.y;
        let scale = self.fit * self.parts as f64;
        DMat2::from_cols(cell.x_axis * scale, cell.y_axis * scale)
    }

    /// The cell at `q`, turned by steps of the lattice so that it continues `before`.
    pub(crate) fn continued(&self, q: DVec2, before: &DMat2) -> DMat2 {
        self.aligned(self.at(q), before)
    }

    /// The cell, turned by steps of the lattice so that it is most like `other`.
    fn aligned(&self, cell: DMat2, other: &DMat2) -> DMat2 {
        // How alike `other` the cell is when its first side is turned to a step is linear in the step.
        let c = cell.transpose() * *other;
        let likeness = DVec2::new(c.x_axis.x + c.y_axis.y, c.x_axis.y - c.y_axis.x);
        let alike = |to: &&DVec2| to.dot(likeness);
        let better = |a, b| if alike(&b) > alike(&a) { b } else { a };
        let step = self.kind.steps().iter().reduce(better).expect("steps");
        cell * DMat2::from_cols(*step, step.perp())
    }

    /// Length of an edge of the boundary at `q` in the direction `along`, in lengths of `along`: that of a cell, or the
    /// one that the limits leave to an edge.
    pub(crate) fn boundary_step(&self, q: DVec2, along: DVec2) -> f64 {
        let step = 1.0 / (self.at(q).inverse() * along).length();
        let model = self.sizing.at(q);
        let most = self.sizing.edge_enlargement(&model, along);
        step.min(self.relative_size * self.parts as f64 * most)
    }

    /// The interval between nodes in which `q` is, and its position in it, from 0 to 1.
    fn interval(&self, q: DVec2) -> (usize, DVec2) {
        let (domain, last) = (self.sizing.domain(), self.side as f64);
        let share =
            ((q - domain.min) / domain.size() * last).clamp(DVec2::ZERO, DVec2::splat(last));
        // Truncation is floor for what is not negative, and quicker.
        let [i, j] = share.to_array().map(|x| (x as usize).min(self.side - 1));
        (j * self.side + i, share - DVec2::new(i as f64, j as f64))
    }

    /// Limits the cells so that neighbours are of similar size.
    fn grade(&mut self) {
        let largest = self.graded_sizes();
        let node = |(ungraded, largest): (&UngradedCell, f64)| {
            let &UngradedCell { shape, size, enlargement } = ungraded;
            let (scale, largest) =
                (self.relative_size * enlargement, TUNING.grading_slack * largest);
            // A place without any limit, or without a finite model, takes what its neighbours leave.
            let scale = if scale * size < largest { scale } else { largest / size };
            let cell = shape * scale;
            if cell.is_finite() { cell } else { DMat2::from_diagonal(DVec2::splat(largest)) }
        };
        self.nodes = self.ungraded.iter().zip(largest).map(node).collect();
    }

    /// The largest size of a fine cell at each node, mm, that grows by no more than the grading from node to node.
    fn graded_sizes(&self) -> Vec<f64> {
        let (side, width) = (self.side, self.side + 1);
        let domain = self.sizing.domain();
        let parts = self.parts as f64;
        let cap = TUNING.largest_cell * domain.size().min_element() / parts;
        let size = |cell: &UngradedCell| {
            let size = self.relative_size * cell.enlargement * cell.size;
            if size < cap { size } else { cap }
        };
        let mut table: Vec<f64> = self.ungraded.iter().map(size).collect();
        let grow = domain.size() / side as f64 * (TUNING.grading / parts);
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
        // Sizes spread in both directions of both axes.
        for _ in 0..2 {
            for j in 0..width {
                (0..width).for_each(|i| limit(&mut table, i, j));
            }
            for j in (0..width).rev() {
                (0..width).rev().for_each(|i| limit(&mut table, i, j));
            }
        }
        table
    }

    /// Makes the cells ready to be looked up, and smaller by so little that whole numbers of them fit along the
    /// domain's lower and left sides.
    fn prepare_lookup(&mut self) {
        let side = self.side;
        let between = |k: usize| {
            let k = k / side * (side + 1) + k % side;
            let own = self.nodes[k];
            let [right, up, across] =
                [k + 1, k + side + 1, k + side + 2].map(|k| self.aligned(self.nodes[k], &own));
            [own, right - own, up - own, across - up - (right - own)]
        };
        self.between = Arc::new(parallel::map(side * side, CHUNK, between));
        self.fit = DVec2::ONE;
        let domain = self.sizing.domain();
        let size = domain.size();
        let count = |along: DVec2, length: f64| -> f64 {
            let step = length / TUNING.side_samples as f64;
            (0..TUNING.side_samples)
                .map(|k| {
                    let q = domain.min + along * (step * (k as f64 + 0.5));
                    (self.at(q).inverse() * along * step).length()
                })
                .sum()
        };
        let (x, y) = (count(DVec2::X, size.x), count(DVec2::Y, size.y));
        // A number that has been fitted already is not to grow by one for its rounding.
        let whole = |x: f64| (x - FITTED).ceil().max(1.0);
        self.fit = DVec2::new(x / whole(x), y / whole(y));
    }
}

/// Half-sizes of the box around the image of the unit circle under a cell, mm.
pub(crate) fn cell_extent(cell: &DMat2) -> DVec2 {
    let (a, b) = (cell.x_axis, cell.y_axis);
    DVec2::new(DVec2::new(a.x, b.x).length(), DVec2::new(a.y, b.y).length())
}
