/* The floating-point environment of this thread, as the registers of the processor have it, in one number; others that
 * a host may have; and calls in them. In GNU's C, for x86 and 64-bit ARM. */

#include <stdint.h>

#if defined(__aarch64__)

/* FPCR in the lower half, FPSR in the upper one. */
static uint64_t get_environment(void) {
    uint64_t control, flags;
    __asm__ volatile("mrs %0, fpcr\n\tmrs %1, fpsr" : "=r"(control), "=r"(flags) : : "memory");
    return control | flags << 32;
}
static void set_environment(uint64_t to) {
    uint64_t control = (uint32_t)to, flags = to >> 32;
    __asm__ volatile("msr fpcr, %0\n\tmsr fpsr, %1" : : "r"(control), "r"(flags) : "memory");
}
enum { DEFAULT = 0 };
static const uint64_t TRAPS = 0x9f00, UPWARDS = 0x400000, DOWNWARDS = 0x800000, TO_ZERO = 0xc00000, FLUSHED = 0x1000000,
                      INEXACT = 0x10ULL << 32, ALL_FLAGS = 0x9fULL << 32;

#elif defined(__x86_64__)

static uint64_t get_environment(void) {
    uint32_t mxcsr;
    __asm__ volatile("stmxcsr %0" : "=m"(mxcsr) : : "memory");
    return mxcsr;
}
static void set_environment(uint64_t to) {
    uint32_t mxcsr = (uint32_t)to;
    __asm__ volatile("ldmxcsr %0" : : "m"(mxcsr) : "memory");
}
enum { DEFAULT = 0x1f80 };
static const uint64_t TRAPS = 0x1f80, UPWARDS = 0x4000, DOWNWARDS = 0x2000, TO_ZERO = 0x6000, FLUSHED = 0x8040,
                      INEXACT = 0x20, ALL_FLAGS = 0x3f;

#elif defined(__i386__)

/* MXCSR in the lower half, control word and flags of the x87 in the upper one. Flags are set in MXCSR only: those of
 * the x87 would trap in the host itself. */
static uint64_t get_environment(void) {
    uint32_t mxcsr;
    uint16_t control, status;
    __asm__ volatile("stmxcsr %0\n\tfnstcw %1\n\tfnstsw %2" : "=m"(mxcsr), "=m"(control), "=m"(status) : : "memory");
    return mxcsr | (uint64_t)control << 32 | (uint64_t)(status & 0x7f) << 48;
}
static void set_environment(uint64_t to) {
    uint32_t mxcsr = (uint32_t)to, x87[7];
    __asm__ volatile("ldmxcsr %1\n\tfnstenv %0" : "=m"(x87) : "m"(mxcsr) : "memory");
    x87[0] = (x87[0] & ~0xffffu) | (uint16_t)(to >> 32);
    x87[1] = (x87[1] & ~0x7fu) | (uint16_t)(to >> 48);
    __asm__ volatile("fldenv %0" : : "m"(x87) : "memory");
}
#define DEFAULT 0x37f00001f80ULL
static const uint64_t TRAPS = 0x3f00001f80, UPWARDS = 0x80000004000, DOWNWARDS = 0x40000002000,
                      TO_ZERO = 0xc0000006000, FLUSHED = 0x30000008040 /* and single precision */, INEXACT = 0x20,
                      ALL_FLAGS = 0x3f;

#endif

/* What a host may have instead of the default. Where traps are on, every exception traps, even an inexact result. */
enum { ENVIRONMENTS = 7 };
static const char *const ENVIRONMENT_NAMES[ENVIRONMENTS] = {
    "the default", "with traps", "upwards", "downwards", "towards zero", "flushed to zero", "with all of it",
};
static uint64_t host_environment(int which) {
    const uint64_t bits[ENVIRONMENTS] = {
        0, TRAPS, UPWARDS, DOWNWARDS, TO_ZERO, FLUSHED, TRAPS ^ UPWARDS ^ FLUSHED ^ ALL_FLAGS,
    };
    set_environment(DEFAULT ^ bits[which]);
    uint64_t found = get_environment(); /* not all processors have traps */
    set_environment(DEFAULT);
    return found;
}

/* A call of the FMU in the host's environment; `otherwise` if that is another one then. All else is computed in the
 * default one. */
#define CALL_IN(hosts, call, otherwise) \
    ({ \
        set_environment(hosts); \
        __typeof__(call) answer = (call); \
        uint64_t found = get_environment(); \
        set_environment(DEFAULT); \
        if (found != (hosts)) otherwise; \
        answer; \
    })
