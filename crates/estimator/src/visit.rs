//! Every number of a state in a fixed order: how a state is saved and restored.

/// Something that is made of numbers.
pub(crate) trait Visit {
    /// Calls `f` with each number, in an order that never changes within a version of the crate.
    fn visit(&mut self, f: &mut impl FnMut(&mut f64));
}

impl Visit for f64 {
    fn visit(&mut self, f: &mut impl FnMut(&mut f64)) {
        f(self);
    }
}

impl Visit for bool {
    fn visit(&mut self, f: &mut impl FnMut(&mut f64)) {
        let mut number = f64::from(u8::from(*self));
        f(&mut number);
        *self = number > 0.5;
    }
}

impl<T: Visit, const N: usize> Visit for [T; N] {
    fn visit(&mut self, f: &mut impl FnMut(&mut f64)) {
        for item in self {
            item.visit(f);
        }
    }
}

/// Implements [`Visit`] for a struct by its fields.
macro_rules! visit_fields {
    ($type:ty: $($field:ident),+) => {
        impl crate::visit::Visit for $type {
            fn visit(&mut self, f: &mut impl FnMut(&mut f64)) {
                $(self.$field.visit(f);)+
            }
        }
    };
}
pub(crate) use visit_fields;
