//! The stages of a build as methods of the values that they start from, each in memory.

use super::Error;
use super::mesh_files::label;
use super::source::{SourceError, load};
use crate::design::{Design, DesignError, design};
use crate::export::Label;
use crate::mesh::Face;
use crate::part::{closed, codec, face};
use crate::profile::{MeshFormat, Profile};
use crate::solid::{Solid, SolidError};
use std::io::{self, Write};

impl Profile {
    /// The profile that `named` means: a file if there is one, else a shipped profile; with the files that it
    /// names, from its own folder.
    ///
    /// ```
    /// let profile = morion::Profile::load("conformal")?;
    /// assert_eq!(profile.camera.pixels(), [640, 480]);
    /// # Ok::<(), morion::SourceError>(())
    /// ```
    ///
    /// # Errors
    /// [`SourceError`], with every complaint about the file.
    pub fn load(named: &str) -> Result<Self, SourceError> {
        load(named)
    }

    /// The smooth mirror that the profile asks for, or gives.
    ///
    /// ```
    /// // With the mercator law a mirror can be exact.
    /// let design = morion::Profile::load("conformal")?.design()?;
    /// assert!(design.facts.ray_error_mrad.unwrap().max < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError`] when the problem has no answer in finite numbers, or a given mirror cannot be
    /// represented or does not cover its outline.
    pub fn design(&self) -> Result<Design, DesignError> {
        design(self)
    }
}

impl Design {
    /// The optical face within the profile's limits, or of its number of triangles, with bounds that hold
    /// over the whole of every facet.
    ///
    /// It promises nothing about the number of triangles, but see [`Face::optimum`].
    ///
    /// ```
    /// # let profile = morion::Profile::parse("part", "part.toml", include_bytes!("../../examples/small.toml"))?;
    /// let design = profile.design()?;
    /// let face = design.mesh()?;
    /// assert!(face.bound.facet_mm <= design.camera.pixel_mm);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`enum@Error`] when the limits ask for more than memory or digits allow, or none can be kept.
    pub fn mesh(&self) -> Result<Face, Error> {
        match face(&self.profile, self) {
            Ok(found) => Ok(found.made),
            Err(error) => Err(Error::face(&self.profile, error)),
        }
    }

    /// The words of a file of `face` on its mirror: the profile and its hash, tolerances asked and reached,
    /// and where camera and target are.
    #[must_use]
    pub fn label(&self, face: &Face) -> Label {
        label(self, Some(&face.bound))
    }
}

impl Face {
    /// The closed part with this face: skirt and base, and the border that `design` has around its mirror, to
    /// the digits of the profile's coarsest file format; or the tool that is made in the part's place.
    ///
    /// ```
    /// # let profile = morion::Profile::parse("part", "part.toml", include_bytes!("../../examples/small.toml"))?;
    /// let design = profile.design()?;
    /// let solid = design.mesh()?.close(&design)?;
    /// assert!(solid.check().closed && solid.check().volume_mm3 < design.volume() + 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SolidError`] when the check finds a fault of the body.
    pub fn close(&self, design: &Design) -> Result<Solid, SolidError> {
        closed(design, &self.mesh, self.precision)
    }
}

impl Solid {
    /// Writes the part.
    ///
    /// ```
    /// use morion::MeshFormat;
    /// # let profile = morion::Profile::parse("part", "part.toml", include_bytes!("../../examples/small.toml"))?;
    /// let design = profile.design()?;
    /// let face = design.mesh()?;
    /// let mut stl = Vec::new();
    /// face.close(&design)?.write(MeshFormat::Stl, &design.label(&face), &mut stl)?;
    /// assert!(stl.starts_with(b"Morion"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// That of `out`.
    pub fn write(&self, format: MeshFormat, label: &Label, out: &mut dyn Write) -> io::Result<()> {
        codec(format).write(out, self, None, label)
    }
}
