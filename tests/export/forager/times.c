/* Times of a pulse of the exported forager beside the one written by hand, on the same readings. */

#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <string.h>

#include "by_hand.h"
#include "forage.h"

#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#define PULSES 3000
static int put_character(char c, FILE *s) { (void)s; while (!(UCSR0A & (1 << UDRE0))) {} UDR0 = (uint8_t)c; return 0; }
#elif !defined(__arm__)
#include <time.h>
#endif

static uint32_t mix(uint32_t x)
{
    x ^= x >> 16; x *= 0x7feb352dUL; x ^= x >> 15; x *= 0x846ca68bUL; x ^= x >> 16;
    return x;
}

static void draw(uint32_t tick, forage_readings *r)
{
    static const real ranges[] = {0.2f, 0.4f, 1.0f, 5.0f}, amounts[] = {0.0f, 3.0f, 12.0f};
    const uint32_t bits = mix(tick);
    r->range_nearest_food = ranges[bits & 3];
    r->bearing_nearest_food = (real)(bits >> 2 & 255) * (real)0.0245;
    r->food_left = (int8_t)(bits >> 10 & 1);
    r->food_stored = amounts[(bits >> 11 & 31) % 3];
    r->food_here = amounts[(bits >> 16 & 31) % 3];
    r->range_station = ranges[bits >> 21 & 3];
    r->bearing_station = (real)(bits >> 23 & 255) * (real)0.0245;
    r->station_here = (int8_t)(bits >> 31);
}

static void copy(const forage_readings *r, hand_readings *h)
{
    h->range_food = r->range_nearest_food; h->bearing_food = r->bearing_nearest_food;
    h->food_left = r->food_left; h->food_stored = r->food_stored; h->food_here = r->food_here;
    h->range_station = r->range_station; h->bearing_station = r->bearing_station; h->at_station = r->station_here;
}

static forage_machine machine;
static hand by_hand;

#if defined(__arm__)
/* On an emulated Cortex-M3: QEMU with -icount lets the same time pass in every instruction, and SysTick measures it. */
#define PULSES 3000
#define SYSTICK_CONTROL (*(volatile uint32_t *)0xE000E010)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xE000E014)
#define SYSTICK_NOW (*(volatile uint32_t *)0xE000E018)
#define NOPS 1000
static uint32_t passed(uint32_t begin) { return (begin - SYSTICK_NOW) & 0xFFFFFF; } /* it counts down */
int main(void)
{
    forage_readings r; hand_readings h; forage_commands c; hand_commands d;
    double sum[2] = {0, 0}, most[2] = {0, 0}; long different = 0;
    uint32_t begin, nothing, nops;
    SYSTICK_RELOAD = 0xFFFFFF; SYSTICK_NOW = 0; SYSTICK_CONTROL = 5;
    begin = SYSTICK_NOW; nothing = passed(begin);
    begin = SYSTICK_NOW; __asm__ volatile(".rept 1000\n nop\n .endr"); nops = passed(begin) - nothing;
    forage_start(&machine, 0);
    for (uint32_t tick = 0; tick < PULSES; tick++) {
        double counted[2]; uint8_t a; int b;
        draw(tick, &r); copy(&r, &h);
        begin = SYSTICK_NOW; a = forage_step(&machine, &r, tick * 100, &c); counted[0] = passed(begin);
        begin = SYSTICK_NOW; b = hand_step(&by_hand, &h, &d); counted[1] = passed(begin);
        for (int of = 0; of < 2; of++) {
            counted[of] = (counted[of] - nothing) * NOPS / nops;
            sum[of] += counted[of];
            if (counted[of] > most[of]) most[of] = counted[of];
        }
        different += a != b;
    }
    printf("exported: mean %ld, most %ld instructions; by hand: mean %ld, most %ld instructions; %ld decided otherwise\n",
           (long)(sum[0] / PULSES + 0.5), (long)(most[0] + 0.5), (long)(sum[1] / PULSES + 0.5), (long)(most[1] + 0.5),
           different);
    return 0;
}
#elif defined(__AVR__)
int main(void)
{
    static FILE out;
    forage_readings r; hand_readings h; forage_commands c; hand_commands d;
    uint32_t sum[2] = {0, 0}; uint16_t most[2] = {0, 0}, different = 0, tick;
    fdev_setup_stream(&out, put_character, NULL, _FDEV_SETUP_WRITE);
    stdout = &out; UBRR0 = 0; UCSR0B = 1 << TXEN0;
    TCCR1A = 0; TCCR1B = 1; /* counts every cycle */
    forage_start(&machine, 0);
    for (tick = 0; tick < PULSES; tick++) {
        uint16_t begin, cycles; uint8_t a; int b;
        draw(tick, &r); copy(&r, &h);
        begin = TCNT1; a = forage_step(&machine, &r, (uint32_t)tick * 100, &c); cycles = TCNT1 - begin;
        sum[0] += cycles; if (cycles > most[0]) most[0] = cycles;
        begin = TCNT1; b = hand_step(&by_hand, &h, &d); cycles = TCNT1 - begin;
        sum[1] += cycles; if (cycles > most[1]) most[1] = cycles;
        different += a != b;
    }
    printf("exported: mean %lu, most %u cycles; by hand: mean %lu, most %u cycles; %u decided otherwise\n",
           (unsigned long)(sum[0] / PULSES), most[0], (unsigned long)(sum[1] / PULSES), most[1], different);
    while (!(UCSR0A & (1 << TXC0))) {}
    cli(); sleep_enable(); sleep_cpu();
    return 0;
}
#else
#define ROWS 4096
static double seconds(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec; }
int main(void)
{
    static forage_readings rows[ROWS]; static hand_readings hand_rows[ROWS];
    forage_commands c; hand_commands d; long different = 0; double best[2] = {1e9, 1e9}; volatile unsigned long sink = 0;
    for (uint32_t i = 0; i < ROWS; i++) { memset(&rows[i], 0, sizeof rows[i]); draw(i, &rows[i]); copy(&rows[i], &hand_rows[i]); }
    forage_start(&machine, 0);
    for (int i = 0; i < ROWS; i++)
        different += forage_step(&machine, &rows[i], i, &c) != hand_step(&by_hand, &hand_rows[i], &d);
    for (int round = 0; round < 40; round++) {
        double begin = seconds();
        for (int k = 0; k < 50; k++) for (int i = 0; i < ROWS; i++) sink += forage_step(&machine, &rows[i], i, &c);
        double passed = (seconds() - begin) / (50.0 * ROWS);
        if (passed < best[0]) best[0] = passed;
        begin = seconds();
        for (int k = 0; k < 50; k++) for (int i = 0; i < ROWS; i++) sink += (unsigned long)hand_step(&by_hand, &hand_rows[i], &d);
        passed = (seconds() - begin) / (50.0 * ROWS);
        if (passed < best[1]) best[1] = passed;
    }
    printf("exported: %.1f ns; by hand: %.1f ns; ratio %.2f; %ld decided otherwise\n", best[0] * 1e9, best[1] * 1e9, best[0] / best[1], different);
    return 0;
}
#endif
