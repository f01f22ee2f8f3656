//! Options, each said once: name, kind, default, range, unit and a line of help.
//!
//! [`options!`] makes a struct of them, its default, its checks and its [`Spec`]s, from which the binding, the
//! stub and the manual are made; [`choices!`] makes the enums that some of them are. A field's comment is its help.

use std::sync::Arc;

use crate::mesh::Plane;
use crate::{Error, Fault, Mesh, Result, Vec3};

/// What an option takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Yes or no.
    Bool,
    /// A whole number.
    Int,
    /// A number.
    Float,
    /// One of a few names.
    Choice,
    /// Vertex indices.
    Vertices,
    /// Positions.
    Points,
    /// Pairs of paths along edges.
    Curves,
    /// A mesh.
    Mesh,
    /// Shapes of a mesh, each at a time.
    Shapes,
    /// Planes, each by a point and a normal.
    Planes,
    /// Offsets of the vertices of a mesh, many times.
    Modes,
}

impl Kind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Int => "int",
            Self::Float => "float",
            Self::Choice => "choice",
            Self::Vertices => "vertices",
            Self::Points => "points",
            Self::Curves => "curves",
            Self::Mesh => "mesh",
            Self::Shapes => "shapes",
            Self::Planes => "planes",
            Self::Modes => "modes",
        }
    }
}

/// What an option is given; one of [`Kind`] each.
#[derive(Debug, Clone)]
pub enum Value {
    /// [`Kind::Bool`]
    Bool(bool),
    /// [`Kind::Int`]
    Int(i64),
    /// [`Kind::Float`]
    Float(f64),
    /// [`Kind::Choice`]
    Choice(String),
    /// [`Kind::Vertices`]
    Vertices(Vec<u32>),
    /// [`Kind::Points`]
    Points(Vec<Vec3>),
    /// [`Kind::Curves`]
    Curves(Vec<[Vec<u32>; 2]>),
    /// [`Kind::Mesh`]
    Mesh(Arc<Mesh>),
    /// [`Kind::Shapes`]
    Shapes(Vec<(f64, Vec<Vec3>)>),
    /// [`Kind::Planes`]
    Planes(Vec<Plane>),
    /// [`Kind::Modes`]
    Modes(Vec<Vec<Vec3>>),
}

/// A name that an option may be given, and what it means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// The name.
    pub value: &'static str,
    /// One line.
    pub help: &'static str,
}

/// Everything there is to say about an option.
#[derive(Debug, Clone)]
pub struct Spec {
    /// Its name, in Rust and in Python.
    pub name: &'static str,
    /// What it takes.
    pub kind: Kind,
    /// What it is where it is not given; `None` for nothing.
    pub default: Option<Value>,
    /// What a choice may be.
    pub choices: Vec<Choice>,
    /// The least number, where there is one.
    pub low: Option<f64>,
    /// The largest number, where there is one; only where it is infinite, infinite numbers are taken.
    pub high: Option<f64>,
    /// Whether the least number itself is refused.
    pub low_open: bool,
    /// Whether the largest number itself is refused.
    pub high_open: bool,
    /// What its number counts or is a fraction of; empty for plain numbers.
    pub unit: &'static str,
    /// One line.
    pub help: &'static str,
    /// The option without which, at this choice, it does nothing.
    pub when: Option<(&'static str, &'static str)>,
    /// What is wrong with a name that is none of the choices, where that needs words of its own.
    pub otherwise: Option<fn(&str) -> String>,
}

impl Spec {
    /// An option by its name, its help and its default.
    pub fn of<T: Field>(name: &'static str, help: &'static str, default: &T) -> Self {
        Self {
            name,
            kind: T::KIND,
            default: default.value(),
            choices: T::choices(),
            low: T::LOW,
            high: None,
            low_open: false,
            high_open: false,
            unit: "",
            help: line(help),
            when: None,
            otherwise: None,
        }
    }

    /// Not below `low`.
    pub fn at_least(self, low: f64) -> Self {
        Self { low: Some(low), ..self }
    }

    /// Not above `high`.
    pub fn at_most(self, high: f64) -> Self {
        Self { high: Some(high), ..self }
    }

    /// Above `low`.
    pub fn above(self, low: f64) -> Self {
        Self { low: Some(low), low_open: true, ..self }
    }

    /// Below `high`.
    pub fn below(self, high: f64) -> Self {
        Self { high: Some(high), high_open: true, ..self }
    }

    /// In this unit.
    pub fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Of use only where the option `name` is `value`.
    pub fn when(self, name: &'static str, value: &'static str) -> Self {
        Self { when: Some((name, value)), ..self }
    }

    /// What is wrong with names that are no choice.
    pub fn otherwise(self, problem: fn(&str) -> String) -> Self {
        Self { otherwise: Some(problem), ..self }
    }

    /// Refuses a value out of range.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`], which names the option.
    pub fn check(&self, value: &Value) -> Result<()> {
        let problem = match value {
            Value::Int(value) if !self.holds(*value as f64) => self.range(*value < 0, value),
            Value::Float(value) if !self.holds(*value) => {
                self.range(!(*value > 0.0 && value.is_finite()), value)
            }
            Value::Choice(name) if self.choices.iter().all(|choice| choice.value != name) => {
                match self.otherwise {
                    Some(problem) => problem(name),
                    None => format!("'{name}' is none of {}", self.names().join(", ")),
                }
            }
            _ => return Ok(()),
        };
        Err(Error::InvalidValue(Fault::new(self.name, problem)))
    }

    fn holds(&self, value: f64) -> bool {
        let low = self.low.unwrap_or(f64::NEG_INFINITY);
        let high = self.high.unwrap_or(f64::INFINITY);
        let above = if self.low_open { value > low } else { value >= low };
        let below = if self.high_open { value < high } else { value <= high };
        above && below && (value.is_finite() || self.high == Some(value))
    }

    /// The range in words; `wild` numbers are far out of it.
    fn range(&self, wild: bool, given: &dyn std::fmt::Display) -> String {
        let whole = self.kind == Kind::Int;
        let range = match (self.low, self.high) {
            (Some(0.0..), _) if whole && wild => "not be negative".to_owned(),
            (Some(low), Some(high)) if whole && high - low == 2.0 => {
                format!("be {low}, {} or {high}", low + 1.0)
            }
            (Some(0.0), _) if self.low_open => "be a positive number".to_owned(),
            (Some(low), Some(high)) => {
                let [above, below] = [(self.low_open, "above "), (self.high_open, "below ")].map(word);
                format!("be from {above}{low} to {below}{high}")
            }
            (Some(0.0), None) => "be 0 or more".to_owned(),
            (Some(0.0..), None) if wild => "be a positive number".to_owned(),
            (Some(low), None) => format!("be {} {low}", if self.low_open { "above" } else { "at least" }),
            (None, Some(high)) => format!("be {} {high}", if self.high_open { "below" } else { "at most" }),
            (None, None) => "be a finite number".to_owned(),
        };
        format!("must {range}, got {given}")
    }

    /// The choices, the default first.
    fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<_> = self.choices.iter().map(|choice| choice.value).collect();
        names.sort_by_key(|name| !matches!(&self.default, Some(Value::Choice(default)) if default == name));
        names
    }
}

fn word((said, word): (bool, &'static str)) -> &'static str {
    if said { word } else { "" }
}

/// The text of a comment as a line of help.
pub const fn line(comment: &'static str) -> &'static str {
    let comment = comment.trim_ascii();
    match comment.as_bytes() {
        [.., b'.'] => comment.split_at(comment.len() - 1).0,
        _ => comment,
    }
}

/// A type that options may have.
pub trait Field: Sized {
    /// What it takes.
    const KIND: Kind;
    /// The least number of the type.
    const LOW: Option<f64> = None;
    /// What it may be, of choices.
    fn choices() -> Vec<Choice> {
        Vec::new()
    }
    /// As a value; `None` where it is large.
    fn value(&self) -> Option<Value> {
        None
    }
    /// From a value; `None` where it is of another kind.
    fn of(value: Value) -> Option<Self>;
}

/// A type whose values are those of one kind.
macro_rules! field {
    ($type:ty, $kind:ident, $name:pat => $of:expr, $($rest:tt)*) => {
        impl Field for $type {
            const KIND: Kind = Kind::$kind;
            $($rest)*
            fn of(value: Value) -> Option<Self> {
                if let Value::$kind($name) = value { $of } else { None }
            }
        }
    };
}

field!(bool, Bool, given => Some(given), fn value(&self) -> Option<Value> { Some(Value::Bool(*self)) });
field!(f64, Float, given => Some(given), fn value(&self) -> Option<Value> { Some(Value::Float(*self)) });
field!(usize, Int, given => usize::try_from(given).ok(),
    const LOW: Option<f64> = Some(0.0);
    fn value(&self) -> Option<Value> { i64::try_from(*self).ok().map(Value::Int) }
);
field!(Vec<u32>, Vertices, given => Some(given),);
field!(Vec<Vec3>, Points, given => Some(given),);
field!(Option<Vec<Vec3>>, Points, given => Some(Some(given)),);
field!(Vec<[Vec<u32>; 2]>, Curves, given => Some(given),);
field!(Option<Arc<Mesh>>, Mesh, given => Some(Some(given)),);
field!(Vec<(f64, Vec<Vec3>)>, Shapes, given => Some(given),);
field!(Vec<Plane>, Planes, given => Some(given),);
field!(Vec<Vec<Vec3>>, Modes, given => Some(given),);

/// Options that can be told and asked by name.
pub trait OptionSet {
    /// Its own, in order.
    fn own(&self) -> Vec<Spec>;

    /// All of them, in order: its own, and those that it lends.
    fn specs(&self) -> Vec<Spec> {
        self.own()
    }

    /// What they are, in the same order; `None` where that is large.
    fn values(&self) -> Vec<Option<Value>>;

    /// Takes `value` as it is; whether there is an option of that name and kind. See [`OptionSet::set`].
    fn put(&mut self, name: &str, value: Value) -> bool;

    /// Sets one.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for a value out of range or of another kind, and for a name that there is not.
    fn set(&mut self, name: &str, value: Value) -> Result<()> {
        if let Some(spec) = self.specs().iter().find(|spec| spec.name == name) {
            spec.check(&value)?;
        }
        match self.put(name, value) {
            true => Ok(()),
            false => Err(Error::InvalidValue(Fault::new(name, "there is no option of that name and kind"))),
        }
    }

    /// Refuses what is out of range.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`], which names the first offender.
    fn check(&self) -> Result<()> {
        let values = self.values().into_iter();
        self.specs().iter().zip(values).filter_map(|(s, v)| Some((s, v?))).try_for_each(|(s, v)| s.check(&v))
    }
}

/// A struct of options: `/// help`, `pub name: Type = default`, and after `=>` its range, unit and need, as the
/// methods of [`Spec`] say them. `..field` at the end lends it the options of that field.
macro_rules! options {
    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $($(#[doc = $help:literal])+
            pub $field:ident: $type:ty = $default:expr $(=> $($rule:ident($($arg:expr),*))+)?,)*
            $(..$rest:ident)?
        }
    ) => {
        $(#[$meta])*
        pub struct $name {
            $($(#[doc = $help])+ pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),* }
            }
        }

        impl $crate::options::OptionSet for $name {
            fn own(&self) -> Vec<$crate::options::Spec> {
                let default = Self::default();
                vec![$(
                    $crate::options::Spec::of(stringify!($field), concat!($($help),+), &default.$field)
                        $($(.$rule($($arg),*))+)?
                ),*]
            }

            $(fn specs(&self) -> Vec<$crate::options::Spec> {
                let lent = $crate::options::OptionSet::specs(&*self.$rest);
                self.own().into_iter().chain(lent).collect()
            })?

            fn values(&self) -> Vec<Option<$crate::options::Value>> {
                let own = [$($crate::options::Field::value(&self.$field)),*];
                own.into_iter()$(.chain($crate::options::OptionSet::values(&*self.$rest)))?.collect()
            }

            fn put(&mut self, name: &str, value: $crate::options::Value) -> bool {
                $(if name == stringify!($field) {
                    return $crate::options::Field::of(value).map(|value| self.$field = value).is_some();
                })*
                $(return $crate::options::OptionSet::put(&mut *self.$rest, name, value);)?
                #[allow(unreachable_code, reason = "reached where no other field lends its options")]
                false
            }
        }
    };
}
pub(crate) use options;

/// An enum of choices: `/// help`, `Variant = "name"`.
macro_rules! choices {
    (
        $(#[$meta:meta])*
        pub enum $name:ident {
            $($(#[doc = $help:literal])+ $variant:ident = $value:literal,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $($(#[doc = $help])+ $variant,)+
        }

        impl $crate::options::Field for $name {
            const KIND: $crate::options::Kind = $crate::options::Kind::Choice;

            fn choices() -> Vec<$crate::options::Choice> {
                use $crate::options::{Choice, line};
                vec![$(Choice { value: $value, help: line(concat!($($help),+)) }),+]
            }

            fn value(&self) -> Option<$crate::options::Value> {
                let name = match self { $(Self::$variant => $value),+ };
                Some($crate::options::Value::Choice(name.to_owned()))
            }

            fn of(value: $crate::options::Value) -> Option<Self> {
                let $crate::options::Value::Choice(name) = value else { return None };
                match name.as_str() { $($value => Some(Self::$variant),)+ _ => None }
            }
        }
    };
}
pub(crate) use choices;
