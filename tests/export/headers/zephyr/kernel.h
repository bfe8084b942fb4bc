/* Stands in for Zephyr's: declares what the exported program calls. */
#include <stdint.h>
uint32_t k_uptime_get_32(void);
int64_t k_uptime_get(void);
int32_t k_msleep(int32_t ms);
