/* A board whose line is a UART of four registers: data, state, control and baud divider, as Arm's CMSDK has it. QEMU's
 * mps2-an500 (Cortex-M7) has one at this address. For another UART change the registers; nothing else knows of them. */
#include "board.h"

#ifndef UART_BASE
#define UART_BASE 0x40004000u
#endif
#ifndef UART_INTERRUPT
#define UART_INTERRUPT 0u /* of the receiver, in the interrupt controller */
#endif
#ifndef UART_DIVIDER
#define UART_DIVIDER 217u /* 25 MHz / 115200 */
#endif

typedef struct {
    volatile uint32_t data, state, control, interrupt, divider;
} Uart;

enum {
    STATE_SEND_FULL = 1,
    STATE_RECEIVE_FULL = 2,
    CONTROL_SEND = 1,
    CONTROL_RECEIVE = 2,
    CONTROL_RECEIVE_INTERRUPT = 8
};
enum { INTERRUPT_RECEIVED = 2 };

/* NVIC: enables interrupts, and clears pending ones. */
static volatile uint32_t *const interrupt_enable = (volatile uint32_t *)0xE000E100u;
static volatile uint32_t *const interrupt_clear = (volatile uint32_t *)0xE000E280u;

uint32_t (*const board_clock)(void) = NULL; /* a UART has one other end */

static Uart *const uart = (Uart *)UART_BASE;

bool board_begin(int count, char **arguments)
{
    (void)count, (void)arguments;
    uart->divider = UART_DIVIDER;
    uart->control = CONTROL_SEND | CONTROL_RECEIVE | CONTROL_RECEIVE_INTERRUPT;
    __asm volatile("cpsid i"); /* an interrupt ends the sleep of the processor and has no handler */
    *interrupt_enable = 1u << UART_INTERRUPT;
    return true;
}

/* Sleeps until a byte is there. Between a frame and its answer the other end sends nothing, but for a request that it sends again. Where a step
 * takes longer than a byte and the UART has no FIFO, let the interrupt of the receiver fill a ring of LINK_FRAME_MAX bytes. */
bool board_receive(uint8_t *byte, bool *turned)
{
    (void)turned;
    while ((uart->state & STATE_RECEIVE_FULL) == 0u) {
        __asm volatile("dsb\n\twfi");
        uart->interrupt = INTERRUPT_RECEIVED;
        *interrupt_clear = 1u << UART_INTERRUPT;
    }
    *byte = (uint8_t)uart->data;
    return true;
}

void board_send(void *line, const uint8_t *bytes, size_t n)
{
    (void)line;
    for (size_t i = 0; i < n; ++i) {
        while ((uart->state & STATE_SEND_FULL) != 0u) {
        }
        uart->data = bytes[i];
    }
}
