/* What each call of the block costs, on the board's second UART: the time of the call in ticks, with the highest bit
 * set at the start of a run, and the deepest stack since the first call in bytes; 4 bytes each, lowest first. The
 * linker puts it round block_sample (--wrap), which is not changed.
 *
 * QEMU runs an instruction in 1 ns (-icount shift=0) and SysTick counts at 25 MHz, so a tick is 40 instructions. It
 * has 24 bits: a call may have 671 million. */
#include "block.h"

#include <stdint.h>

extern uint32_t stack_top; /* of cortex_m.ld */

const char *__real_block_sample(const Parameters *p, Memory *memory, const Inputs *u, double t, double h, Outputs *y);
const char *__wrap_block_sample(const Parameters *p, Memory *memory, const Inputs *u, double t, double h, Outputs *y);

typedef struct {
    volatile uint32_t control, reload, now;
} SysTick;

typedef struct {
    volatile uint32_t data, state, control, interrupt, divider;
} Uart;

static SysTick *const clock = (SysTick *)0xE000E010;
static Uart *const uart = (Uart *)0x40005000;
enum { BITS = 0xFFFFFF, ON_BY_PROCESSOR = 5, SEND = 1, FULL = 1 };

enum { STACK_WORDS = 1 << 14 }; /* that are looked at: 64 KB */
static const uint32_t PATTERN = UINT32_C(0xA5A5A5A5);

/* Fills the stack below the caller's frame, once. */
static void paint_stack(void)
{
    static bool painted;
    uint32_t *end;
    __asm volatile("mov %0, sp" : "=r"(end));
    for (volatile uint32_t *p = &stack_top - STACK_WORDS; p < end && !painted; ++p) {
        *p = PATTERN;
    }
    painted = true;
}

static uint32_t stack_used(void)
{
    const uint32_t *p = &stack_top - STACK_WORDS;
    while (p < &stack_top && *p == PATTERN) {
        ++p;
    }
    return (uint32_t)((uintptr_t)&stack_top - (uintptr_t)p);
}

static void report(uint32_t value)
{
    for (int i = 0; i < 4; ++i) {
        while (uart->state & FULL) {
        }
        uart->data = value >> (8 * i) & 0xFFu;
    }
}

const char *__wrap_block_sample(const Parameters *p, Memory *memory, const Inputs *u, double t, double h, Outputs *y)
{
    paint_stack();
    uart->divider = 16;
    uart->control = SEND;
    clock->reload = BITS;
    clock->now = 0;
    clock->control = ON_BY_PROCESSOR;
    const uint32_t begun = clock->now;
    const char *why = __real_block_sample(p, memory, u, t, h, y);
    const uint32_t ticks = (begun - clock->now) & BITS;
    report(h > 0.0 ? ticks : ticks | UINT32_C(1) << 31);
    report(stack_used());
    return why;
}
