//! Code for wide registers where the processor has them.

/// A function, perhaps of array length `N`, compiled once for every processor and once for those with AVX2, chosen at run time. Both
/// do the same operations in the same order, so results are equal bit for bit.
macro_rules! wide {
    (
        $(#[$meta:meta])*
        $visible:vis fn $name:ident $(<const $n:ident: usize>)? ($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? $body:block
    ) => {
        $(#[$meta])*
        #[inline]
        $visible fn $name $(<const $n: usize>)? ($($argument: $type),*) $(-> $result)? {
            #[inline(always)]
            fn any $(<const $n: usize>)? ($($argument: $type),*) $(-> $result)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn avx2 $(<const $n: usize>)? ($($argument: $type),*) $(-> $result)? {
                    any($($argument),*)
                }

                if std::arch::is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor has what the function is compiled for.
                    return unsafe { avx2($($argument),*) };
                }
            }
            any($($argument),*)
        }
    };
}

pub(crate) use wide;
