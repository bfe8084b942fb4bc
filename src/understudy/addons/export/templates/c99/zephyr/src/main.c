/* Runs $name on Zephyr: where the comments say so, put in your sensors and motors. */

#include <zephyr/kernel.h>

#include "$name.h"

int main(void)
{
    static ${name}_machine machine;
    static ${name}_readings readings;
    static ${name}_commands commands;

    ${name}_start(&machine, $zephyr_now);
    for (;;) {
        ${name}_clear_readings(&readings); /* everything is absent */
        /* Your sensors. What stays absent is a reading without an answer. */
$zephyr_readings
        ${name}_step(&machine, &readings, $zephyr_now, &commands);
        /* Your motors. */
$zephyr_commands
        k_msleep(${NAME}_TICK_MS);
    }
    return 0;
}
