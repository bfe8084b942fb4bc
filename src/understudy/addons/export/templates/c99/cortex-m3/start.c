/* Start of a Cortex-M3 with semihosting, as QEMU's machine lm3s6965evb has it; not needed on a board with its own. */

#include <stdint.h>
#include <stdlib.h>

extern uint32_t data_load, data_begin, data_end, bss_begin, bss_end;
extern void stack_top(void); /* an address; the first vector is not called */
extern void initialise_monitor_handles(void);
extern int main(void);

void reset(void);
void reset(void)
{
    const uint32_t *from = &data_load;
    for (uint32_t *to = &data_begin; to < &data_end; to++)
        *to = *from++;
    for (uint32_t *to = &bss_begin; to < &bss_end; to++)
        *to = 0;
    initialise_monitor_handles();
    exit(main());
}

static void halt(void)
{
    exit(3);
}

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    stack_top, reset, halt, halt, halt, halt, halt, 0, 0, 0, 0, halt, halt, 0, halt, halt,
};
