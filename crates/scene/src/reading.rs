//! Readings of sensors as plain data: numbers in SI units, without names and text.
//!
//! Each sensor's file has its reading. The list of all is [`crate::sensor::Reading`]. Lines of the wire, logs, ROS 2 and the page are made
//! of readings.

use std::sync::Arc;

use serde::Serialize;

/// One quantity of a reading by its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// Its name, for example `ranges`.
    pub name: &'static str,
    /// Its unit, for example `m`; empty for numbers without one.
    pub unit: &'static str,
    /// Its numbers.
    pub values: Vec<f64>,
}

/// The type of a quantity.
pub(crate) trait Numbers: Sized {
    /// Returns its numbers.
    fn numbers(&self) -> Vec<f64>;
    /// Restores it from its numbers. `None` if there are too many or too few.
    fn read(numbers: &[f64]) -> Option<Self>;
    /// Returns the bytes of memory that it takes beside itself.
    fn held(&self) -> usize {
        0
    }
}

impl Numbers for f64 {
    fn numbers(&self) -> Vec<f64> {
        vec![*self]
    }

    fn read(numbers: &[f64]) -> Option<Self> {
        if let [number] = numbers { Some(*number) } else { None }
    }
}

impl Numbers for bool {
    fn numbers(&self) -> Vec<f64> {
        vec![f64::from(u8::from(*self))]
    }

    fn read(numbers: &[f64]) -> Option<Self> {
        f64::read(numbers).map(|number| number != 0.0)
    }
}

impl<const COUNT: usize> Numbers for [f64; COUNT] {
    fn numbers(&self) -> Vec<f64> {
        self.to_vec()
    }

    fn read(numbers: &[f64]) -> Option<Self> {
        numbers.try_into().ok()
    }
}

impl Numbers for Arc<[f64]> {
    fn numbers(&self) -> Vec<f64> {
        self.to_vec()
    }

    fn read(numbers: &[f64]) -> Option<Self> {
        Some(numbers.into())
    }

    fn held(&self) -> usize {
        size_of_val::<[f64]>(self)
    }
}

impl Numbers for Arc<[i32]> {
    fn numbers(&self) -> Vec<f64> {
        self.iter().copied().map(f64::from).collect()
    }

    fn read(numbers: &[f64]) -> Option<Self> {
        Some(numbers.iter().map(|number| *number as i32).collect())
    }

    fn held(&self) -> usize {
        size_of_val::<[i32]>(self)
    }
}

/// Texts by their characters. Each ends with a 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Texts(pub Arc<[f64]>);

impl Texts {
    /// Packs texts.
    pub fn new<'a>(texts: impl Iterator<Item = &'a str>) -> Self {
        Self(texts.flat_map(|text| text.chars().chain(['\0'])).map(|c| f64::from(u32::from(c))).collect())
    }

    /// Returns the texts.
    pub fn all(&self) -> Vec<String> {
        let texts = self.0.split_inclusive(|code| *code == 0.0).filter(|text| text.last() == Some(&0.0));
        let text = |codes: &[f64]| {
            codes.iter().take(codes.len() - 1).filter_map(|code| char::from_u32(*code as u32)).collect()
        };
        texts.map(text).collect()
    }
}

impl Numbers for Texts {
    fn numbers(&self) -> Vec<f64> {
        self.0.to_vec()
    }

    fn read(numbers: &[f64]) -> Option<Self> {
        Some(Self(numbers.into()))
    }

    fn held(&self) -> usize {
        size_of_val::<[f64]>(&self.0)
    }
}

/// Defines the reading of one type of sensor: its quantities with their types and units.
macro_rules! reading {
    ($(#[$doc:meta])* { $($(#[$about:meta])* $field:ident: $type:ty = $unit:literal,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct Reading { $($(#[$about])* pub $field: $type,)* }

        impl Reading {
            pub(super) fn quantities(&self) -> Vec<crate::reading::Quantity> {
                let Self { $($field),* } = self;
                vec![$(crate::reading::Quantity {
                    name: stringify!($field),
                    unit: $unit,
                    values: crate::reading::Numbers::numbers($field),
                }),*]
            }

            pub(super) fn held(&self) -> usize {
                let Self { $($field),* } = self;
                [$(crate::reading::Numbers::held($field)),*].into_iter().sum()
            }

            pub(super) fn read<'a>(find: &dyn Fn(&str) -> Option<&'a [f64]>) -> Option<Self> {
                Some(Self { $($field: crate::reading::Numbers::read(find(stringify!($field))?)?),* })
            }
        }
    };
}

pub(crate) use reading;
