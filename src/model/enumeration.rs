//! Enumerations whose items a user selects by name or integer.

/// One item of an enumeration.
#[derive(Debug)]
pub struct Item {
    /// Name as in the description.
    pub name: &'static str,
    /// The integer that hosts use; it never changes.
    pub value: i32,
    /// Text for users.
    pub description: &'static str,
}

/// Defines enumerations: each item with its name and its text, the first with its integer.
macro_rules! enumerations {
    ($($(#[$doc:meta])* $type:ident { $($item:ident $(= $first:literal)? $name:literal $text:literal,)* })*) => {$(
        $(#[$doc])*
        // The texts of items are for users: `[i]` is an index, not a link.
        #[allow(rustdoc::broken_intra_doc_links)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $type {
            $(#[doc = $text] $item $(= $first)?),*
        }

        impl $type {
            /// All items.
            pub const ITEMS: &[$crate::model::Item] =
                &[$($crate::model::Item { name: $name, value: Self::$item as i32, description: $text }),*];

            /// The item with this integer.
            pub fn numbered(value: i32) -> Option<Self> {
                [$(Self::$item),*].into_iter().find(|item| *item as i32 == value)
            }
        }
    )*};
}
pub(crate) use enumerations;
