/* Start-up of the emulated board before that of the C library: the floating-point unit, and the table of vectors. */
#include <stdint.h>
void _start(void);
static void reset(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    _start();
}
__attribute__((section(".vectors"), used)) static const uintptr_t table[16] = {0x380000u, (uintptr_t)reset,
                                                                               (uintptr_t)reset, (uintptr_t)reset};
