//! The methods by name, each said once: a new one is its file, its `mod` and its line here.

use super::method::Method;
use super::region::Region;
use crate::options::{Choice, Field, Kind, OptionSet, Spec, Value};
use crate::{Error, Fault, Job, Result};

/// `module: Variant, "one line"`: the module has `Options` and `bind`, and its name is the method's.
macro_rules! methods {
    ($($module:ident: $variant:ident, $help:literal;)+) => {
        use super::{$($module),+};

        /// The methods, as in `lissom.POSE_METHODS`.
        pub const METHODS: &[Choice] = &[$(Choice { value: stringify!($module), help: $help }),+];

        /// A method and its options; one of [`METHODS`] each.
        #[derive(Debug, Clone)]
        pub enum MethodOptions {
            $(#[doc = concat!("[`super::", stringify!($module), "`]")] $variant($module::Options),)+
        }

        impl MethodOptions {
            /// A method with its defaults; `None` where there is none of that name.
            fn by_name(name: &str) -> Option<Self> {
                $(if name == stringify!($module) {
                    return Some(Self::$variant($module::Options::default()));
                })+
                None
            }

            /// Its name.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => stringify!($module)),+ }
            }

            fn options(&self) -> &dyn OptionSet {
                match self { $(Self::$variant(options) => options),+ }
            }

            fn options_mut(&mut self) -> &mut dyn OptionSet {
                match self { $(Self::$variant(options) => options),+ }
            }

            /// Checks the options and binds the method to a region.
            pub(super) fn bind(&self, region: &Region, job: &Job) -> Result<Box<dyn Method>> {
                self.check()?;
                match self { $(Self::$variant(options) => $module::bind(region, options, job)),+ }
            }
        }
    };
}

methods! {
    laplacian: Laplacian, "Keeps the details' vectors; fast, for small motions without turns";
    laplacian_fitted: LaplacianFitted, "Turns and scales the details to fit; for medium turns";
    rotation_invariant: RotationInvariant, "Spreads the handles' turns over the mesh, also full turns";
    thin_shell: ThinShell, "Stretches and bends like a thin sheet; smooth, for small motions";
    poisson: Poisson, "Blends the handles' transforms by smooth weights; fast";
    multiresolution: Multiresolution, "Poses a smooth base, then puts the details back on it";
    arap: Arap, "Keeps every small piece of the mesh rigid; for large turns and bends";
    laplacian_rotated: LaplacianRotated, "Turns the details as a first pose without turns says; fast, for medium turns";
}

impl Default for MethodOptions {
    fn default() -> Self {
        Self::Arap(arap::Options::default())
    }
}

impl MethodOptions {
    /// The method of a name, with its defaults.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for a name that there is not.
    pub fn named(name: &str) -> Result<Self> {
        Self::by_name(name).ok_or_else(|| Error::InvalidValue(Fault::new("method", no_method(name))))
    }

    /// Whether closed parts are posed as solids.
    pub(super) fn is_solid(&self) -> bool {
        let solid =
            |(spec, value): (Spec, _)| spec.name == "solid" && matches!(value, Some(Value::Bool(true)));
        self.specs().into_iter().zip(self.values()).any(solid)
    }

    /// The choice among the methods, as an option.
    pub fn spec() -> Spec {
        let (help, default) = ("How the mesh follows its handles", Self::default().name());
        Spec {
            default: Some(Value::Choice(default.to_owned())),
            choices: METHODS.to_vec(),
            ..Spec::of("method", help, &Box::<Self>::default())
        }
    }
}

/// Why a name is no method, or none that poses a base.
pub(super) fn no_method(name: &str) -> String {
    match MethodOptions::by_name(name) {
        Some(_) => "must be another method".to_owned(),
        None => {
            let known: Vec<_> = METHODS.iter().map(|method| method.value).collect();
            format!("no method named '{name}', there are {}", known.join(", "))
        }
    }
}

impl OptionSet for MethodOptions {
    fn own(&self) -> Vec<Spec> {
        self.options().own()
    }

    fn specs(&self) -> Vec<Spec> {
        self.options().specs()
    }

    fn values(&self) -> Vec<Option<Value>> {
        self.options().values()
    }

    fn put(&mut self, name: &str, value: Value) -> bool {
        self.options_mut().put(name, value)
    }
}

/// A method that another one uses.
impl Field for Box<MethodOptions> {
    const KIND: Kind = Kind::Choice;

    fn choices() -> Vec<Choice> {
        let simple = |choice: &&Choice| {
            !matches!(MethodOptions::by_name(choice.value), Some(MethodOptions::Multiresolution(_)))
        };
        METHODS.iter().filter(simple).copied().collect()
    }

    fn value(&self) -> Option<Value> {
        Some(Value::Choice(self.name().to_owned()))
    }

    fn of(value: Value) -> Option<Self> {
        let Value::Choice(name) = value else { return None };
        MethodOptions::by_name(&name).map(Box::new)
    }
}
