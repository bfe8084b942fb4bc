// What a program in C does at best on Cyclone DDS: it answers each Range with a Twist, ahead where it is farther than
// 1 m, else turning. It decides nothing more, limits nothing and guards nothing.
//
//     echo DOMAIN NAMESPACE
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

#include "dds/dds.h"
#include "echo.h"

int main(int count, char **given) {
    if (count < 3) return fprintf(stderr, "echo DOMAIN NAMESPACE\n"), 2;
    char sonar[256], commands[256];
    snprintf(sonar, sizeof sonar, "rt%s/sonar", given[2]);
    snprintf(commands, sizeof commands, "rt%s/cmd_vel", given[2]);
    const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(given[1]), NULL, NULL);
    if (participant < 0) return fprintf(stderr, "the domain cannot be joined\n"), 2;
    dds_qos_t *quality = dds_create_qos();
    dds_qset_reliability(quality, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    const dds_entity_t in = dds_create_topic(participant, &sensor_msgs_msg_dds__Range__desc, sonar, NULL, NULL);
    const dds_entity_t out = dds_create_topic(participant, &geometry_msgs_msg_dds__Twist__desc, commands, NULL, NULL);
    const dds_entity_t reader = dds_create_reader(participant, in, NULL, NULL);
    const dds_entity_t writer = dds_create_writer(participant, out, quality, NULL);
    const dds_entity_t waits = dds_create_waitset(participant);
    dds_waitset_attach(waits, dds_create_readcondition(reader, DDS_ANY_STATE), 0);
    printf("ready\n"), fflush(stdout);
    for (;;) {
        dds_waitset_wait(waits, NULL, 0, DDS_INFINITY);
        void *range = NULL;
        dds_sample_info_t info;
        while (dds_take(reader, &range, &info, 1, 1) == 1) {
            const bool far = info.valid_data && ((sensor_msgs_msg_dds__Range_ *)range)->range > 1.0F;
            const geometry_msgs_msg_dds__Twist_ twist = {{far ? 0.4 : 0, 0, 0}, {0, 0, far ? 0 : 1.0}};
            if (info.valid_data) dds_write(writer, &twist);
            dds_return_loan(reader, &range, 1);
        }
    }
}
