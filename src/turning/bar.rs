//! The bar that a part is turned of.

/// A bar of which a part is turned: a cylinder about the axis on the plane Z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Its radius, mm.
    pub radius_mm: f64,
    /// Z of its top, mm.
    pub top_mm: f64,
}
