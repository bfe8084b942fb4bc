// A robot on Cyclone DDS: publishes a sonar's ranges and odometry at 50 Hz under names of ROS 2, and obeys Twist.
//
//     peer DOMAIN NAMESPACE [best_effort|master]
//
// A master is a publisher of commands, too, that says nothing.
//
// Prints `sent TOPIC HEX` for the first message of each topic, then `ready`, and `got cmd_vel HEX X Z` for each Twist
// unlike the last. Ends with 0 after the first that moves, with 1 where none came within 300 s.
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dds/dds.h"
#include "dds/ddsi/ddsi_serdata.h"
#include "messages.h"

enum { LONGEST = 4096, NAME = 256 };

// What is in a serialized message, as hexadecimal digits.
static void hex(struct ddsi_serdata *message, char *text) {
    unsigned char bytes[LONGEST];
    const uint32_t size = ddsi_serdata_size(message);
    if (size > LONGEST) abort();
    ddsi_serdata_to_ser(message, 0, size, bytes);
    for (uint32_t i = 0; i < size; ++i) sprintf(text + 2 * i, "%02x", bytes[i]);
}

static dds_entity_t topic(dds_entity_t of, const dds_topic_descriptor_t *type, const char *space, const char *name) {
    char full[NAME];
    snprintf(full, sizeof full, "rt%s/%s", space, name);
    return dds_create_topic(of, type, full, NULL, NULL);
}

// Prints the first message of a topic as it goes out: what a reader here is handed is the bytes that all are sent.
static void say(dds_entity_t of, dds_entity_t writer, const char *space, const char *name, const void *sample) {
    static char text[2 * LONGEST + 1];
    const dds_entity_t reader = dds_create_reader(of, dds_get_topic(writer), NULL, NULL);
    struct ddsi_serdata *message = NULL;
    dds_sample_info_t info;
    dds_write(writer, sample);
    if (dds_takecdr(reader, &message, 1, &info, DDS_ANY_STATE) != 1) abort();
    hex(message, text);
    printf("sent %s/%s %s\n", space, name, text);
    ddsi_serdata_unref(message);
    dds_delete(reader);
}

// Prints the commands that came; whether one of them moves.
static bool obey(dds_entity_t reader) {
    static char last[2 * LONGEST + 1];
    char text[2 * LONGEST + 1];
    bool moved = false;
    struct ddsi_serdata *message = NULL;
    dds_sample_info_t info;
    while (dds_takecdr(reader, &message, 1, &info, DDS_ANY_STATE) == 1) {
        geometry_msgs_msg_dds__Twist_ twist;
        if (info.valid_data && ddsi_serdata_to_sample(message, &twist, NULL, NULL)) {
            hex(message, text);
            if (strcmp(text, last) != 0) printf("got cmd_vel %s %g %g\n", text, twist.linear.x, twist.angular.z);
            strcpy(last, text);
            moved = moved || twist.linear.x != 0 || twist.angular.z != 0;
        }
        ddsi_serdata_unref(message);
    }
    fflush(stdout);
    return moved;
}

int main(int count, char **given) {
    if (count < 3) return fprintf(stderr, "peer DOMAIN NAMESPACE [best_effort|master]\n"), 2;
    const char *space = given[2];
    const bool best_effort = count > 3 && strcmp(given[3], "best_effort") == 0;
    const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(given[1]), NULL, NULL);
    if (participant < 0) return fprintf(stderr, "the domain cannot be joined\n"), 2;
    dds_qos_t *quality = dds_create_qos();
    dds_qset_history(quality, DDS_HISTORY_KEEP_LAST, 5);
    dds_qset_reliability(quality, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    const dds_entity_t commands = topic(participant, &geometry_msgs_msg_dds__Twist__desc, space, "cmd_vel");
    const dds_entity_t reader = dds_create_reader(participant, commands, quality, NULL);
    if (count > 3 && strcmp(given[3], "master") == 0) dds_create_writer(participant, commands, quality, NULL);
    if (best_effort) dds_qset_reliability(quality, DDS_RELIABILITY_BEST_EFFORT, 0);
    const dds_entity_t sonar = topic(participant, &sensor_msgs_msg_dds__Range__desc, space, "sonar");
    const dds_entity_t odom = topic(participant, &nav_msgs_msg_dds__Odometry__desc, space, "odom");
    const dds_entity_t ranges = dds_create_writer(participant, sonar, quality, NULL);
    const dds_entity_t odometries = dds_create_writer(participant, odom, quality, NULL);
    dds_delete_qos(quality);

    const sensor_msgs_msg_dds__Range_ range = {{{12, 34}, "sonar"}, 0, 0.25F, 0.125F, 3.0F, 2.0F, 0.5F};
    const nav_msgs_msg_dds__Odometry_ odometry = {
        {{12, 34}, "odom"},
        "base_link",
        {{{1.0, -2.0, 0.0}, {0.0, 0.0, 0.6, 0.8}}, {0.125}},
        {{{0.5, 0.0, 0.0}, {0.0, 0.0, -0.25}}, {0.0, 0.25}},
    };
    say(participant, ranges, space, "sonar", &range);
    say(participant, odometries, space, "odom", &odometry);
    printf("ready\n");
    bool moved = false;
    for (int sent = 0; sent < 15000 && !moved; ++sent) {
        dds_write(ranges, &range);
        dds_write(odometries, &odometry);
        dds_sleepfor(DDS_MSECS(20));
        moved = obey(reader);
    }
    dds_delete(participant);
    return moved ? 0 : 1;
}
