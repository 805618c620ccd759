//! The floating-point environment of the host, and the default one in which everything here is computed.
//!
//! A thread has a rounding mode, a choice of what becomes of subnormal numbers, exceptions that end the process instead
//! of giving an infinity or a NaN, and flags of those that have happened. Rust assumes the default throughout: rounding
//! to nearest, subnormal numbers kept, no traps. Hosts in Delphi, with `gfortran -ffpe-trap` or with numerics of their
//! own have something else. So each call of theirs sets the default, and leaves everything as it was found, flags
//! included: what was inexact here is nothing the host has done.

use std::cell::Cell;
use std::rc::Rc;

use registers::Registers;

/// The host's environment, while one of its calls is executed.
#[derive(Clone, Default)]
pub(crate) struct HostFenv(Rc<Cell<Registers>>);

/// Until this is dropped, the environment is the default one.
pub(crate) struct Inside<'a>(&'a HostFenv);

impl HostFenv {
    /// Saves the host's environment, and sets the default one until what it returns is dropped.
    #[inline]
    pub(crate) fn enter(&self) -> Inside<'_> {
        self.leave();
        Inside(self)
    }

    /// Calls the host back in its environment. What it changes there is kept for it.
    pub(crate) fn outside<T>(&self, callback: impl FnOnce() -> T) -> T {
        self.restore();
        let answer = callback();
        self.leave();
        answer
    }

    #[inline]
    fn leave(&self) {
        let found = Registers::read();
        self.0.set(found);
        found.change(found.with_default_control());
    }

    #[inline]
    fn restore(&self) {
        Registers::read().change(self.0.get());
    }
}

impl Drop for Inside<'_> {
    #[inline]
    fn drop(&mut self) {
        self.0.restore();
    }
}

/// 64-bit x86, and 32-bit x86 with SSE2. Which registers and what their bits mean: Intel 64 and IA-32 Architectures
/// Software Developer's Manual, volume 1, 8.1 and 10.2.3.
#[cfg(any(target_arch = "x86_64", all(target_arch = "x86", target_feature = "sse2")))]
mod registers {
    use std::arch::asm;
    use std::mem::MaybeUninit;

    #[derive(Clone, Copy, Default)]
    pub(super) struct Registers {
        /// Control and flags of SSE.
        mxcsr: u32,
        /// With 32 bits, integers of 64 bits are converted to doubles and back by the x87.
        #[cfg(target_arch = "x86")]
        x87: x87::Registers,
    }

    /// The flags in MXCSR of exceptions that have happened.
    const FLAGS: u32 = 0x3f;
    /// Its default: all exceptions masked, nothing else set.
    const DEFAULT: u32 = 0x1f80;

    impl Registers {
        #[inline]
        pub(super) fn read() -> Self {
            let mut mxcsr = MaybeUninit::<u32>::uninit();
            // SAFETY: writes these four bytes, and no others.
            unsafe { asm!("stmxcsr [{}]", in(reg) mxcsr.as_mut_ptr(), options(nostack, preserves_flags)) };
            Self {
                // SAFETY: written.
                mxcsr: unsafe { mxcsr.assume_init() },
                #[cfg(target_arch = "x86")]
                x87: x87::Registers::read(),
            }
        }

        #[inline]
        pub(super) fn with_default_control(self) -> Self {
            Self {
                mxcsr: self.mxcsr & FLAGS | DEFAULT,
                #[cfg(target_arch = "x86")]
                x87: self.x87.with_default_control(),
            }
        }

        /// Writes the registers `to` where these differ: writing is slower than comparing.
        #[inline]
        pub(super) fn change(self, to: Self) {
            if self.mxcsr != to.mxcsr {
                to.write_mxcsr();
            }
            #[cfg(target_arch = "x86")]
            self.x87.change(to.x87);
        }

        /// Not inlined, so that only a change stores the new value in memory.
        #[cold]
        #[inline(never)]
        fn write_mxcsr(self) {
            // SAFETY: reads these four bytes, which are the default or were in the register. Code of Rust relies on the
            // default, which is set for all of it; no flag traps before an exception occurs again.
            unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const self.mxcsr, options(nostack, readonly)) };
        }
    }

    #[cfg(target_arch = "x86")]
    mod x87 {
        use std::arch::asm;

        #[derive(Clone, Copy, Default, PartialEq)]
        pub(super) struct Registers {
            control: u16,
            /// The flags of the status word only.
            flags: u16,
        }

        /// The flags in the status word of exceptions that have happened, stack faults among them.
        const FLAGS: u16 = 0x7f;
        /// The control word after `fninit`: all exceptions masked, 64-bit significands, rounding to nearest.
        const DEFAULT: u16 = 0x37f;

        impl Registers {
            #[inline]
            pub(super) fn read() -> Self {
                let (mut control, mut status) = (0_u16, 0_u16);
                // SAFETY: writes these two bytes only.
                unsafe { asm!("fnstcw [{}]", in(reg) &raw mut control, options(nostack, preserves_flags)) };
                // SAFETY: writes the two bytes of `status` only.
                unsafe { asm!("fnstsw [{}]", in(reg) &raw mut status, options(nostack, preserves_flags)) };
                Self { control, flags: status & FLAGS }
            }

            pub(super) fn with_default_control(self) -> Self {
                Self { control: DEFAULT, ..self }
            }

            /// Writes the registers `to` where these differ. The control word alone cannot be written: with a flag set,
            /// an exception that it unmasks traps.
            pub(super) fn change(self, to: Self) {
                if self != to {
                    // Control word and status word are the lower halves of the first two of these.
                    let mut all = [0_u32; 7];
                    // SAFETY: writes these 28 bytes, and masks all exceptions.
                    unsafe { asm!("fnstenv [{}]", in(reg) &raw mut all, options(nostack)) };
                    all[0] = all[0] & !0xffff | u32::from(to.control);
                    all[1] = all[1] & !u32::from(FLAGS) | u32::from(to.flags);
                    // SAFETY: reads what was written, with control and flags that are the default or were there.
                    unsafe { asm!("fldenv [{}]", in(reg) &raw const all, options(nostack, readonly)) };
                }
            }
        }
    }
}

/// 64-bit ARM. What the bits mean: Arm Architecture Reference Manual for A-profile, FPCR and FPSR.
#[cfg(target_arch = "aarch64")]
mod registers {
    use std::arch::asm;

    #[derive(Clone, Copy, Default)]
    pub(super) struct Registers {
        /// FPCR: all bits are 0 by default.
        control: u64,
        /// FPSR.
        flags: u64,
    }

    impl Registers {
        #[inline]
        pub(super) fn read() -> Self {
            let (control, flags);
            // SAFETY: reads registers; that memory is taken as changed keeps arithmetic on its side.
            unsafe {
                asm!("mrs {}, fpcr", out(reg) control, options(nostack, preserves_flags));
                asm!("mrs {}, fpsr", out(reg) flags, options(nostack, preserves_flags));
            }
            Self { control, flags }
        }

        #[inline]
        pub(super) fn with_default_control(self) -> Self {
            Self { control: 0, ..self }
        }

        /// Writes the registers `to` where these differ: writing is slower than comparing.
        #[inline]
        pub(super) fn change(self, to: Self) {
            if self.control != to.control {
                // SAFETY: the default, on which code of Rust relies and which is set for all of it, or what was there.
                unsafe { asm!("msr fpcr, {}", in(reg) to.control, options(nostack)) };
            }
            if self.flags != to.flags {
                // SAFETY: these were in the register.
                unsafe { asm!("msr fpsr, {}", in(reg) to.flags, options(nostack)) };
            }
        }
    }
}

/// Other processors: the host is relied on for the default environment.
#[cfg(not(any(target_arch = "x86_64", all(target_arch = "x86", target_feature = "sse2"), target_arch = "aarch64")))]
mod registers {
    #[derive(Clone, Copy, Default)]
    pub(super) struct Registers;

    impl Registers {
        pub(super) fn read() -> Self {
            Self
        }

        pub(super) fn with_default_control(self) -> Self {
            self
        }

        pub(super) fn change(self, _to: Self) {}
    }
}
