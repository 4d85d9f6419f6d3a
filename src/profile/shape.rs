//! The mirror's shape: designed by a method, or given.

/// Source of the mirror's shape.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeSpec {
    /// Computed from the projection.
    Designed(Method),
    /// Given by a formula.
    Polynomial(Polynomial),
    /// Given as heights on a grid.
    Grid {
        /// The file that holds them, as written in the profile: not empty, relative to the
        /// profile's folder, not opened yet.
        file: String,
    },
}

/// Method by which a mirror's shape is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    /// The residual that is made small.
    pub kind: MethodKind,
    /// Degree of the polynomial in each image coordinate, 1 to 40.
    pub degree: usize,
    /// Make the largest error small instead of the mean square.
    pub minimax: bool,
}

/// Residual that a method makes small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodKind {
    /// The difference between the mirror's gradient and the wanted slope field.
    VectorField,
    /// The pixel error.
    FixedSurface,
    /// The angle between the mirror's normal and the wanted one.
    Distribution,
}

impl MethodKind {
    /// The method's name in a profile.
    pub fn name(self) -> &'static str {
        match self {
            MethodKind::VectorField => "vector-field",
            MethodKind::FixedSurface => "fixed-surface",
            MethodKind::Distribution => "distribution",
        }
    }
}

/// A mirror given by a formula: a conic of revolution about the axis plus a polynomial. At least
/// one of the two is there. Height, X and Y are in millimetres, height grows towards the camera;
/// a constant height has no effect, for the part's base is under the lowest point.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    /// The conic; it exists over the whole outline.
    pub conic: Option<Conic>,
    /// The polynomial's terms, each pair of exponents once.
    pub terms: Vec<Monomial>,
}

/// A conic of revolution: at `r` from the axis it is `r^2 / (R (1 + sqrt(1 - (1 + k) r^2 / R^2)))`
/// high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conic {
    /// `R`, the radius of curvature at the vertex in millimetres, not 0; negative for a dome, which
    /// is convex towards the camera.
    pub radius_mm: f64,
    /// `k`: 0 for a sphere, -1 for a paraboloid, less for a hyperboloid.
    pub conic: f64,
}

/// The term `c X^i Y^j` of a polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monomial {
    /// Exponent of X; `i + j` is at most 40.
    pub i: usize,
    /// Exponent of Y.
    pub j: usize,
    /// Coefficient, in powers of a millimetre.
    pub c: f64,
}
