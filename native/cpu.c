/* The levels of x86-64 that this processor and its system support. Source: the x86-64 psABI, section 3.1.1, table 3.1. */
#include "cpu.h"

#if defined(__x86_64__) || defined(_M_X64)
#include <stdint.h>
#ifdef _MSC_VER
#include <intrin.h>
static void cpuid(uint32_t leaf, uint32_t *r) { __cpuidex((int *)r, (int)leaf, 0); }
static uint64_t enabled_state(void) { return _xgetbv(0); }
#else
#include <cpuid.h>
static void cpuid(uint32_t leaf, uint32_t *r) {
    if (!__get_cpuid_count(leaf, 0, &r[0], &r[1], &r[2], &r[3])) r[0] = r[1] = r[2] = r[3] = 0;
}
static uint64_t enabled_state(void) {
    uint32_t low, high;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return (uint64_t)high << 32 | low;
}
#endif

enum { A, B, C, D };
#define HAS(bits, wanted) (((bits) & (wanted)) == (wanted))
#define BIT(n) (1u << (n))

int x86_level(void) {
    uint32_t basic[4], more[4], far_more[4];
    cpuid(1, basic);
    cpuid(7, more);
    cpuid(0x80000001u, far_more);
    /* SSE3, SSSE3, CMPXCHG16B, SSE4.1, SSE4.2, POPCNT; LAHF */
    if (!HAS(basic[C], BIT(0) | BIT(9) | BIT(13) | BIT(19) | BIT(20) | BIT(23)) || !HAS(far_more[C], BIT(0))) return 1;
    /* FMA, MOVBE, OSXSAVE, AVX, F16C; BMI1, AVX2, BMI2; LZCNT; and the system saves AVX registers */
    if (!HAS(basic[C], BIT(12) | BIT(22) | BIT(27) | BIT(28) | BIT(29)) || !HAS(more[B], BIT(3) | BIT(5) | BIT(8)) ||
        !HAS(far_more[C], BIT(5)) || !HAS(enabled_state(), 0x06))
        return 2;
    /* AVX512F, DQ, CD, BW, VL; and the system saves their registers */
    if (!HAS(more[B], BIT(16) | BIT(17) | BIT(28) | BIT(30) | BIT(31)) || !HAS(enabled_state(), 0xe6)) return 3;
    return 4;
}
#else
int x86_level(void) { return 0; }
#endif
