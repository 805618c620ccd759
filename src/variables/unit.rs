//! Units with their SI base exponents, and the physical quantities the variables are declared with.

/// A unit and the exponents of kg, m and s in it. All are SI units, so factor 1 and offset 0.
#[derive(Debug, PartialEq, Eq)]
pub struct Unit {
    /// Name as variables refer to it.
    pub name: &'static str,
    /// Exponents of kg, m and s.
    pub exponents: [i8; 3],
}

/// A physical quantity: the type definition that real variables are declared with.
#[derive(Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Name of the type definition; capitalised, so that it never equals a variable's name.
    pub name: &'static str,
    /// Unit of every variable of this quantity.
    pub unit: &'static Unit,
}

macro_rules! units {
    ($($id:ident $name:literal $kg:literal $m:literal $s:literal;)*) => {
        $(#[doc = concat!("The unit ", $name, ".")]
        static $id: Unit = Unit { name: $name, exponents: [$kg, $m, $s] };)*
        /// Every unit that a quantity uses.
        pub static UNITS: &[&Unit] = &[$(&$id),*];
    };
}

macro_rules! quantities {
    ($($id:ident $name:literal $unit:ident;)*) => {
        $(#[doc = concat!("The quantity ", $name, ".")]
        pub static $id: Quantity = Quantity { name: $name, unit: &$unit };)*
        /// Every quantity; a variable can only be declared with one of these.
        pub static QUANTITIES: &[&Quantity] = &[$(&$id),*];
    };
}

units! {
    ONE "1" 0 0 0;
    METRE "m" 0 1 0;
    SECOND "s" 0 0 1;
    KILOGRAM "kg" 1 0 0;
    METRE_PER_SECOND "m/s" 0 1 -1;
    METRE_PER_SECOND_SQUARED "m/s2" 0 1 -2;
    SECOND_PER_METRE "s/m" 0 -1 1;
    KILOGRAM_PER_SECOND "kg/s" 1 0 -1;
    KILOGRAM_METRE_PER_SECOND "kg.m/s" 1 1 -1;
    NEWTON "N" 1 1 -2;
    NEWTON_PER_METRE "N/m" 1 0 -2;
    NEWTON_SECOND "N.s" 1 1 -1;
    NEWTON_SECOND_PER_METRE "N.s/m" 1 0 -1;
    JOULE "J" 1 2 -2;
    PASCAL "Pa" 1 -1 -2;
}

quantities! {
    RATIO "Ratio" ONE;
    LENGTH "Length" METRE;
    TIME "Time" SECOND;
    MASS "Mass" KILOGRAM;
    VELOCITY "Velocity" METRE_PER_SECOND;
    ACCELERATION "Acceleration" METRE_PER_SECOND_SQUARED;
    SLOWNESS "Slowness" SECOND_PER_METRE;
    DRAG "Drag" KILOGRAM_PER_SECOND;
    MOMENTUM "Momentum" KILOGRAM_METRE_PER_SECOND;
    FORCE "Force" NEWTON;
    STIFFNESS "Stiffness" NEWTON_PER_METRE;
    IMPULSE "Impulse" NEWTON_SECOND;
    DAMPING "Damping" NEWTON_SECOND_PER_METRE;
    ENERGY "Energy" JOULE;
    ELASTIC_MODULUS "ElasticModulus" PASCAL;
}
