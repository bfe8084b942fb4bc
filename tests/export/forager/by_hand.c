/* The forager of the fixture as a person would write it: one switch per automaton, for times to compare with. */

#include "by_hand.h"

enum { START, FORWARD, LEFT, RIGHT, DONE };

static int go(uint8_t *state, real range, real bearing)
{
    switch (*state) {
    case START:
        if (bearing == bearing)
            *state = bearing >= R(3.4065198477185508) && bearing < R(4.65384841627227) ? RIGHT : LEFT;
        break;
    case FORWARD:
        if (range < R(0.3670864537489725))
            *state = DONE;
        else if (range == range && bearing >= R(3.1711775459560663) && bearing < R(5.650504578827751))
            *state = RIGHT;
        else if (range == range && bearing >= R(0.6465626592777696) && bearing < R(3.4525254802123566))
            *state = LEFT;
        break;
    case LEFT:
        if (bearing >= R(4.014440792723543) || bearing < R(0.14393975916808582))
            *state = FORWARD;
        break;
    case RIGHT:
        if (bearing >= R(6.149156644571461) || bearing < R(1.9421808070885374))
            *state = FORWARD;
        break;
    default:
        break;
    }
    return *state == DONE ? 0 : *state;
}

static int harvest(hand *m, const hand_readings *r)
{
    switch (m->task) {
    case 0:
        if (r->food_here < R(0.5)) {
            m->task = 1;
            m->going = START;
        } else if (r->food_stored == r->food_stored && r->food_here == r->food_here) {
            m->task = r->food_stored < R(11.0) ? 2 : 3;
        }
        break;
    case 1:
        if (m->going == DONE)
            m->task = 2;
        break;
    case 2:
        if (r->food_here < R(0.5)) {
            if (r->food_left == 0) {
                m->task = 3;
            } else if (r->food_left == 1) {
                m->task = 1;
                m->going = START;
            }
        } else if (r->food_here == r->food_here && r->food_stored >= R(11.5)) {
            m->task = 3;
        }
        break;
    default:
        break;
    }
    return m->task == 1 ? go(&m->going, r->range_food, r->bearing_food) : m->task == 2 ? 4 : 0;
}

static int deposit(hand *m, const hand_readings *r)
{
    switch (m->task) {
    case 0:
        m->task = 1;
        m->going = START;
        break;
    case 1:
        if (m->going == DONE)
            m->task = 2;
        break;
    case 2:
        if (r->at_station == 0) {
            m->task = 1;
            m->going = START;
        } else if (r->at_station == 1 && r->food_stored < R(0.5)) {
            m->task = 3;
        }
        break;
    default:
        break;
    }
    return m->task == 1 ? go(&m->going, r->range_station, r->bearing_station) : m->task == 2 ? 5 : 0;
}

int hand_step(hand *m, const hand_readings *r, hand_commands *commands)
{
    int basic;
    if (m->phase == 0) {
        m->phase = 1;
        m->task = 0;
    } else if (m->task == 3) {
        m->phase = m->phase == 1 ? 2 : 1;
        m->task = 0;
    }
    basic = m->phase == 1 ? harvest(m, r) : deposit(m, r);
    commands->drive = commands->turn = commands->load = commands->unload = 0;
    switch (basic) {
    case 1:
        commands->drive = 1;
        break;
    case 2:
        commands->turn = 1;
        break;
    case 3:
        commands->turn = -1;
        break;
    case 4:
        commands->load = 1;
        break;
    case 5:
        commands->unload = 1;
        break;
    default:
        break;
    }
    return basic;
}
