//! Entity instances by their numbers, with their attributes as the type that is asked for.

use super::StepError;
use super::part21::{Exchange, Parameter, Record};
use crate::geom::DVec3;
use glam::DMat3;

/// The entity instances of a file.
pub(super) struct Entities {
    exchange: Exchange,
    /// Millimetres of the file's unit of length.
    pub mm: f64,
    /// Radians of the file's unit of plane angle.
    pub radians: f64,
    /// Where the body is put.
    motion: RigidMotion,
}

/// A motion of a body: a turn, and then a shift, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidMotion {
    /// A rotation.
    pub rotation: DMat3,
    /// mm.
    pub shift: DVec3,
}

impl RigidMotion {
    /// No motion at all.
    pub const NONE: Self = Self { rotation: DMat3::IDENTITY, shift: DVec3::ZERO };
}

/// One record of an instance: its attributes are asked for by their places.
#[derive(Clone, Copy)]
pub(super) struct Entity<'a> {
    pub id: u64,
    line: usize,
    record: &'a Record,
}

impl Entities {
    pub(super) fn new(exchange: Exchange, motion: RigidMotion) -> Self {
        Self { exchange, mm: 1.0, radians: 1.0, motion }
    }

    /// All records of this name.
    pub(super) fn named<'a>(&'a self, keyword: &'a str) -> impl Iterator<Item = Entity<'a>> {
        self.exchange.instances.iter().flat_map(move |(&id, instance)| {
            let records = instance.records.iter().filter(move |record| record.keyword == keyword);
            records.map(move |record| Entity { id, line: instance.line, record })
        })
    }

    /// The records of an instance.
    ///
    /// # Errors
    /// [`StepError`] where `from` names one that is not there.
    pub(super) fn records(&self, from: Entity, id: u64) -> Result<Vec<Entity<'_>>, StepError> {
        let instance = self.exchange.instances.get(&id);
        let instance =
            instance.ok_or_else(|| from.fault(format!("it names #{id}, which is not there")))?;
        let entity = |record| Entity { id, line: instance.line, record };
        Ok(instance.records.iter().map(entity).collect())
    }

    /// The instance that the attribute `at` of `from` names: its record, the first of a complex one.
    pub(super) fn follow(&self, from: Entity, at: usize) -> Result<Entity<'_>, StepError> {
        self.entity(from, from.reference(at)?)
    }

    pub(super) fn entity(&self, from: Entity, id: u64) -> Result<Entity<'_>, StepError> {
        let records = self.records(from, id)?;
        records.first().copied().ok_or_else(|| from.fault(format!("#{id} is empty")))
    }

    /// The record of a complex or simple instance with this name.
    pub(super) fn part(
        &self,
        from: Entity,
        id: u64,
        keyword: &str,
    ) -> Result<Option<Entity<'_>>, StepError> {
        Ok(self.records(from, id)?.into_iter().find(|entity| entity.keyword() == keyword))
    }

    /// The instance that an attribute names, which must be of this kind.
    pub(super) fn follow_as(
        &self,
        from: Entity,
        at: usize,
        keyword: &str,
    ) -> Result<Entity<'_>, StepError> {
        self.follow(from, at)?.named(keyword)
    }

    /// The point that `id` names where the body is put, mm.
    pub(super) fn point(&self, from: Entity, id: u64) -> Result<DVec3, StepError> {
        let point = self.entity(from, id)?.named("CARTESIAN_POINT")?;
        Ok(self.turned(point.triple(1)? * self.mm) + self.motion.shift)
    }

    /// A vector of the file as it stands where the body is put.
    pub(super) fn turned(&self, along: DVec3) -> DVec3 {
        if self.motion == RigidMotion::NONE { along } else { self.motion.rotation * along }
    }

    /// The unit vector of a direction that an attribute names.
    pub(super) fn direction(&self, from: Entity, at: usize) -> Result<DVec3, StepError> {
        let direction = self.follow_as(from, at, "DIRECTION")?;
        let along = direction.triple(1)?.try_normalize().map(|along| self.turned(along));
        along.ok_or_else(|| direction.fault("a direction without length"))
    }
}

impl<'a> Entity<'a> {
    pub(super) fn keyword(&self) -> &'a str {
        &self.record.keyword
    }

    /// A fault of this instance.
    pub(super) fn fault(&self, fault: impl Into<String>) -> StepError {
        let fault = format!("{}: {}", self.keyword(), fault.into());
        StepError { line: self.line, entity: Some(self.id), fault }
    }

    /// That this kind of instance is not read.
    pub(super) fn refused(&self, of: &str) -> StepError {
        let fault = format!("{} is no {of} that is read", self.keyword());
        StepError { line: self.line, entity: Some(self.id), fault }
    }

    fn named(self, keyword: &str) -> Result<Self, StepError> {
        if self.keyword() == keyword {
            return Ok(self);
        }
        Err(self.fault(format!("{keyword} must stand here")))
    }

    fn attribute(&self, at: usize) -> Result<&'a Parameter, StepError> {
        let found = self.record.parameters.get(at);
        found.ok_or_else(|| self.fault(format!("attribute {} is missing", at + 1)))
    }

    fn wrong(&self, at: usize, wanted: &str) -> StepError {
        self.fault(format!("attribute {} must be {wanted}", at + 1))
    }

    pub(super) fn reference(&self, at: usize) -> Result<u64, StepError> {
        match self.attribute(at)? {
            Parameter::Reference(id) => Ok(*id),
            _ => Err(self.wrong(at, "the number of an instance")),
        }
    }

    pub(super) fn is_absent(&self, at: usize) -> bool {
        matches!(self.attribute(at), Ok(Parameter::Absent) | Err(_))
    }

    pub(super) fn number(&self, at: usize) -> Result<f64, StepError> {
        match self.attribute(at)? {
            Parameter::Number(x) => Ok(*x),
            // A measure with its type.
            Parameter::Typed(_, inner) if inner.len() == 1 => match inner[0] {
                Parameter::Number(x) => Ok(x),
                _ => Err(self.wrong(at, "a number")),
            },
            _ => Err(self.wrong(at, "a number")),
        }
    }

    pub(super) fn flag(&self, at: usize) -> Result<bool, StepError> {
        match self.attribute(at)? {
            Parameter::Enumeration(word) if word == "T" => Ok(true),
            Parameter::Enumeration(word) if word == "F" => Ok(false),
            _ => Err(self.wrong(at, ".T. or .F.")),
        }
    }

    pub(super) fn enumeration(&self, at: usize) -> Option<&'a str> {
        match self.attribute(at) {
            Ok(Parameter::Enumeration(word)) => Some(word),
            _ => None,
        }
    }

    fn list(&self, at: usize) -> Result<&'a [Parameter], StepError> {
        match self.attribute(at)? {
            Parameter::List(list) => Ok(list),
            _ => Err(self.wrong(at, "a list")),
        }
    }

    pub(super) fn references(&self, at: usize) -> Result<Vec<u64>, StepError> {
        self.references_of(at, self.list(at)?)
    }

    fn references_of(&self, at: usize, list: &[Parameter]) -> Result<Vec<u64>, StepError> {
        let reference = |parameter: &Parameter| match parameter {
            Parameter::Reference(id) => Ok(*id),
            _ => Err(self.wrong(at, "a list of instances' numbers")),
        };
        list.iter().map(reference).collect()
    }

    /// A list of lists of instances' numbers.
    pub(super) fn reference_rows(&self, at: usize) -> Result<Vec<Vec<u64>>, StepError> {
        let row = |row: &Parameter| match row {
            Parameter::List(row) => self.references_of(at, row),
            _ => Err(self.wrong(at, "a list of lists")),
        };
        self.list(at)?.iter().map(row).collect()
    }

    pub(super) fn numbers(&self, at: usize) -> Result<Vec<f64>, StepError> {
        self.numbers_of(at, self.list(at)?)
    }

    fn numbers_of(&self, at: usize, list: &[Parameter]) -> Result<Vec<f64>, StepError> {
        let number = |parameter: &Parameter| match parameter {
            Parameter::Number(x) => Ok(*x),
            _ => Err(self.wrong(at, "a list of numbers")),
        };
        list.iter().map(number).collect()
    }

    /// A list of lists of numbers.
    pub(super) fn number_rows(&self, at: usize) -> Result<Vec<Vec<f64>>, StepError> {
        let row = |row: &Parameter| match row {
            Parameter::List(row) => self.numbers_of(at, row),
            _ => Err(self.wrong(at, "a list of lists")),
        };
        self.list(at)?.iter().map(row).collect()
    }

    fn triple(&self, at: usize) -> Result<DVec3, StepError> {
        match self.numbers(at)?[..] {
            [x, y, z] => Ok(DVec3::new(x, y, z)),
            _ => Err(self.wrong(at, "three coordinates")),
        }
    }

    /// A length that must be more than 0, in the file's unit.
    pub(super) fn positive(&self, at: usize) -> Result<f64, StepError> {
        let x = self.number(at)?;
        if !(x > 0.0) { Err(self.wrong(at, "more than 0")) } else { Ok(x) }
    }
}
