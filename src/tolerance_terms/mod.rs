//! Terms of tolerancing that a profile and the trials share: the table of error sources and the words of
//! a profile's `[tolerance]`.

mod distribution;
mod error_sources;
mod misalignment;
mod words;

pub use distribution::Distribution;
pub use error_sources::{
    ActsOn, AppliesTo, ErrorSourceRow, FormTerm, LimitUnit, Perturbation, Texture, UsualLimit,
};
pub use misalignment::{Misalignment, MisalignmentField};
pub use words::{Compensator, Criterion, FormMeasure, MadeFrom, ProcessPreset, Reference};

/// An enum each of whose variants has a word in profiles and reports: `WORDS` has all, in the order of
/// complaints.
macro_rules! words_enum {
    (
        $(#[$doc:meta])* pub enum $name:ident {
            $($(#[$variant_doc:meta])* $variant:ident = $word:literal,)+
        }
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $($(#[$variant_doc])* $variant,)+
        }

        impl $name {
            /// Each word with its meaning, in the order in which complaints list them.
            pub const WORDS: &'static [(&'static str, Self)] = &[$(($word, Self::$variant)),+];

            /// Its word in profiles and reports.
            #[must_use]
            pub fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        #[cfg(test)]
        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                let words: Vec<&str> = Self::WORDS.iter().map(|(word, _)| *word).collect();
                schemars::json_schema!({ "type": "string", "enum": words })
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
                out.serialize_str(self.word())
            }
        }
    };
}
use words_enum;
