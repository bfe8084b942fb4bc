#include <math.h>
#include <stdint.h>

#ifdef SINGLE
typedef float real;
#define R(x) x##f
#else
typedef double real;
#define R(x) x
#endif

typedef struct {
    uint8_t phase, task, going;
} hand;

typedef struct {
    real range_food, bearing_food;
    real food_stored, food_here;
    real range_station, bearing_station;
    int8_t food_left, at_station;
} hand_readings;

typedef struct {
    real drive, turn, load, unload;
} hand_commands;

int hand_step(hand *m, const hand_readings *r, hand_commands *commands);
