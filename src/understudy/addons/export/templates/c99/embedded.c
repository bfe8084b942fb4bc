/* Runs $name on a part of the conformance rows, which embedded_rows.h has as tables, on a computer without files.
   Text goes to semihosting (Cortex-M) or to the UART (AVR). */

#include <stdio.h>
#include <string.h>

#include "$name.h"

#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#else
#define PROGMEM
#define memcpy_P memcpy
#endif

typedef struct {
    ${name}_time time;
    ${name}_readings readings;
    ${name}_commands commands;
    uint8_t path[${NAME}_LEVELS];
    uint8_t flags[${NAME}_LEVELS];
    uint8_t levels;
    uint8_t starts;
    uint8_t basic;
} row_type;

#define ABSENT ((${name}_real)NAN)
#include "embedded_rows.h"

#ifdef __AVR__
static int put_character(char character, FILE *stream)
{
    (void)stream;
    while (!(UCSR0A & (1 << UDRE0))) {
    }
    UDR0 = (uint8_t)character;
    return 0;
}
#endif

int main(void)
{
    static ${name}_machine machine;
    static row_type row;
    ${name}_commands commands;
    unsigned ticks = 0, mismatches = 0;
#ifdef __AVR__
    static FILE out;
    fdev_setup_stream(&out, put_character, NULL, _FDEV_SETUP_WRITE);
    stdout = &out;
    UBRR0 = 0;
    UCSR0B = 1 << TXEN0;
#endif
    for (ticks = 0; ticks < ROWS; ticks++) {
        uint8_t path[${NAME}_LEVELS], flags[${NAME}_LEVELS], levels, basic;
        int right;
        memcpy_P(&row, &rows[ticks], sizeof row);
        if (row.starts)
            ${name}_start(&machine, row.time);
        basic = ${name}_step(&machine, &row.readings, row.time, &commands);
        levels = ${name}_path(&machine, path, flags);
        right = levels == row.levels && basic == row.basic;
        right = right && memcmp(path, row.path, levels) == 0 && memcmp(flags, row.flags, levels) == 0;
$check_row
        mismatches += !right;
    }
    printf("%u ticks, %u mismatches\n", ticks, mismatches);
#ifdef __AVR__
    while (!(UCSR0A & (1 << TXC0))) {
    }
    cli();
    sleep_enable();
    sleep_cpu();
#endif
    return mismatches != 0;
}
