//! Functions that are compiled for more than one kind of processor.
//!
//! Binaries are made for every x86-64 processor: their instructions take up to two doubles at once. Nearly all processors have AVX2,
//! whose instructions take four. What most of the time goes into is compiled for both, and the processor at hand decides. Every number
//! of a vector is rounded as if it were alone, and nothing is fused: both versions give the same bits.

/// Makes methods that call their portable version, compiled for any x86-64 processor or for AVX2. That version, and what takes time
/// in it, must be `#[inline(always)]`: what is not inlined is compiled for any processor only.
macro_rules! multiversioned {
    (impl $type:ty { $(
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident(&mut self $(, $argument:ident: $of:ty)*) $(-> $result:ty)? = $portable:ident;
    )+ }) => { impl $type { $(
        $(#[$attribute])*
        #[inline]
        $visibility fn $name(&mut self $(, $argument: $of)*) $(-> $result)? {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn with_avx2(this: &mut $type $(, $argument: $of)*) $(-> $result)? {
                    this.$portable($($argument),*)
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    #[expect(unsafe_code, reason = "a call that needs AVX2")]
                    // SAFETY: the processor has it.
                    return unsafe { with_avx2(self $(, $argument)*) };
                }
            }
            // Inlined, it would take up the caller's registers and instruction cache.
            #[inline(never)]
            fn for_any(this: &mut $type $(, $argument: $of)*) $(-> $result)? {
                this.$portable($($argument),*)
            }
            for_any(self $(, $argument)*)
        }
    )+ } };
}

pub(crate) use multiversioned;
