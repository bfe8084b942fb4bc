// Runs $name on an Arduino: where the comments say so, put in your sensors and motors.

#include "$name.h"

static ${name}_machine machine;
static ${name}_readings readings;
static ${name}_commands commands;
static unsigned long last;

void setup()
{
    ${name}_start(&machine, $arduino_now);
}

void loop()
{
    if (millis() - last < ${NAME}_TICK_MS)
        return;
    last += ${NAME}_TICK_MS;
    ${name}_clear_readings(&readings);  // everything is absent
    // Your sensors. What stays absent is a reading without an answer.
$arduino_readings
    ${name}_step(&machine, &readings, $arduino_now, &commands);
    // Your motors.
$arduino_commands
}
