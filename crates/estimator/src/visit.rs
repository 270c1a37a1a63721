//! The numbers of a state in a fixed order, to save and restore it.

/// A state that consists of numbers.
pub(crate) trait Visit {
    /// Calls `f` with each number, in an order that is part of the format of saved states.
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

/// Whole numbers up to 2^53 are exact.
impl Visit for i64 {
    fn visit(&mut self, f: &mut impl FnMut(&mut f64)) {
        #[expect(clippy::cast_precision_loss, reason = "stated above")]
        let mut number = *self as f64;
        f(&mut number);
        #[expect(clippy::cast_possible_truncation, reason = "stated above")]
        let whole = number as i64;
        *self = whole;
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
