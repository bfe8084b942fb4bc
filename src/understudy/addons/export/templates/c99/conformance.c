/* Runs $name on the rows of conformance.csv, and compares what it decides with what Understudy decided.
   With --trace it prints what it decided instead, for `understudy export why`. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "$name.h"

#define LONGEST_LINE 65536

static char *next_field(char **rest)
{
    char *field = *rest;
    char *end = field + strcspn(field, ",\r\n");
    *rest = *end == ',' ? end + 1 : end;
    *end = '\0';
    return field;
}

#define READ_REAL(member) \
    do { \
        const char *field = next_field(&rest); \
        readings.member = *field ? $parse(field, NULL) : ($real)NAN; \
    } while (0)
#define READ_LABEL(member) \
    do { \
        const char *field = next_field(&rest); \
        readings.member = (${name}_label)(*field ? atoi(field) : -1); \
    } while (0)
#define CHECK_REAL(member) right &= $parse(next_field(&rest), NULL) == commands.member

static int check_list(const char *expected, const uint8_t *found, uint8_t levels, int offset)
{
    for (uint8_t level = 0; level < levels; level++) {
        char *end;
        if (strtol(expected, &end, 10) != (long)found[level] + offset)
            return 0;
        expected = *end == '.' ? end + 1 : end;
    }
    return *expected == '\0';
}

#ifdef ${NAME}_TRACE
static void print_trace(const char *time, const ${name}_machine *machine)
{
    printf("%s", time);
    for (uint8_t level = 0; level < machine->traced; level++)
        printf(",%d.%d.%d.%d", machine->trace[level].automaton, machine->trace[level].before,
               machine->trace[level].leaf, machine->trace[level].after);
    printf("\n");
}
#endif

int main(int count, char **arguments)
{
    static char line[LONGEST_LINE];
    static ${name}_machine machine;
    ${name}_readings readings;
    ${name}_commands commands;
    long ticks = 0, mismatches = 0;
    const int tracing = count > 1 && strcmp(arguments[1], "--trace") == 0;
    FILE *file = fopen("conformance.csv", "r");
    if (file == NULL || fgets(line, sizeof line, file) == NULL) {
        fprintf(stderr, "conformance.csv cannot be read\n");
        return 2;
    }
#ifdef ${NAME}_TRACE
    if (tracing)
        printf("%s\n", ${NAME}_TRACE_HEADER);
#endif
    while (fgets(line, sizeof line, file) != NULL) {
        char *rest = line;
        uint8_t path[${NAME}_LEVELS], flags[${NAME}_LEVELS], levels, basic;
        int right;
        const int starts = atoi(next_field(&rest));
        const char *time = next_field(&rest);
        const ${name}_time now = $parse_time;
        memset(&readings, 0, sizeof readings);
$read
        if (starts)
            ${name}_start(&machine, now);
        basic = ${name}_step(&machine, &readings, now, &commands);
        levels = ${name}_path(&machine, path, flags);
        right = check_list(next_field(&rest), path, levels, 0);
        right &= check_list(next_field(&rest), flags, levels, 0);
        right &= atoi(next_field(&rest)) == (int)basic;
$check
        ticks++;
        if (!right) {
            mismatches++;
            if (mismatches <= 5)
                fprintf(stderr, "line %ld of conformance.csv is decided otherwise\n", ticks + 1);
        }
#ifdef ${NAME}_TRACE
        if (tracing)
            print_trace(time, &machine);
#endif
    }
    fclose(file);
    if (!tracing)
        printf("%ld ticks, %ld mismatches\n", ticks, mismatches);
    return mismatches || !ticks;
}
