//! Closed lists of kinds.

/// Defines an enum of types that have the same verbs. An enum can be cloned, unlike boxed traits, so a world can be copied.
macro_rules! kinds {
    ($(#[$attribute:meta])* $visible:vis enum $name:ident of $verbs:ident { $($kind:ident($type:ty)),* $(,)? }) => {
        $(#[$attribute])*
        #[derive(Clone)]
        $visible enum $name {
            $($kind($type)),*
        }

        impl $name {
            /// Returns it for questions.
            $visible fn get(&self) -> &dyn $verbs {
                match self {
                    $(Self::$kind(it) => it),*
                }
            }

            /// Returns it for changes.
            $visible fn get_mut(&mut self) -> &mut dyn $verbs {
                match self {
                    $(Self::$kind(it) => it),*
                }
            }
        }
    };
}

pub(crate) use kinds;
