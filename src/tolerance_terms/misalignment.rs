//! Numbers that say how mirror and camera are placed.

/// The list of the numbers: of each its variant of [`MisalignmentField`] and its field of
/// [`Misalignment`].
macro_rules! misalignment {
    ($($(#[$doc:meta])* $variant:ident: $field:ident,)+) => {
        /// One of the numbers of a [`Misalignment`], in their order.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum MisalignmentField {
            $($(#[$doc])* $variant,)+
        }

        impl MisalignmentField {
            /// All, in their order.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];
            /// How many there are.
            pub const COUNT: usize = Self::ALL.len();
        }

        /// Departure of mirror and camera from where and what they are as designed; zero where they are. The
        /// part is grown about the part frame's origin (the middle of its base), turned about X, then Y, then
        /// the axis, and shifted. Camera errors act on the ray of an image point.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct Misalignment<S> {
            $($(#[$doc])* pub $field: S,)+
        }

        impl<S: Copy> Misalignment<S> {
            /// From a value for each field.
            pub fn from_fn(mut value: impl FnMut(MisalignmentField) -> S) -> Self {
                Self { $($field: value(MisalignmentField::$variant),)+ }
            }

            /// The values in the order of [`MisalignmentField::ALL`].
            pub fn values(&self) -> [S; MisalignmentField::COUNT] {
                [$(self.$field),+]
            }

            /// The value of one field.
            pub fn value_mut(&mut self, field: MisalignmentField) -> &mut S {
                match field {
                    $(MisalignmentField::$variant => &mut self.$field,)+
                }
            }
        }
    };
}

misalignment! {
    /// Shift of the part along X, mm.
    ShiftX: shift_x_mm,
    /// Shift of the part along Y, mm.
    ShiftY: shift_y_mm,
    /// Shift of the part towards the camera, mm.
    ShiftZ: shift_z_mm,
    /// Rotation of the part about X, rad.
    TiltX: tilt_x_rad,
    /// Rotation of the part about Y, rad.
    TiltY: tilt_y_rad,
    /// Rotation of the part about the axis, rad.
    Clocking: clocking_rad,
    /// Growth of the part, as a share of its size.
    Growth: growth,
    /// Growth of the picture, as a share of its size.
    Magnification: magnification,
    /// Angle at half the frame's width by which a telecentric camera's chief rays lean outwards, rad.
    Telecentricity: telecentricity_rad,
    /// Shift of the principal point along X, mm on the reference plane.
    PrincipalX: principal_x_mm,
    /// Shift of the principal point along Y, mm on the reference plane.
    PrincipalY: principal_y_mm,
    /// Third-order radial distortion, as a share of the radius at half the frame's width.
    Distortion: distortion,
    /// Third-order coma of the lens along X, as a share of the radius at half the frame's width.
    Coma: coma,
}
