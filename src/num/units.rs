//! Lengths by their unit, where one is turned into another.

/// A length in the image, pixels.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Px(pub f64);

/// A length, mm.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Mm(pub f64);

/// A length, um.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Um(pub f64);

impl From<Um> for Mm {
    fn from(um: Um) -> Self {
        Self(um.0 * 1e-3)
    }
}

impl From<Mm> for Um {
    fn from(mm: Mm) -> Self {
        Self(mm.0 * 1e3)
    }
}
