//! Parameters with named items: their integers never change.

use crate::model::Item;
use crate::variables::settings::Settings;

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
