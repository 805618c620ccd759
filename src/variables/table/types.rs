//! What variables are declared with: physical quantities with their units, and enumerations, whose integers never
//! change.

use crate::model::Item;
use crate::variables::settings::Settings;

/// A physical quantity: the type definition that real variables are declared with.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    /// Name of the type definition; capitalised, so that it never equals a variable's name.
    pub name: &'static str,
    /// Unit of every variable of this quantity; no other of [`QUANTITIES`] has it. All are SI units, with factor 1 and
    /// offset 0.
    pub unit: &'static str,
    /// Exponents of kg, m and s in the unit.
    pub exponents: [i8; 3],
    /// Unit in which tools show values instead, and how many of it make one `unit`.
    pub display: Option<(&'static str, f64)>,
}

impl Quantity {
    /// Attributes of the unit in base units, such as ` kg="1" m="1" s="-2"`.
    pub fn base_units(&self) -> String {
        let powers = ["kg", "m", "s"].into_iter().zip(self.exponents).filter(|(_, power)| *power != 0);
        powers.map(|(base, power)| format!(" {base}=\"{power}\"")).collect()
    }
}

macro_rules! quantities {
    ($(
        $id:ident $name:literal $unit:literal $kg:literal $m:literal $s:literal
        $(shown $shown:ident $shown_name:literal $display:literal $factor:literal)*;
    )*) => {
        $(
            #[doc = concat!("The quantity ", $name, ".")]
            pub static $id: Quantity = Quantity { name: $name, unit: $unit, exponents: [$kg, $m, $s], display: None };
            $(
                #[doc = concat!("The same as [`", stringify!($id), "`], shown in ", $display, ".")]
                pub static $shown: Quantity = Quantity { name: $shown_name, display: Some(($display, $factor)), ..$id };
            )*
        )*
        /// Every quantity, as shown in its SI unit, and again in each unit that it is shown in where numbers are far
        /// from 1; a variable is declared with one of these.
        pub static QUANTITIES: &[(&Quantity, &[&Quantity])] = &[$((&$id, &[$(&$shown),*])),*];
    };
}

quantities! {
    RATIO "Ratio" "1" 0 0 0;
    ANGLE "Angle" "rad" 0 0 0 shown ANGLE_DEG "Angle_deg" "deg" 57.295_779_513_082_32;
    LENGTH "Length" "m" 0 1 0 shown LENGTH_MM "Length_mm" "mm" 1e3 shown LENGTH_UM "Length_um" "um" 1e6;
    TIME "Time" "s" 0 0 1 shown TIME_US "Time_us" "us" 1e6;
    MASS "Mass" "kg" 1 0 0;
    VELOCITY "Velocity" "m/s" 0 1 -1;
    ACCELERATION "Acceleration" "m/s2" 0 1 -2;
    SLOWNESS "Slowness" "s/m" 0 -1 1;
    DRAG "Drag" "kg/s" 1 0 -1;
    MOMENTUM "Momentum" "kg.m/s" 1 1 -1;
    FORCE "Force" "N" 1 1 -2 shown FORCE_KN "Force_kN" "kN" 1e-3;
    STIFFNESS "Stiffness" "N/m" 1 0 -2 shown STIFFNESS_N_UM "Stiffness_N_um" "N/um" 1e-6;
    IMPULSE "Impulse" "N.s" 1 1 -1;
    DAMPING "Damping" "N.s/m" 1 0 -1;
    ENERGY "Energy" "J" 1 2 -2;
    POWER "Power" "W" 1 2 -3;
    ELASTIC_MODULUS "ElasticModulus" "Pa" 1 -1 -2 shown ELASTIC_MODULUS_GPA "ElasticModulus_GPa" "GPa" 1e-9;
}

/// An enumeration and access to its value.
pub struct Enumeration {
    /// Name of the type definition.
    pub type_name: &'static str,
    /// Its items.
    pub items: &'static [Item],
    /// The integer of the current item.
    pub get: fn(&Settings) -> i32,
    /// Selects the item with this integer; one that is not in `items` changes nothing.
    pub set: fn(&mut Settings, i32),
}

impl Enumeration {
    /// The item with this integer.
    pub fn item(&self, value: f64) -> Option<&'static Item> {
        self.items.iter().find(|item| f64::from(item.value) == value)
    }
}

/// The choices, for messages: `powerLaw (1) or hertz (2) or rigid (3)`.
impl std::fmt::Display for Enumeration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let items: Vec<String> = self.items.iter().map(|item| format!("{} ({})", item.name, item.value)).collect();
        f.write_str(&items.join(" or "))
    }
}

/// A parameter that is an enumeration in this field of [`Settings`].
macro_rules! item {
    ($($field:ident).+: $type:ty) => {
        const {
            &$crate::variables::Enumeration {
                type_name: stringify!($type),
                items: <$type>::ITEMS,
                get: |settings| settings.$($field).+ as i32,
                set: |settings, value| {
                    if let Some(item) = <$type>::numbered(value) {
                        settings.$($field).+ = item;
                    }
                },
            }
        }
    };
}
pub(in crate::variables) use item;
