/* From reset to main on a Cortex-M with floating-point unit; with cortex_m.ld. A vendor's startup code takes its place. */
#include <stdint.h>

extern uint32_t load_start, data_start, data_end, bss_start, bss_end, stack_top; /* of cortex_m.ld */
int main(int count, char **arguments);
void reset(void);

void reset(void)
{
    volatile uint32_t *const access = (volatile uint32_t *)0xE000ED88u; /* CPACR: full access to the unit */
    *access |= 0xFu << 20;
    __asm volatile("dsb\n\tisb");
    for (uint32_t *to = &data_start, *from = &load_start; to < &data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = &bss_start; to < &bss_end;) {
        *to++ = 0;
    }
    main(0, 0);
    for (;;) {
    }
}

static void fault(void)
{
    for (;;) {
    }
}

/* Stack, reset, NMI, hard fault, memory fault, bus fault, usage fault. */
__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    &stack_top,          (const void *)reset, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, (const void *)fault};
